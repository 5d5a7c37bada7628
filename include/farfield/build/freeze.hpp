// The last phase of a build: what is left of its cells becomes nodes, in the order in which they will be read.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "farfield/approximation.hpp"
#include "farfield/build/build_node.hpp"
#include "farfield/hierarchy/hierarchy_data.hpp"

namespace farfield::detail {

/// Nodes in the order that they will have, which is that of the pool.
template <class BuildNode_>
std::vector<std::uint32_t> nodes_by_place(std::span<const BuildNode_> nodes) {
    std::vector<std::uint32_t> order(nodes.size());
    for (std::size_t n = 0; n < nodes.size(); ++n) order[nodes[n].place] = std::uint32_t(n);
    return order;
}

/// Sets the masks of a node whose children are finished. stand_in_of: by node, its index or no_stand_in.
inline void mark_stand_ins(std::span<Node> nodes, std::size_t index, std::span<const std::uint32_t> stand_in_of) {
    Node& node = nodes[index];
    std::uint32_t child = node.first_child;
    for (unsigned mask = node.child_mask; mask != 0; mask &= mask - 1, ++child) {
        if (stand_in_of[child] == no_stand_in) continue;
        if (node.stand_in_mask == 0) node.first_child_data = stand_in_of[child];
        node.stand_in_mask = std::uint8_t(node.stand_in_mask | (mask & (0u - mask)));
    }
    mark_levels_below(node, nodes.subspan(node.first_child), stand_in_of[index] != no_stand_in);
}

/// Items that are pieces of polygons: all but instances.
inline std::uint64_t count_pieces(std::span<const std::uint32_t> first_vertex) {
    std::uint64_t count = 0;
    for (std::size_t i = 1; i < first_vertex.size(); ++i) count += first_vertex[i] != first_vertex[i - 1];
    return count;
}

/// Fills in nodes, stand-ins and what the facts say of them, where `data` has items already. Those that are pruned are
/// left out. stand_ins: those that pay, by BuildNode::stand_in.
template <class Partition_, class A>
void freeze(std::span<BuildNode<typename Partition_::node_data>> nodes,
            std::span<const typename A::stand_in_data> stand_ins, HierarchyData<Partition_, A>& data) {
    using BuildNode_ = BuildNode<typename Partition_::node_data>;
    const std::vector<std::uint32_t> by_place = nodes_by_place(std::span<const BuildNode_>(nodes));
    std::uint32_t count = 0;
    for (const std::uint32_t n : by_place) {
        if (!nodes[n].is_pruned) nodes[n].place = count++;
    }
    data.nodes.resize(count);
    if constexpr (!std::is_empty_v<typename Partition_::node_data>) data.node_data.reserve(count);
    std::vector<std::uint32_t> stand_in_of(count, no_stand_in);
    for (const std::uint32_t n : by_place) {
        const BuildNode_& node = nodes[n];
        if (node.is_pruned) continue;
        Node& out = data.nodes[node.place];
        out.first_item = node.first_item;
        out.child_mask = node.child_mask;
        out.first_child = node.child_mask != 0 ? nodes[node.first_child].place : 0;
        out.levels_replaced = node.levels_replaced;
        if constexpr (!std::is_empty_v<typename Partition_::node_data>) data.node_data.push_back(node.data);
        if constexpr (A::facts.stands_in) {
            if (node.stand_in == no_stand_in) continue;
            stand_in_of[node.place] = std::uint32_t(data.stand_ins.size());
            data.stand_ins.push_back(stand_ins[node.stand_in]);
        }
    }
    for (std::size_t i = count; i-- > 0;) mark_stand_ins(std::span(data.nodes), i, stand_in_of);
    data.facts.root_has_stand_in = stand_in_of[0] != no_stand_in ? 1u : 0u;
    BuildReport& report = data.facts.report;
    report.items = data.order.size();
    report.pieces = count_pieces(data.fragments.first_vertex);
    report.nodes = count;
    report.leaves = std::uint32_t(
        std::count_if(data.nodes.begin(), data.nodes.end(), [](const Node& n) { return n.child_mask == 0; }));
    report.stand_ins = std::uint32_t(data.stand_ins.size());
}

}  // namespace farfield::detail
