// Whether a cell is drawn by its stand-in, by its error or by what the picture is wanted to err, and whether its
// primitives cost less.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "farfield/cost_model.hpp"
#include "farfield/drawables.hpp"
#include "farfield/frame/cell_tolerance.hpp"
#include "farfield/frame/subtree.hpp"
#include "farfield/geometry/mixed.hpp"
#include "farfield/hierarchy/node.hpp"
#include "farfield/view/local_view.hpp"
#include "farfield/wanted_error.hpp"

namespace farfield::detail {

/// A hierarchy that a frame has entered: the outermost one, or an instance. Everything is borrowed.
template <class H, class P>
struct Entered {
    using hierarchy_type = H;
    using primitive_type = P;
    const H& hierarchy;
    Source<P> source;
    const LocalView& view;
    std::uint64_t path;  ///< as CellId's
};

/// Of an instance, by its index among the primitives.
template <class E>
std::uint64_t path_inside(const E& outer, std::uint64_t primitive) {
    return mixed(outer.path, primitive + 1);
}
template <class E, class Placed>
LocalView view_inside(const E& outer, const Placed& instance, std::uint64_t path) {
    LocalView inner = outer.view.inside(instance.to_world, outer.hierarchy.origin(), instance.hierarchy->origin());
    inner.seed = std::uint32_t(path >> 32);
    return inner;
}

/// The error of the stand-in that the subtree has, that of levels which it replaces included.
template <class E>
float stand_in_error_px(const E& e, const Subtree& subtree) {
    const auto& data = e.hierarchy.stand_ins()[subtree.stand_in];
    return e.hierarchy.approximation_policy().error_px(data, subtree.cell, e.view) *
           error_of_replaced_levels(e.hierarchy.nodes()[subtree.node]);
}

template <class E>
bool may_stand_in(const E& e, const Subtree& subtree) {
    // A tolerance of 0 means every primitive, also of a cell without extent.
    return subtree.has_stand_in() && e.view.tolerance_px > 0 &&
           stand_in_error_px(e, subtree) <= cell_tolerance(e.view, e.path, subtree.node);
}

/// How much of a cell that may stand in is what replaces it (View::fade).
template <class E>
float part_replaced(const E& e, const Subtree& subtree) {
    const Node& node = e.hierarchy.nodes()[subtree.node];
    // What is drawn by primitives alone comes at once.
    if (node.stand_in_levels_below == Node::nothing_below || node.stand_in_levels_below == 0) return 0;
    const float error = stand_in_error_px(e, subtree);
    const float tolerance = cell_tolerance(e.view, e.path, subtree.node), first = tolerance * (1 - e.view.fade);
    return error > first ? std::min((error - first) / (tolerance - first), 1.0f) : 0.0f;
}

template <class E>
bool errs_no_more_than_wanted(const E& e, float covered, float side_px) {
    const float rmse = e.hierarchy.approximation_policy().expected_rmse(side_px, covered);
    return rmse <= largest_rmse(e.view.wanted, side_px, covered);
}
template <class E>
float covered_part(const E& e, const Subtree& subtree) {
    const auto& data = e.hierarchy.stand_ins()[subtree.stand_in];
    return e.hierarchy.approximation_policy().covered_part(data, subtree.cell, e.view);
}
/// Finite, so that errors are.
template <class E>
float side_px(const E& e, const Subtree& subtree) {
    return std::min(e.view.pixels(subtree.cell.largest_side(), e.view.distance_to(subtree.cell)), 0x1p20f);
}

/// Where nothing is known of errors, whatever the tolerance allows is good.
template <class E>
bool keeps_wanted_error(const E& e, const Subtree& subtree) {
    if constexpr (E::hierarchy_type::approximation_type::facts.expects_error) {
        return e.view.wanted.is_any() ||
               errs_no_more_than_wanted(
                   e, covered_part(e, subtree),
                   side_px(e, subtree) * error_of_replaced_levels(e.hierarchy.nodes()[subtree.node]));
    } else {
        return true;
    }
}

/// Whether point sampling the subtree's primitives costs less than the stand-ins that would be drawn for it: four times
/// as many a level, as of a surface, down to cells that are small enough by the tolerance and, from near to these on,
/// by what they are expected to err, if they are covered as this one is. (The contents of a tree's crown are the
/// thinner the smaller the cells.) For three cells that are drawn four are visited. Twice their price counts: that of a
/// primitive is what drawing one costs, and many a point sampled one meets no sample.
template <class E>
bool is_cheaper_exactly(const E& e, const Subtree& subtree) {
    if (!e.view.wanted.is_point_sampling()) return false;
    const Node& node = e.hierarchy.nodes()[subtree.node];
    const std::uint32_t items = subtree.end_item - node.first_item;
    if (node.child_mask == 0) return false;
    if (subtree.crossed_planes != 0 && items > max_items_unculled) return false;
    const auto price = [&](const Work& work) { return e.hierarchy.cost_policy().cost(work); };
    const float exact = price({.triangles = float(items), .runs = 1});
    const float stand_in = 2 * price({.splats = 1, .cells = 4.0f / 3});
    float cost = float(bits_set[node.child_mask]) * stand_in, side = 0.5f * side_px(e, subtree);
    const bool is_near = side <= e.view.tolerance_px;
    for (; cost < exact && side > e.view.tolerance_px; side *= 0.5f) cost *= 4;
    if constexpr (E::hierarchy_type::approximation_type::facts.expects_error) {
        if (is_near && cost < exact && subtree.has_stand_in()) {
            const float covered = covered_part(e, subtree);
            for (; cost < exact && !errs_no_more_than_wanted(e, covered, side); side *= 0.5f) cost *= 4;
        }
    }
    return cost >= exact;
}

}  // namespace farfield::detail
