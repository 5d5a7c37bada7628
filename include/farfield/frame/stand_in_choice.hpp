// Whether a cell is drawn by its stand-in, by its error or by what the picture is wanted to err, and whether its
// primitives cost less.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "farfield/approximation.hpp"
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

/// That a cell is known by from frame to frame. What lies in pages does not keep its place in memory.
template <class E>
std::uint32_t name_of_node(const E& e, const Subtree& subtree) {
    if constexpr (PagedAtRunTime<std::remove_cvref_t<decltype(e.hierarchy)>>) {
        return e.view.tolerance_jitter == 0 ? 0 : e.hierarchy.name_of(subtree.node);
    } else {
        return subtree.node;
    }
}

template <class E>
bool may_stand_in(const E& e, const Subtree& subtree) {
    // A tolerance of 0 means every primitive, also of a cell without extent.
    return subtree.has_stand_in() && e.view.tolerance_px > 0 &&
           stand_in_error_px(e, subtree) <= cell_tolerance(e.view, e.path, name_of_node(e, subtree));
}

/// How much of a cell that may stand in is what replaces it (View::fade).
template <class E>
float part_replaced(const E& e, const Subtree& subtree) {
    const float error = stand_in_error_px(e, subtree);
    const float tolerance = cell_tolerance(e.view, e.path, name_of_node(e, subtree)),
                first = tolerance * (1 - e.view.fade);
    return error > first ? std::min((error - first) / (tolerance - first), 1.0f) : 0.0f;
}

template <class E>
bool errs_no_more_than_wanted(const E& e, float covered, float side_px) {
    const float rmse = e.hierarchy.approximation_policy().expected_rmse(side_px, covered);
    return rmse <= largest_rmse(e.view.wanted, side_px, covered);
}
template <class E>
float covered_part(const E& e, const Subtree& subtree) {
    const auto& h = e.hierarchy;
    return covered_part(h.approximation_policy(), h.stand_ins()[subtree.stand_in], h.pool(), subtree.cell, e.view);
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

/// Whether an error is wanted that primitives in place of a stand-in would not keep either, with so many samples.
template <class E>
bool needs_more_samples(const E& e, const Subtree& subtree) {
    if constexpr (E::hierarchy_type::approximation_type::facts.expects_error) {
        const WantedError& wanted = e.view.wanted;
        return wanted.rmse &&
               point_sampling_rmse(side_px(e, subtree), covered_part(e, subtree), wanted.samples) > float(*wanted.rmse);
    } else {
        return false;
    }
}

/// What point sampling costs is told by samples: a primitive that meets none is passed over, eight at a time, for a
/// sixth of its price; one that meets some is set up, drawn and tested for depth for 2.7 times its price more (3.5 and
/// 60 ns where a stand-in takes 300, its visits included). No more primitives meet a sample than their cells cover.
inline float point_sampled_primitives(float items, float samples_covered) {
    return items * (1.0f / 6) + 2.7f * std::min(items, samples_covered);
}

/// The logarithm to the base of 2, and back, of numbers above 0, to a tenth: as bits have it, for no two machines round
/// logarithms alike.
inline float rough_log2(float x) {
    return float(std::bit_cast<std::uint32_t>(x)) * 0x1p-23f - 127;
}
inline float rough_exp2(float x) {
    return std::bit_cast<float>(std::uint32_t((x + 127) * 0x1p23f));
}

/// How many times more cells there are a level farther down in a subtree: as if they grew evenly from the one to all
/// that are on the last level. 1 to 8.
template <class H>
float log2_of_growth(const H& h, const Subtree& subtree) {
    const Node& node = h.nodes()[subtree.node];
    if (node.stand_in_levels_below == Node::nothing_below || node.stand_in_levels_below == 0) return 3;
    // Three of four nodes are on the last level.
    const float last = 0.75f * float(end_of_nodes_below(h.nodes(), subtree.node) - node.first_child);
    return std::clamp(rough_log2(std::max(last, 1.0f)) / float(node.stand_in_levels_below), 0.0f, 3.0f);
}

/// Stand-ins are drawn where they cost less by this factor: between primitives they break batches, and what is
/// estimated is wrong by as much.
inline constexpr float least_gain = 1.5f;

/// Whether point sampling the subtree's primitives costs less than the stand-ins that would be drawn for it, down to
/// cells that are small enough by the tolerance and, from two levels above these on, by what they are expected to
/// err, if they are covered as this one is. (The contents of a tree's crown are the thinner the smaller the cells.) For
/// three cells that are drawn four are visited. Above two samples a stand-in takes the longer the larger it is, and one
/// that is no splat then is drawn as faces.
template <class E>
bool is_cheaper_exactly(const E& e, const Subtree& subtree) {
    if (!e.view.wanted.is_point_sampling()) return false;
    const auto& h = e.hierarchy;
    const Node& node = h.nodes()[subtree.node];
    const std::uint32_t items = subtree.end_item - node.first_item;
    if (node.child_mask == 0) return false;
    if (subtree.crossed_planes != 0 && items > max_items_unculled) return false;
    const auto price = [&](const Work& work) { return h.cost_policy().cost(work); };
    const float whole_side = side_px(e, subtree), samples = float(e.view.wanted.samples) * whole_side * whole_side;
    /// What is covered is so by areas that hide one another.
    const auto exact = [&](float covered) {
        const float areas = -rough_log2(1 - 0.98f * covered) * 0.69f;
        return price({.triangles = point_sampled_primitives(float(items), areas * samples), .runs = 1});
    };
    const float stand_in = price({.splats = 1, .cells = 4.0f / 3}), most = exact(1);
    constexpr float levels_a_halving = E::hierarchy_type::partition_type::facts.children_are_octants ? 1 : 3;
    const float growth = levels_a_halving * log2_of_growth(h, subtree);
    float halvings = 1, side = 0.5f * whole_side;
    for (; side > e.view.tolerance_px; side *= 0.5f) ++halvings;
    const auto cost = [&] {
        using A = typename E::hierarchy_type::approximation_type;
        const float samples_wide = side * std::sqrt(float(e.view.wanted.samples));
        const float larger = samples_wide <= 2     ? 1.0f
                             : DrawsLargePlaced<A> ? 0.5f * samples_wide
                                                   : 1 + 0.75f * samples_wide;
        return least_gain * rough_exp2(std::min(growth * halvings, 60.0f)) * stand_in * larger;
    };
    constexpr float most_halvings_judged = 2;
    if constexpr (E::hierarchy_type::approximation_type::facts.expects_error) {
        if (subtree.has_stand_in() && cost() < most) {
            const float covered = covered_part(e, subtree), its = exact(covered);
            if (halvings <= most_halvings_judged) {
                for (; cost() < its && side > 0.25f && !errs_no_more_than_wanted(e, covered, side); side *= 0.5f)
                    ++halvings;
            }
            return cost() >= its;
        }
    }
    return cost() >= most;
}

}  // namespace farfield::detail
