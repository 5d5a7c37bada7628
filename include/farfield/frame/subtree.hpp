// A node as a descent meets it, with what follows from the way down: nodes themselves are 16 bytes and know none of it.
#pragma once

#include "farfield/settings.hpp"

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "farfield/geometry/box.hpp"
#include "farfield/geometry/cell.hpp"
#include "farfield/geometry/visit_order.hpp"
#include "farfield/simd.hpp"
#include "farfield/spatial_hierarchy.hpp"
#include "farfield/view/frustum.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield {

struct Subtree {
    static constexpr std::uint32_t no_stand_in = std::numeric_limits<std::uint32_t>::max();

    Cell cell;
    std::uint32_t node = 0;
    std::uint32_t end_item = 0;            ///< its positions end here; they begin with the node's own run
    std::uint32_t stand_in = no_stand_in;  ///< index into the hierarchy's stand_ins()
    /// By how much less of it samples above have drawn than its stand-in says, and that none is drawn in it
    /// (left_out_samples.hpp).
    float left_out = 0;
    bool is_without_samples = false;
    PlaneMask crossed_planes = all_planes;    ///< those of the view that its bounds may cross
    PlaneMask crossed_borders = all_borders;  ///< those of a tile

    bool has_stand_in() const { return stand_in != no_stand_in; }
};

/// A hierarchy whose nodes' contents may be missing (paging/paged_hierarchy.hpp): begin_frame() and end_frame() around
/// each descent, is_portal(node) where contents lie elsewhere, reach_of(node, cell) for what holds these,
/// follow(subtree, weight) to get there or not, and expect(subtree, weight), the same for what later descents may
/// follow: those of view_ahead(), if that is known. Whatever can be followed has a stand-in.
template <class H>
concept PagedAtRunTime = requires(const H& h, Subtree& subtree, const Node& node, const Cell& cell) {
    h.begin_frame();
    h.end_frame();
    { h.whole() } -> std::same_as<Subtree>;
    { h.is_portal(node) } -> std::same_as<bool>;
    { h.items_below(node) } -> std::same_as<std::uint32_t>;
    { h.reach_of(node, cell) } -> std::same_as<Box>;
    { h.follow(subtree, 1.0f) } -> std::same_as<bool>;
    { h.expect(subtree, 1.0f) } -> std::same_as<bool>;
    { h.view_ahead() } -> std::same_as<const LocalView*>;
};

/// The time during which pages are looked at and waited for, whatever frames do otherwise.
template <class H>
class WaitingFrame {
  public:
    explicit WaitingFrame(H& pages) : pages_(pages), waits_(pages.waits_for_pages()) {
        pages_.wait_for_pages(true);
        pages_.begin_frame();
    }
    ~WaitingFrame() {
        pages_.end_frame();
        pages_.forget();
        pages_.wait_for_pages(waits_);
    }
    WaitingFrame(const WaitingFrame&) = delete;
    WaitingFrame& operator=(const WaitingFrame&) = delete;

  private:
    H& pages_;
    bool waits_;
};

template <class H>
Subtree whole_of(const H& hierarchy) {
    if constexpr (PagedAtRunTime<H>) return hierarchy.whole();
    Subtree whole;
    whole.cell = hierarchy.root_cell();
    whole.end_item = hierarchy.item_count();
    if constexpr (!PagedAtRunTime<H>) {
        if (hierarchy.root_stand_in() != nullptr) whole.stand_in = 0;
    }
    return whole;
}

/// Where a subtree's own run ends, and what its children hold begins.
template <class H>
std::uint32_t end_of_own_run(const H& hierarchy, const Subtree& subtree) {
    const Node& node = hierarchy.nodes()[subtree.node];
    return node.first_child == 0 ? subtree.end_item : hierarchy.nodes()[node.first_child].first_item;
}

namespace detail {

inline constexpr auto bits_set = [] {
    std::array<std::uint8_t, 256> table{};
    for (unsigned i = 1; i < 256; ++i) table[i] = std::uint8_t(table[i / 2] + i % 2);
    return table;
}();

/// The subtree below one of the children that a node has: `node` is the parent's, `node_data` what the partition keeps
/// of it.
template <class H>
FARFIELD_INLINE Subtree child_of(const H& hierarchy, const Subtree& parent, const Node& node,
                                 const typename H::node_data& node_data, unsigned child) {
    const unsigned below = (1u << child) - 1;
    const unsigned rank = bits_set[node.child_mask & below];
    const std::uint32_t at = node.first_child + rank;
    std::uint32_t stand_in = Subtree::no_stand_in;
    if constexpr (H::approximation_type::facts.stands_in) {
        if (node.stand_in_mask >> child & 1) stand_in = node.first_child_data + bits_set[node.stand_in_mask & below];
    }
    // The cell is computed where it will stay: a copy would read by vectors what has just been written by numbers, and
    // wait for it.
    return {.cell = hierarchy.partition_policy().child(parent.cell, node_data, child),
            .node = at,
            .end_item = rank + 1u < bits_set[node.child_mask] ? hierarchy.nodes()[at + 1].first_item : parent.end_item,
            .stand_in = stand_in,
            .crossed_planes = parent.crossed_planes,
            .crossed_borders = parent.crossed_borders};
}

}  // namespace detail

/// Calls f(Subtree&) for each child, in an order; children cross no planes but those that their parent crosses.
template <VisitOrder order, class H, class F>
void for_each_child(const H& hierarchy, const Subtree& parent, glm::vec4 viewpoint, F&& f) {
    const Node& node = hierarchy.nodes()[parent.node];
    const auto& node_data = hierarchy.data_of(parent.node);
    ChildOrder children{0, 1, 2, 3, 4, 5, 6, 7};
    if constexpr (order != VisitOrder::any) {
        hierarchy.partition_policy().front_to_back(parent.cell, node_data, viewpoint, children);
    }
    for (std::size_t i = 0; i < children.size(); ++i) {
        const unsigned child = children[order == VisitOrder::back_to_front ? children.size() - 1 - i : i];
        if ((node.child_mask >> child & 1) == 0) continue;
        Subtree subtree = detail::child_of(hierarchy, parent, node, node_data, child);
        f(subtree);
    }
}

/// Keeps in mind which of the view's planes a subtree's bounds still cross. True if they lie outside of one.
inline bool is_outside(const std::array<glm::vec4, plane_count>& planes, Subtree& subtree) {
    if (subtree.crossed_planes == 0) return false;
    subtree.crossed_planes =
        crossed_planes(planes, subtree.cell.bounds_center, subtree.cell.bounds_half, subtree.crossed_planes);
    return subtree.crossed_planes == outside_a_plane;
}

/// The same for the borders of a tile. A view that is no tile has none.
inline bool is_outside_tile(const LocalView& view, Subtree& subtree) {
    if (view.borders_used == 0 || subtree.crossed_borders == 0) return false;
    subtree.crossed_borders = crossed_borders(view.borders, view.borders_used, subtree.cell.bounds_center,
                                              subtree.cell.bounds_half, subtree.crossed_borders);
    return subtree.crossed_borders == outside_a_plane;
}

}  // namespace farfield
