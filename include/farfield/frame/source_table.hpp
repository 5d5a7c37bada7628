// A viewer keeps this of each hierarchy that it may meet: the outermost one and those of instances.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "farfield/composition.hpp"
#include "farfield/hierarchy/fingerprint.hpp"
#include "farfield/primitive.hpp"
#include "farfield/renderer.hpp"

namespace farfield::detail {

struct SourceState {
    const void* hierarchy = nullptr;
    const void* primitives = nullptr;
    std::uint32_t id = 0;                 ///< what the renderer calls it
    std::vector<std::uint32_t> stamps{};  ///< by primitive: the last epoch it was drawn in; shared items only
    std::uint32_t epoch = 0;

    void begin_epoch() {
        if (++epoch != 0) return;
        std::fill(stamps.begin(), stamps.end(), 0u);  // wrapped: every old stamp would look like a new one
        epoch = 1;
    }
    /// The first time in an epoch.
    bool is_new(std::uint32_t primitive) { return std::exchange(stamps[primitive], epoch) != epoch; }
};

template <class H, class P>
Source<P> source_of(const H& h, std::span<const P> primitives, std::uint32_t id) {
    return {primitives, h.order(), h.item_count(), h.origin(), id, h.fragments()};
}

/// Pages sources into the renderer and, when it goes, out again.
template <class R>
class SourceTable {
  public:
    explicit SourceTable(R& renderer) : renderer_(renderer) {}
    ~SourceTable() {
        if constexpr (R::facts.keeps_sources) {
            for (const SourceState& s : sources_) renderer_.release(s.id);
        }
    }
    SourceTable(const SourceTable&) = delete;
    SourceTable& operator=(const SourceTable&) = delete;

    /// A hierarchy, and those of all instances in it. Throws std::invalid_argument if primitives are not those that a
    /// hierarchy was built from, or do not come in the order that the renderer needs.
    template <class H, class P>
    void add_all(const H& h, std::span<const P> primitives) {
        add(h, primitives);
        std::sort(sources_.begin(), sources_.end(), before);
    }

    /// One that was added.
    template <class H, class P>
    SourceState& find(const H& h, std::span<const P> primitives) {
        return *std::lower_bound(sources_.begin(), sources_.end(), SourceState{&h, primitives.data()}, before);
    }

  private:
    static bool before(const SourceState& a, const SourceState& b) {
        const std::less<const void*> less;
        return a.hierarchy != b.hierarchy ? less(a.hierarchy, b.hierarchy) : less(a.primitives, b.primitives);
    }

    template <class H, class P>
    void add(const H& h, std::span<const P> primitives) {
        if (primitives.size() != h.primitive_count()) {
            throw std::invalid_argument("farfield::Viewer: the hierarchy was built from " +
                                        std::to_string(h.primitive_count()) + " primitives and is given " +
                                        std::to_string(primitives.size()));
        }
        if constexpr (R::facts.needs_ordering == OrderGuarantee::primitives) {
            if (!h.keeps_strict_order()) {
                throw std::invalid_argument("farfield::Viewer: the renderer needs polygons in strict order, which " +
                                            std::to_string(h.report().cells_out_of_order) +
                                            " cells of a hierarchy do not keep (BuildReport::cells_out_of_order)");
            }
        }
        for (const SourceState& s : sources_) {
            if (s.hierarchy == &h && s.primitives == primitives.data()) return;
        }
        if (h.is_from_file() && fingerprint_of(primitives) != h.fingerprint()) {
            throw std::invalid_argument(
                "farfield::Viewer: the hierarchy in the file was built from other primitives, or in another order");
        }
        SourceState state{&h, primitives.data()};
        if constexpr (R::facts.keeps_sources) state.id = renderer_.upload(source_of(h, primitives, 0));
        if constexpr (H::assignment == Assignment::shared) state.stamps.assign(primitives.size(), 0);
        sources_.push_back(std::move(state));
        if constexpr (PrimitiveWithInstance<P>) {
            for (const P& p : primitives) {
                primitive_traits<P>::visit_instance(
                    p, [&](const auto& instance) { add(*instance.hierarchy, instance.primitives); });
            }
        }
    }

    R& renderer_;
    std::vector<SourceState> sources_;  ///< sorted once all are added
};

}  // namespace farfield::detail
