// A phase of a build before freezing: "model no more than a scene needs". Where a cell's stand-in gives the picture
// that its children's give (a flat surface of one color, the inside of a solid), the children's are not kept, and
// neither are children that are of no other use.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "farfield/approximation.hpp"
#include "farfield/build/build_node.hpp"
#include "farfield/composition.hpp"
#include "farfield/hierarchy/node.hpp"

namespace farfield::detail {

/// Whether a cell's stand-in reproduces those of its children, all of which have one of their own.
template <Approximation A, class BuildNode_, class Draft>
bool is_reproduced(const A& approximation, std::span<const BuildNode_> nodes, std::span<const Draft> drafts,
                   std::size_t n) {
    const BuildNode_& node = nodes[n];
    if (node.child_mask == 0 || node.stand_in == no_stand_in) return false;
    std::array<ChildDraft<Draft>, 8> children;
    unsigned count = 0;
    for (unsigned mask = node.child_mask; mask != 0; mask &= mask - 1, ++count) {
        const std::size_t child = node.first_child + count;
        if (nodes[child].stand_in == no_stand_in || nodes[child].levels_replaced != 0) return false;
        children[count] = {unsigned(std::countr_zero(mask)), &nodes[child].cell, &drafts[child]};
    }
    return approximation.reproduces(node.cell, drafts[n], std::span<const ChildDraft<Draft>>(children.data(), count));
}

/// Items in several cells stay where they are, and so does what is split for its order.
template <Partition Partition_, Approximation A>
inline constexpr bool may_drop_leaves =
    agreed_assignment<Partition_, A> == Assignment::unique && !Partition_::facts.splits_for_order;

/// Takes away the stand-ins of children that their parent's reproduces, and small leaves that are left without one,
/// whose items follow the parent's own and become its own. A viewer then looks at the parent's error divided by two,
/// which is what the children's would be; one level at a time, for what a stand-in is off by in place adds up with
/// every level.
template <Partition Partition_, Approximation A, class BuildNode_, class Draft>
void prune_redundant_stand_ins(const A& approximation, std::span<BuildNode_> nodes, std::span<const Draft> drafts) {
    for (std::size_t n = nodes.size(); n-- > 0;) {  // children before parents
        if (!is_reproduced(approximation, std::span<const BuildNode_>(nodes), drafts, n)) continue;
        BuildNode_& node = nodes[n];
        node.levels_replaced = 1;
        const auto children = nodes.subspan(node.first_child, std::size_t(std::popcount(node.child_mask)));
        for (BuildNode_& child : children) child.stand_in = no_stand_in;
        if (!may_drop_leaves<Partition_, A> || node.end_item - node.first_item > max_items_unculled ||
            std::any_of(children.begin(), children.end(), [](const BuildNode_& c) { return c.child_mask != 0; })) {
            continue;
        }
        for (BuildNode_& child : children) child.is_pruned = true;
        node.child_mask = 0;
        node.first_child = 0;
    }
}

}  // namespace farfield::detail
