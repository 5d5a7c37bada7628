// Where samples are left out: above cells that all stand in. A stop's stand-in shows all of its cell as well as the
// rest that samples leave of it, and where no renderer could tell polygons so small, those that cells just above the
// stops hold are most of what such a frame would draw.
#pragma once

#include "farfield/settings.hpp"

#include <concepts>

#include "farfield/approximation.hpp"
#include "farfield/frame/stand_in_choice.hpp"
#include "farfield/frame/subtree.hpp"
#include "farfield/geometry/visit_order.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield::detail {

/// leaves_out_samples() says whether polygons as small as the view's tolerance are noise; is_in_children() what
/// SampledCell says; with_left_of(data, above) is the stand-in of a cell of which samples were drawn down to a cell
/// above alone.
template <class A>
concept LeavesOutSamples = requires(const A& a, const typename A::stand_in_data& data, const LocalView& view) {
    { a.leaves_out_samples(view, 0.0f) } -> std::same_as<bool>;
    { a.is_in_children(data) } -> std::same_as<bool>;
    { a.with_left_of(data, data) } -> std::same_as<typename A::stand_in_data>;
};

/// Levels above stops at which samples are left out. A level has a quarter of what the one below holds.
inline constexpr unsigned levels_without_samples = 2;

/// Whether all that lies in a cell is in cells of at most `levels` below it that stand in, or is out of sight.
template <class E>
bool all_stand_in_below(const E& e, const Subtree& subtree, unsigned levels) {
    const auto& h = e.hierarchy;
    const auto& policy = h.approximation_policy();
    const Node& node = h.nodes()[subtree.node];
    if constexpr (PagedAtRunTime<typename E::hierarchy_type>) {
        if (h.is_portal(node)) return false;  // what lies elsewhere may be missing
    }
    if (!subtree.has_stand_in() || node.child_mask == 0) return false;
    if (!policy.is_in_children(h.stand_ins()[subtree.stand_in])) return false;
    if constexpr (E::hierarchy_type::approximation_type::facts.bounds_error) {
        if (policy.least_error_px(subtree.cell, levels, e.view) > e.view.tolerance_px) return false;
    }
    bool all = true;
    for_each_child<VisitOrder::any>(h, subtree, e.view.viewpoint(), [&](Subtree& child) {
        if (!all || is_outside(e.view.planes, child)) return;
        all = may_stand_in(e, child) || (levels > 1 && all_stand_in_below(e, child, levels - 1));
    });
    return all;
}

/// The stand-in that a subtree has, as it is drawn.
template <class H>
decltype(auto) stand_in_drawn(const H& h, const Subtree& subtree) {
    using A = typename H::approximation_type;
    const auto& data = h.stand_ins()[subtree.stand_in];
    if constexpr (LeavesOutSamples<A>) {
        using Data = typename A::stand_in_data;
        if (subtree.sampled_above == Subtree::no_stand_in) return Data(data);
        return Data(h.approximation_policy().with_left_of(data, h.stand_ins()[subtree.sampled_above]));
    } else {
        return (data);
    }
}

}  // namespace farfield::detail
