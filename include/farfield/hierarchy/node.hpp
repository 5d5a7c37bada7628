// A hierarchy is an array of nodes. Beside them stand the numbers that a frame and a build must agree on.
#pragma once

#include "farfield/settings.hpp"

#include <bit>
#include <cstdint>
#include <span>

#include "farfield/geometry/halvings.hpp"

namespace farfield {

/// 16 bytes, as they lie in files. Siblings lie next to each other; blocks of siblings follow depth first. So the
/// proper descendants of a node are one range of nodes and of stand-ins, and its subtree's items, own run first, are
/// one range of positions. Where a run or subtree ends follows from what comes next and is not stored.
struct Node {
    static constexpr std::uint8_t nothing_below = 255;

    std::uint32_t first_child = 0;       ///< 0: none
    std::uint32_t first_item = 0;        ///< own run first, then each child's subtree
    std::uint32_t first_child_data = 0;  ///< of the first child that has a stand-in; others follow by rank
    std::uint8_t child_mask = 0;         ///< which of the partition's children exist; absent ones were empty
    std::uint8_t stand_in_mask = 0;      ///< which of them have a stand-in
    std::uint8_t stand_in_levels_below = nothing_below;  ///< below this node, itself 0, the reach of others counted
    /// The number of levels of stand-ins below it that its own one reproduces: it may be drawn in their place, and
    /// where it may not they are missing. 0 for most.
    std::uint8_t levels_replaced = 0;

    friend bool operator==(const Node&, const Node&) = default;
};
static_assert(sizeof(Node) == 16);

/// A cell with fewer items is not asked about: whether it is hidden costs about as much to know as drawing ten of them.
inline constexpr std::uint32_t min_items_for_occlusion_query = 25;

/// A subtree of at most this many items that has no stand-ins is drawn as one run, even where it crosses the frustum's
/// border, so cells in it are of no use: culling pays above.
inline constexpr std::uint32_t max_items_unculled = 128;

/// More items than this that a renderer may deposit are visited cell by cell, front to back: what is deposited covers
/// what comes later, in front of it or not. In runs of 128, point sampling told the inner triangles of a molecule from
/// the outer ones better; 16 is no better than 32.
inline constexpr std::uint32_t max_items_per_deposited_run = 32;

namespace detail {
/// The factor of the error of a stand-in that is drawn in place of those `levels_replaced` levels below it.
inline float error_of_replaced_levels(const Node& node) {
    return two_to_the_minus(node.levels_replaced);
}

/// Where the nodes below a node end, which begin with its first child; 0 if there are none. The last of them lie below
/// the last child that has any. A descent that kept the end in mind would compute it for every child, and few are
/// asked.
inline std::uint32_t end_of_nodes_below(std::span<const Node> nodes, std::uint32_t node) {
    std::uint32_t end = 0;
    while (nodes[node].child_mask != 0) {
        const std::uint32_t first = nodes[node].first_child;
        end = first + std::uint32_t(std::popcount(nodes[node].child_mask));
        for (node = end - 1; node != first && nodes[node].child_mask == 0;) --node;
    }
    return end;
}
}  // namespace detail

}  // namespace farfield
