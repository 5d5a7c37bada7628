// A cell between the phases of a build.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "farfield/approximation.hpp"
#include "farfield/cost_model.hpp"
#include "farfield/geometry/cell.hpp"
#include "farfield/hierarchy/node.hpp"
#include "farfield/partition.hpp"

namespace farfield::detail {

inline constexpr std::uint32_t no_stand_in = std::numeric_limits<std::uint32_t>::max();

/// A cell while its hierarchy is built. Each phase fills in its own fields; parents come before children throughout.
template <class NodeData>
struct BuildNode {
    // split
    Cell cell;
    NodeData data{};
    std::size_t first = 0,
                count = 0;  ///< its items in this level's array; of a finished cell in what the splitter keeps
    float cost = 0;         ///< of its own run, later of its subtree
    std::uint32_t first_child = 0;
    std::uint8_t child_mask = 0;
    Split answer = Split::no;
    bool is_leaf = true;
    // order
    std::uint32_t place = 0;                     ///< in the hierarchy, as long as nothing is pruned
    std::uint32_t first_item = 0, end_item = 0;  ///< positions of its subtree, own run first
    // stand-ins
    std::uint32_t stand_in = no_stand_in;  ///< its index among those that pay
    std::uint8_t levels_replaced = 0;      ///< as Node's
    bool is_pruned = false;
};

/// Sets stand_in_levels_below, given a node's masks and its children, which are finished.
inline void mark_levels_below(Node& node, std::span<const Node> children, bool has_stand_in) {
    unsigned deepest = Node::nothing_below;
    std::size_t child = 0;
    for (unsigned mask = node.child_mask; mask != 0; mask &= mask - 1, ++child) {
        unsigned below = children[child].stand_in_levels_below;
        const bool stands_in = (node.stand_in_mask & (mask & (0u - mask))) != 0;
        if (stands_in && below == 0) below = children[child].levels_replaced;
        if (below == Node::nothing_below) continue;
        // Where cells are not halved nobody asks for more than whether there are any.
        const unsigned levels = std::min(below + 1, Node::nothing_below - 1u);
        deepest = deepest == Node::nothing_below ? levels : std::max(deepest, levels);
    }
    if (deepest == Node::nothing_below && has_stand_in) deepest = 0;
    node.stand_in_levels_below = std::uint8_t(deepest);
}

/// What a cell's items must cost more than to be split into `children`. "The cost of rendering the primitives is no
/// more than the cost of rendering the color-cube approximations of the children" (1996, section 4): then a cell is not
/// split. Where nothing stands in there is nothing to compare with, and a split must earn by culling: a cell on the
/// frustum's border is half outside on average.
template <Approximation A, CostModel C>
float least_cost_to_split(const A& approximation, const C& cost, float children) {
    if constexpr (A::facts.stands_in) {
        return children * cost.cost(approximation.expected_work());
    } else {
        return 2 * children * cost.cost({.cells = 1, .runs = 1});
    }
}

}  // namespace farfield::detail
