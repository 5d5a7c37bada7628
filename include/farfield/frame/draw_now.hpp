// This sink of a descent, or of a selection, draws at once.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <type_traits>

#include "farfield/approximation.hpp"
#include "farfield/drawables.hpp"
#include "farfield/frame/contents_box.hpp"
#include "farfield/frame/draw_queue.hpp"
#include "farfield/frame/left_out_samples.hpp"
#include "farfield/frame/selection.hpp"
#include "farfield/frame/source_table.hpp"
#include "farfield/frame/subtree.hpp"
#include "farfield/geometry/area_law.hpp"
#include "farfield/geometry/visit_order.hpp"

namespace farfield {

/// Stand-ins keep their colors.
struct AsTheyAre {};

namespace detail {

/// The opacity of a part of something. No part of what is strewn leaves something of what is opaque, so little is left.
inline float part_of_opacity(float opacity, float part, AreaLaw law) {
    return opacity_of_part(law == AreaLaw::independent ? std::min(opacity, 0.98f) : opacity, part, law);
}

/// Borrows queue and renderer. `Tint` is AsTheyAre, or something called with a Subtree that gives the color, not
/// premultiplied, which its stand-in is drawn in; opacity stays.
template <class R, class Tint = AsTheyAre>
class DrawNow {
  public:
    DrawNow(R& renderer, DrawQueue<R>& queue, const Tint& tint) : renderer_(renderer), queue_(queue), tint_(tint) {}

    template <class V>
    void enter(const V& v) {
        queue_.set_view(v.view);
    }
    template <class V>
    void leave(const V& v) {
        queue_.flush(v.source);
    }
    template <class V>
    void enter_instance(const V& v, std::uint32_t) {
        queue_.flush(v.source);
    }
    template <class V>
    void leave_instance(const V& v) {
        queue_.set_view(v.view);
    }
    template <class V>
    void run(const V& v, const Subtree&, std::uint32_t first, std::uint32_t end, std::optional<AreaLaw> law) {
        queue_.add_run(v.source, first, end, law);
    }
    template <class V>
    void stand_in(const V& v, const Subtree& subtree, float weight = 1) {
        const auto& h = v.hierarchy;
        using A = typename V::hierarchy_type::approximation_type;
        if constexpr (DrawsPlaced<A> && std::is_same_v<Tint, AsTheyAre>) {
            const A& policy = h.approximation_policy();
            bool is_placed = queue_.splat_limit_px() > 0 && weight == 1;
            if constexpr (requires { policy.places(v.view, 0.0f); }) {
                is_placed = is_placed && policy.places(v.view, queue_.splat_limit_px());
            } else if constexpr (requires { policy.places(subtree.cell, v.view, 0.0f); }) {
                is_placed = is_placed && policy.places(subtree.cell, v.view, queue_.splat_limit_px());
            }
            if (is_placed) {
                return queue_.add_placed(v.source, v.view, policy, stand_in_drawn(h, subtree), subtree.cell);
            }
        }
        const StandInSink<V> sink{*this, v, subtree, queue_.splat_limit_px(), weight};
        draw_stand_in(h.approximation_policy(), stand_in_drawn(h, subtree), h.pool(), subtree.cell, v.view, sink);
    }
    /// All of the picture is covered that its box may cover, as opaque as its contents are in there: a stand-in is made
    /// to be small and seen from outside. A splat at a depth behind the eye would be a hole, and large ones of the
    /// right area leave gaps beside one another.
    template <class V>
    void stand_in_for_missing(const V& v, const Subtree& subtree, float weight) {
        using A = typename V::hierarchy_type::approximation_type;
        if constexpr (R::facts.draws_splats && TellsContentsBox<A>) {
            if (queue_.splat_limit_px() > 0) {
                const auto& h = v.hierarchy;
                const Box reach = reach_of(h, subtree);
                const auto box =
                    h.approximation_policy().contents_box(stand_in_drawn(h, subtree), subtree.cell, reach, v.view);
                if (const auto splat = splat_over(box, v.view)) {
                    StandInSink<V>{*this, v, subtree, queue_.splat_limit_px(), weight}(*splat);
                    return;
                }
            }
        }
        stand_in(v, subtree, weight);
    }
    template <class V>
    bool hidden(const V& v, const Subtree& subtree) {
        // Runs that wait lie in front of it and may be what hides it.
        if constexpr (R::facts.order == VisitOrder::front_to_back) queue_.flush(v.source);
        return renderer_.hidden(subtree.cell, CellId{v.path, subtree.node});
    }

  private:
    template <class H>
    static Box reach_of(const H& h, const Subtree& subtree) {
        if constexpr (PagedAtRunTime<H>) return h.reach_of(h.nodes()[subtree.node], subtree.cell);
        return subtree.cell.bounds();
    }

    template <class V>
    struct StandInSink {
        DrawNow& to;
        const V& v;
        const Subtree& subtree;
        float splat_limit_px;
        float weight;

        void operator()(Face face) const {
            if constexpr (!std::is_same_v<Tint, AsTheyAre>) {
                const Rgba8 c = to.tint_(subtree);
                face.rgba = premultiplied({c.r, c.g, c.b, face.rgba.a});
            }
            if (weight != 1) {
                const auto fainter = [&](std::uint8_t channel) { return std::uint8_t(float(channel) * weight + 0.5f); };
                face.rgba = {fainter(face.rgba.r), fainter(face.rgba.g), fainter(face.rgba.b), fainter(face.rgba.a)};
            }
            to.queue_.add(v.source, face);
        }
        void operator()(Splat splat) const {
            if constexpr (!std::is_same_v<Tint, AsTheyAre>) {
                const Rgba8 c = to.tint_(subtree);
                splat.rgb = {c.r, c.g, c.b, splat.rgb.a};  // alpha is the law
            }
            if (weight != 1) splat.opacity = part_of_opacity(splat.opacity, weight, AreaLaw(splat.rgb.a));
            to.queue_.add(v.source, splat);
        }
        void operator()(OwnRun run) const {
            const std::uint32_t first = v.hierarchy.nodes()[subtree.node].first_item;
            const std::uint32_t count = std::min(run.count, subtree.end_item - first);
            // The first of a sample are a sample (OwnRun).
            const auto part = std::min(std::uint32_t(std::ceil(float(count) * weight)), count);
            to.queue_.add_run(v.source, first, first + part, std::nullopt);
        }
    };

    R& renderer_;
    DrawQueue<R>& queue_;
    const Tint& tint_;
};

/// Tells a DrawNow what a selection holds, as a descent did when it was selected.
template <class R, class Sink>
struct DrawSelected {
    SourceTable<R>& sources;
    Sink& sink;
    bool deposits;

    template <class H, class Span>
    std::uint32_t source_id(const H& h, const Span& primitives) const {
        return sources.find(h, primitives).id;
    }
    void enter(const auto& entered) { sink.enter(entered); }
    void leave(const auto& entered) { sink.leave(entered); }
    void leave_instance(const auto& entered) { sink.leave_instance(entered); }
    template <class E>
    void operator()(const E& entered, const Selected& s) {
        switch (s.kind) {
            case Selected::Kind::run:
                return sink.run(entered, s.subtree, s.first, s.end, deposits ? s.law : std::nullopt);
            case Selected::Kind::stand_in:
                if constexpr (E::hierarchy_type::approximation_type::facts.stands_in)
                    sink.stand_in(entered, s.subtree, s.weight);
                return;
            case Selected::Kind::instance:
                return sink.enter_instance(entered, s.first);
        }
    }
};

}  // namespace detail
}  // namespace farfield
