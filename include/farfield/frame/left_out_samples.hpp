// Where samples are left out: above cells that all stand in. A stop's stand-in shows all of its cell as well as the
// rest that samples leave of it, and where no renderer could tell polygons so small, those that cells just above the
// stops hold are most of what such a frame would draw.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <concepts>

#include "farfield/approximation.hpp"
#include "farfield/frame/stand_in_choice.hpp"
#include "farfield/frame/subtree.hpp"
#include "farfield/geometry/visit_order.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield::detail {

/// leaves_out_samples() says whether polygons as small as the view's tolerance are noise; is_in_children() what
/// SampledCell says, and left() its `left`, in whatever unit. with_more_left(data, more) is the stand-in of a cell of
/// which samples above have drawn less by that.
template <class A>
concept LeavesOutSamples = requires(const A& a, const typename A::stand_in_data& data, const LocalView& view) {
    { a.leaves_out_samples(view, 0.0f) } -> std::same_as<bool>;
    { a.is_in_children(data) } -> std::same_as<bool>;
    { a.left(data) } -> std::same_as<float>;
    { a.with_more_left(data, 0.0f) } -> std::same_as<typename A::stand_in_data>;
};

/// Levels above stops at which samples are left out. A level has a quarter of what the one below holds.
inline constexpr unsigned levels_without_samples = 2;

template <class E>
float part_opened_below(const E& e, const Subtree& subtree, unsigned levels);

/// What is drawn of a cell that is not in cells of at most `levels` below it that stand in, as a part of it.
template <class E>
float part_opened(const E& e, const Subtree& subtree, unsigned levels) {
    const float replaced = subtree.has_stand_in() && e.view.tolerance_px > 0 ? part_replaced(e, subtree) : 1.0f;
    if (levels == 0 || replaced == 0) return replaced;
    return std::min(replaced, part_opened_below(e, subtree, levels));
}

/// The largest of these parts of cells below one that are in sight: 0 where all that lies in it stands in, 1 where
/// some of it does not, and between where stand-ins fade. It is continuous in the view, as they are.
template <class E>
float part_opened_below(const E& e, const Subtree& subtree, unsigned levels) {
    const auto& h = e.hierarchy;
    const auto& policy = h.approximation_policy();
    const Node& node = h.nodes()[subtree.node];
    if constexpr (PagedAtRunTime<typename E::hierarchy_type>) {
        if (h.is_portal(node)) return 1;  // what lies elsewhere may be missing
    }
    if (!subtree.has_stand_in() || node.child_mask == 0) return 1;
    if (!policy.is_in_children(h.stand_ins()[subtree.stand_in])) return 1;
    if constexpr (E::hierarchy_type::approximation_type::facts.bounds_error) {
        if (policy.least_error_px(subtree.cell, levels, e.view) > e.view.tolerance_px) return 1;
    }
    float part = 0;
    for_each_child<VisitOrder::any>(h, subtree, e.view.viewpoint(), [&](Subtree& child) {
        if (part == 1 || is_outside(e.view.planes, child)) return;
        part = std::max(part, part_opened(e, child, levels - 1));
    });
    return part;
}

/// The stand-in that a subtree has, as it is drawn.
template <class H>
decltype(auto) stand_in_drawn(const H& h, const Subtree& subtree) {
    using A = typename H::approximation_type;
    const auto& data = h.stand_ins()[subtree.stand_in];
    if constexpr (LeavesOutSamples<A>) {
        using Data = typename A::stand_in_data;
        if (subtree.left_out == 0) return Data(data);
        return Data(h.approximation_policy().with_more_left(data, subtree.left_out));
    } else {
        return (data);
    }
}

}  // namespace farfield::detail
