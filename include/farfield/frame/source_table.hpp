// A viewer keeps this of each hierarchy that it may meet: the outermost one and those of instances.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "farfield/composition.hpp"
#include "farfield/fail.hpp"
#include "farfield/frame/baked_light.hpp"
#include "farfield/frame/subtree.hpp"
#include "farfield/geometry/mixed.hpp"
#include "farfield/hierarchy/fingerprint.hpp"
#include "farfield/primitive.hpp"
#include "farfield/primitive_source.hpp"
#include "farfield/renderer.hpp"

namespace farfield::detail {

struct SourceState {
    std::uint32_t id = 0;                 ///< what the renderer calls it
    bool is_uploaded = false;             ///< and has to be released
    std::vector<std::uint32_t> stamps{};  ///< by primitive: the last epoch it was drawn in; shared items only
    std::uint32_t epoch = 0;
    bool is_open = false;  ///< while what it holds is added

    void begin_epoch() {
        if (++epoch != 0) return;
        std::fill(stamps.begin(), stamps.end(), 0u);  // wrapped: every old stamp would look like a new one
        epoch = 1;
    }
    /// The first time in an epoch.
    bool is_new(std::uint32_t primitive) { return std::exchange(stamps[primitive], epoch) != epoch; }
};

template <class H, class Span>
Source<PrimitiveIn<Span>> source_of(const H& h, const Span& primitives, std::uint32_t id) {
    return {primitives, h.order(), h.item_count(), h.origin(), id, h.fragments(), PagedAtRunTime<H>};
}

/// Throws std::invalid_argument, whose text begins with `who`, if primitives are not as many as a hierarchy was built
/// from, or if strict order is needed and not kept.
template <class H, class Span>
void check_source(const char* who, const H& h, const Span& primitives, bool needs_strict_order) {
    if (primitives.size() != h.primitive_count()) {
        detail::fail<std::invalid_argument>(std::string(who) + " was built from " +
                                            std::to_string(h.primitive_count()) + " primitives and is given " +
                                            std::to_string(primitives.size()));
    }
    if (needs_strict_order && !h.keeps_strict_order()) {
        detail::fail<std::invalid_argument>(
            std::string(who) + " does not keep its polygons in strict order, as the renderer needs them, in " +
            std::to_string(h.report().cells_out_of_order) + " cells (BuildReport::cells_out_of_order)" +
            (h.report().cells_over_piece_budget != 0
                 ? "; its polygons cross one another all over, and were not cut further: "
                   "raise BuildOptions::most_pieces_per_polygon, or take a renderer that needs no order"
                 : ""));
    }
}
/// Throws std::invalid_argument if a hierarchy was built from other primitives. Looks at all of them, and so only where
/// a hierarchy comes from a file or, as assertions do, where NDEBUG is not defined.
template <class H, class Span>
void check_fingerprint(const char* who, const H& h, const Span& primitives) {
#ifdef NDEBUG
    if (!h.is_from_file()) return;
#endif
    if (fingerprint_of(primitives) != h.fingerprint()) {
        detail::fail<std::invalid_argument>(std::string(who) +
                                            " was built from other primitives, or in another order, or before they "
                                            "were moved");
    }
}

/// What a source is looked up by: where its hierarchy lies, and its primitives.
struct SourceKey {
    const void* hierarchy;
    const void* primitives;
    friend bool operator==(const SourceKey&, const SourceKey&) = default;
};
struct HashOfSourceKey {
    std::size_t operator()(const SourceKey& key) const {
        // One after the other: both come in even steps, and all of their sums could be the same.
        return std::size_t(mixed(mixed(0, std::uint64_t(std::uintptr_t(key.hierarchy))),
                                 std::uint64_t(std::uintptr_t(key.primitives))));
    }
};

/// Uploads sources to the renderer and, when it goes, releases them.
template <class R>
class SourceTable {
  public:
    explicit SourceTable(R& renderer) : renderer_(renderer) {
        if constexpr (R::facts.tells_lifetime) renderer_lifetime_ = renderer.lifetime();
    }
    /// The renderer's.
    float largest_splat_px() const requires(R::facts.draws_splats) { return renderer_.largest_splat_px(); }
    /// Takes over what another renderer's table has checked and uploaded. Returns false, and does nothing, if the
    /// renderers do not share sources or have different lights.
    bool add_all_of(const SourceTable& other) {
        if constexpr (R::facts.keeps_sources && !R::facts.shares_sources) return false;
        other.check_renderer("farfield::Viewer: another");
        if constexpr (R::facts.tells_light) {
            if (renderer_.light() != other.renderer_.light()) return false;
        }
        have_stand_ins_ = other.have_stand_ins_;
        for (const auto& [key, theirs] : other.sources_) {
            SourceState& state = sources_[key];
            state.stamps.assign(theirs.stamps.size(), 0);
            if constexpr (R::facts.shares_sources) {
                state.id = renderer_.share(other.renderer_, theirs.id);
                state.is_uploaded = true;
            }
        }
        return true;
    }
    ~SourceTable() {
        if constexpr (R::facts.keeps_sources) {
            if (!has_renderer()) return;
            for (const auto& [key, state] : sources_) {
                if (state.is_uploaded) renderer_.release(state.id);
            }
        }
    }
    SourceTable(const SourceTable&) = delete;
    SourceTable& operator=(const SourceTable&) = delete;

    /// A hierarchy, and those of all instances in it. Throws std::invalid_argument if primitives are not those that a
    /// hierarchy was built from, or do not come in the order that the renderer needs; if stand-ins have another light
    /// than the renderer; or if a hierarchy holds itself. Takes time in proportion to the number of instances, however
    /// many hierarchies they hold. `turned` is how the hierarchy lies in the outermost one.
    template <class H, class Span>
    void add_all(const H& h, const Span& primitives, const glm::mat3& turned = glm::mat3(1.0f)) {
        constexpr const char* who = "farfield::Viewer: the hierarchy";
        if constexpr (PagedAtRunTime<H>) {
            // It comes with its primitives.
            if constexpr (R::facts.tells_light) check_light(who, h, renderer_.light(), turned);
            return add(h, primitives, [](const auto&) {});
        }
        check_source(who, h, primitives, R::facts.needs_ordering == OrderGuarantee::primitives);
        if (has(h, primitives)) {
            if (!find(h, primitives).is_open) return;
            detail::fail<std::invalid_argument>(std::string(who) + " holds an instance of itself");
        }
        for_instances(primitives, [](const auto& instance, std::size_t i) {
            if (instance.hierarchy != nullptr) return;
            detail::fail<std::invalid_argument>("farfield::Viewer: primitive " + std::to_string(i) +
                                                " is an instance without a hierarchy");
        });
        check_fingerprint(who, h, primitives);
        if constexpr (R::facts.tells_light) check_light(who, h, renderer_.light(), turned);
        add(h, primitives, [&](SourceState& state) {
            state.is_open = true;
            for_instances(primitives, [&](const auto& instance, std::size_t) {
                add_all(*instance.hierarchy, instance.primitives, turned * instance.to_world.rotation());
            });
            state.is_open = false;
        });
    }

    /// Whether any of the hierarchies has a stand-in.
    bool have_stand_ins() const { return have_stand_ins_; }

    template <class H, class Span>
    bool has(const H& h, const Span& primitives) const {
        return sources_.contains(SourceKey{&h, primitives.data()});
    }

    /// One that was added. Throws std::invalid_argument if there is none: instances were changed since.
    template <class H, class Span>
    SourceState& find(const H& h, const Span& primitives) {
        const auto found = sources_.find(SourceKey{&h, primitives.data()});
        if (found == sources_.end()) {
            detail::fail<std::invalid_argument>(
                "farfield::Viewer: an instance holds a hierarchy, or primitives, that it did not when the viewer was "
                "made");
        }
        return found->second;
    }

    /// Throws std::logic_error, whose text begins with `who`, if the renderer is known to be gone.
    void check_renderer(const char* who) const {
        if (!has_renderer()) {
            detail::fail<std::logic_error>(std::string(who) +
                                           ": its renderer is gone; declare the renderer before the viewer");
        }
    }

    /// False if the renderer is known to be gone.
    bool has_renderer() const {
        if constexpr (R::facts.tells_lifetime) return !renderer_lifetime_.expired();
        return true;
    }

  private:
    /// Calls then(state) with what is kept of it from now on.
    template <class H, class Span, class Then>
    void add(const H& h, const Span& primitives, Then&& then) {
        have_stand_ins_ = have_stand_ins_ || !h.stand_ins().empty();
        // References into an unordered_map stay valid while more are added.
        SourceState& state = sources_[SourceKey{&h, primitives.data()}];
        if constexpr (H::assignment == Assignment::shared) state.stamps.assign(primitives.size(), 0);
        if constexpr (R::facts.keeps_sources) {
            state.id = renderer_.upload(source_of(h, primitives, 0));
            state.is_uploaded = true;
        }
        then(state);
    }

    /// Calls f(instance, number of the primitive).
    template <class Span, class F>
    static void for_instances([[maybe_unused]] const Span& primitives, [[maybe_unused]] F&& f) {
        using P = PrimitiveIn<Span>;
        if constexpr (PrimitiveWithInstance<P>) {
            for (std::size_t i = 0; i < primitives.size(); ++i) {
                primitive_traits<P>::visit_instance(primitives[i], [&](const auto& instance) { f(instance, i); });
            }
        }
    }

    R& renderer_;
    std::weak_ptr<const void> renderer_lifetime_;
    bool have_stand_ins_ = false;
    std::unordered_map<SourceKey, SourceState, HashOfSourceKey> sources_;
};

}  // namespace farfield::detail
