// Primitives of one key lie side by side in a run: what a renderer draws with one state after the other is then a part
// of a run for each key, and not one for each change of keys among neighbors in space.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "farfield/geometry/visit_order.hpp"
#include "farfield/hierarchy/node.hpp"
#include "farfield/partition.hpp"
#include "farfield/primitive.hpp"
#include "farfield/primitive_source.hpp"

namespace farfield::detail {

/// Whether runs are in no order that counts. H is a SpatialHierarchy.
template <class H, class P>
inline constexpr bool groups_by_key =
    PrimitiveWithKey<P>&& H::assignment != Assignment::clipped && !H::approximation_type::facts.samples_primitives;

using KeyedItem = std::pair<std::uint32_t, std::uint32_t>;  ///< key, and what to sort by among equal ones

/// Sorts the indices of a run by their keys; those of one key stay in their order. `keys` is memory to work in.
template <PrimitiveWithKey P>
void group_indices(const PrimitiveSpan<P>& primitives, std::span<std::uint32_t> run, std::vector<KeyedItem>& keys) {
    keys.clear();
    bool in_order = true;
    for (std::uint32_t i = 0; i < run.size(); ++i) {
        keys.emplace_back(key_of(primitives[run[i]]), i);
        in_order = in_order && (i == 0 || keys[i - 1].first <= keys[i].first);
    }
    if (in_order) return;
    std::sort(keys.begin(), keys.end());
    // Places become what lies there, then all is written back.
    for (KeyedItem& key : keys) key.second = run[key.second];
    for (std::size_t i = 0; i < run.size(); ++i) run[i] = keys[i].second;
}
template <class Span>
void group_by_key(const Span& primitives, std::span<std::uint32_t> run, std::vector<KeyedItem>& keys) {
    group_indices<PrimitiveIn<Span>>(primitives, run, keys);
}

/// Groups the own runs of all nodes of a hierarchy's data.
template <class Span, class Data>
void group_runs(const Span& primitives, Data& data) {
    std::vector<KeyedItem> keys;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> stack;  // node, and where its items end
    if (!data.nodes.empty()) stack.emplace_back(0, std::uint32_t(data.order.size()));
    while (!stack.empty()) {
        const auto [n, end] = stack.back();
        stack.pop_back();
        const Node& node = data.nodes[n];
        std::uint32_t own_end = end;
        if (node.child_mask != 0) {
            const auto children = std::uint32_t(std::popcount(node.child_mask));
            own_end = data.nodes[node.first_child].first_item;
            for (std::uint32_t c = 0; c < children; ++c) {
                const std::uint32_t child = node.first_child + c;
                stack.emplace_back(child, c + 1 < children ? data.nodes[child + 1].first_item : end);
            }
        }
        group_by_key(primitives, std::span(data.order).subspan(node.first_item, own_end - node.first_item), keys);
    }
}

}  // namespace farfield::detail
