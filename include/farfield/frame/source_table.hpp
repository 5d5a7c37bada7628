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
#include "farfield/fail.hpp"
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

/// Throws std::invalid_argument, whose text begins with `who`, if primitives are not as many as a hierarchy was built
/// from, or if strict order is needed and not kept.
template <class H, class P>
void check_source(const char* who, const H& h, std::span<const P> primitives, bool needs_strict_order) {
    if (primitives.size() != h.primitive_count()) {
        detail::fail<std::invalid_argument>(std::string(who) + " was built from " +
                                            std::to_string(h.primitive_count()) + " primitives and is given " +
                                            std::to_string(primitives.size()));
    }
    if (needs_strict_order && !h.keeps_strict_order()) {
        detail::fail<std::invalid_argument>(
            std::string(who) + " does not keep its polygons in strict order, as the renderer needs them, in " +
            std::to_string(h.report().cells_out_of_order) + " cells (BuildReport::cells_out_of_order)");
    }
}
/// Throws std::invalid_argument if a hierarchy from a file was built from other primitives. Looks at all of them.
template <class H, class P>
void check_fingerprint(const char* who, const H& h, std::span<const P> primitives) {
    if (h.is_from_file() && fingerprint_of(primitives) != h.fingerprint()) {
        detail::fail<std::invalid_argument>(std::string(who) + " was built from other primitives, or in another order");
    }
}

/// Uploads sources to the renderer and, when it goes, releases them.
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
        constexpr const char* who = "farfield::Viewer: the hierarchy";
        check_source(who, h, primitives, R::facts.needs_ordering == OrderGuarantee::primitives);
        for (const SourceState& s : sources_) {
            if (s.hierarchy == &h && s.primitives == primitives.data()) return;
        }
        check_fingerprint(who, h, primitives);
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
