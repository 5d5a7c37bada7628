// May a Viewer walk these arrays? A checksum finds accidents only: a forger can make it agree. So the whole structure
// is checked before a hierarchy from a file is used, and before one is saved.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "farfield/storage/file_format.hpp"

namespace farfield::detail {

/// Nodes and stand-ins are numbered in one way only (see Node): walking the tree in that order meets each just once, so
/// there is neither a circle nor a node with two parents, and positions of items never fall. Returns null if it is so.
inline const char* unsound_nodes(std::span<const Node> nodes, std::uint32_t item_count, std::uint64_t stand_ins,
                                 bool root_has_stand_in) {
    struct Siblings {
        std::uint32_t next, end;
    };
    if (nodes.empty()) return "it has no root";
    if (root_has_stand_in && stand_ins == 0) return "the root's stand-in is missing";
    if (nodes[0].first_item != 0) return "the root's items do not start at 0";
    std::vector<Siblings> path{{0, 1}};
    std::uint64_t next_node = 1, next_stand_in = root_has_stand_in ? 1 : 0;
    std::uint32_t item = 0;
    while (!path.empty()) {
        if (path.back().next == path.back().end) {
            path.pop_back();
            continue;
        }
        const Node& node = nodes[path.back().next++];
        if (node.first_item < item || node.first_item > item_count) return "a node's items are out of order";
        item = node.first_item;
        if (node.levels_replaced > 1) return "a stand-in replaces more than one level";
        if ((node.stand_in_mask & ~node.child_mask) != 0) return "a stand-in belongs to a child that does not exist";
        if (const auto count = unsigned(std::popcount(node.stand_in_mask)); count != 0) {
            if (node.first_child_data != next_stand_in) return "stand-ins are out of order";
            if ((next_stand_in += count) > stand_ins) return "a node's stand-in does not exist";
        }
        if (const auto count = unsigned(std::popcount(node.child_mask)); count != 0) {
            if (node.first_child != next_node) return "nodes are out of order";
            if ((next_node += count) > nodes.size()) return "a node's child does not exist";
            if (path.size() == most_levels_in_files) return "it has more than 1024 levels";
            path.push_back({node.first_child, node.first_child + count});
        }
    }
    if (next_node != nodes.size()) return "it has nodes without a parent";
    if (next_stand_in != stand_ins) return "it has stand-ins that belong to no node";
    return nullptr;
}

inline bool is_finite(glm::vec3 v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// A position holds the vertices of a polygon, or none where it is an instance's.
inline const char* unsound_fragments(const Fragments& fragments, std::uint32_t item_count) {
    if (fragments.empty()) {
        if (item_count != 0) return "its fragments are missing";
        return fragments.vertices.empty() && fragments.colors.empty() ? nullptr
                                                                      : "it has vertices that belong to no fragment";
    }
    if (fragments.first_vertex.size() != std::size_t(item_count) + 1)
        return "it does not have as many fragments as items";
    if (fragments.first_vertex.front() != 0 || fragments.first_vertex.back() != fragments.vertices.size() ||
        fragments.colors.size() != fragments.vertices.size()) {
        return "its fragments do not have as many vertices and colors as there are";
    }
    for (std::size_t i = 0; i < item_count; ++i) {
        const std::uint32_t first = fragments.first_vertex[i], end = fragments.first_vertex[i + 1];
        if (end < first) return "its fragments are out of order";
        if (end - first == 1 || end - first == 2) return "a fragment has fewer than three vertices";
    }
    if (!std::all_of(fragments.vertices.begin(), fragments.vertices.end(), is_finite)) {
        return "a fragment's vertex is not finite";
    }
    return nullptr;
}

inline const char* unsound_facts(const HierarchyFacts& facts, std::uint64_t node_count) {
    if (facts.root_has_stand_in > 1 || facts.spare != 0) return "a flag has no known meaning";
    if (facts.baked_light > BakedLight::directional || wrong_light(facts.light) != nullptr)
        return "the light of its stand-ins is none";
    const Cell& root = facts.root;
    if (!is_finite(root.center) || !is_finite(root.half) || !is_finite(root.bounds_center) ||
        !is_finite(root.bounds_half) || !is_finite(glm::vec3(facts.origin))) {
        return "the root's cell is not finite";
    }
    const glm::vec3 least = glm::min(root.half, root.bounds_half);
    if (least.x < 0 || least.y < 0 || least.z < 0) return "the root's cell has a negative size";
    if (root.depth != 0) return "the root's depth is not 0";
    if (!facts.bounds.is_empty() && !facts.bounds.is_finite()) return "its bounds are not finite";
    if (facts.report.items > 0xffffffffu || node_count > 0xffffffffu) return "it has more than 2^32 nodes or items";
    return nullptr;
}

/// The reason not to use a hierarchy of these facts and arrays, or null.
template <class H>
const char* unsound(const typename H::partition_type& partition, const typename H::approximation_type& approximation,
                    const HierarchyFacts& facts, const typename H::Arrays& arrays) {
    using A = typename H::approximation_type;
    if (const char* why = unsound_facts(facts, arrays.nodes.size())) return why;
    const auto items = std::uint32_t(facts.report.items);
    if (const char* why = unsound_nodes(arrays.nodes, items, arrays.stand_ins.size(), facts.root_has_stand_in != 0)) {
        return why;
    }
    if (!A::facts.stands_in && !arrays.stand_ins.empty())
        return "it has stand-ins, which its approximation does not make";
    if constexpr (!std::is_empty_v<typename H::node_data>) {
        // A hierarchy over nothing is never entered.
        if (arrays.node_data.size() != arrays.nodes.size() && items != 0)
            return "it does not have as many records of node data as nodes";
        for (const auto& data : arrays.node_data) {
            if (!partition.is_sound(data)) return "the partition refuses a node's data";
        }
    }
    if constexpr (A::facts.has_pool) {
        for (const auto& data : arrays.stand_ins) {
            if (!approximation.is_sound(data, arrays.pool)) return "the approximation refuses a stand-in";
        }
    } else if constexpr (ChecksStandIns<A>) {
        for (const auto& data : arrays.stand_ins) {
            if (!approximation.is_sound(data)) return "the approximation refuses a stand-in";
        }
    }
    if constexpr (H::assignment == Assignment::clipped) {
        if (const char* why = unsound_fragments(arrays.fragments, items)) return why;
        if (arrays.order.size() != items) return "the order of its items is missing";
    } else if (!arrays.fragments.empty() || !arrays.fragments.vertices.empty() || !arrays.fragments.colors.empty()) {
        return "it has fragments, which its partition does not make";
    }
    if (arrays.order.empty()) return items == facts.primitive_count ? nullptr : "the order of its items is missing";
    if (arrays.order.size() != items) return "its order does not have as many entries as there are items";
    if (*std::max_element(arrays.order.begin(), arrays.order.end()) >= facts.primitive_count) {
        return "its order names a primitive that does not exist";
    }
    return nullptr;
}

}  // namespace farfield::detail
