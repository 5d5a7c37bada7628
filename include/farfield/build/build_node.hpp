// A cell between the phases of a build.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "farfield/approximation.hpp"
#include "farfield/build/build_control.hpp"
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

/// Where each level of nodes ends that come level by level. Where they come otherwise each is a level by itself: a part
/// of the nodes whose parents come before and whose children come after it.
template <class BuildNode_>
std::vector<std::size_t> levels_of(std::span<const BuildNode_> nodes) {
    std::vector<std::size_t> ends;
    std::size_t begin = 0, end = 1;
    while (begin < nodes.size()) {
        std::size_t next = end;
        for (std::size_t n = begin; n < end; ++n) {
            const auto children = std::size_t(std::popcount(nodes[n].child_mask));
            if (children != 0 && nodes[n].first_child != next) {
                ends.resize(nodes.size());
                for (std::size_t i = 0; i < ends.size(); ++i) ends[i] = i + 1;
                return ends;
            }
            next += children;
        }
        ends.push_back(end);
        begin = end;
        end = next;
    }
    return ends;
}

/// Calls f(n) for each node, children before parents, those of one level at once.
template <class F>
void run_bottom_up(const BuildControl& control, std::span<const std::size_t> ends, F&& f) {
    constexpr std::size_t chunk = 64;
    for (std::size_t level = ends.size(); level-- > 0;) {
        const std::size_t begin = level == 0 ? 0 : ends[level - 1];
        control.run_quietly((ends[level] - begin + chunk - 1) / chunk, [&](std::size_t i) {
            const std::size_t end = std::min(begin + (i + 1) * chunk, ends[level]);
            for (std::size_t n = begin + i * chunk; n < end; ++n) f(n);
        });
    }
}

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
