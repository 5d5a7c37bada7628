// The last phase of a build but freezing: "model no more than a scene needs". Where a cell and its children tell the
// same story (a flat surface of one color, the inside of a solid), the children's stand-ins are not kept, and neither
// are children that are of no other use.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "farfield/hierarchy_parts.hpp"
#include "farfield/policy.hpp"

namespace farfield::detail {

inline constexpr std::uint32_t no_stand_in = 0xffffffffu;

/// A subtree of at most this many items that has no stand-ins is drawn as one run, so cells in it are of no use.
inline constexpr std::uint32_t culling_pays_above = 128;

/// A viewer looks at the parent's error divided by two, which is what the children's would be; one level at a time, for
/// what a stand-in is off by in place adds up with every level. Works on nodes in their final order; `data_index` says
/// where each node's stand-in lies, or that it has none.
template <Partition Part, Approximation A, class DraftCell, class Draft>
class StoryMerger {
  public:
    using Parts = HierarchyParts<Part, A>;

    /// What the builder knows of nodes by their draft's number, and which draft each node comes from.
    struct Built {
        const std::vector<DraftCell>& cells;
        const std::vector<Draft>& drafts;
        const std::vector<std::uint32_t>& end_item;
        const std::vector<std::uint32_t>& draft_of_node;
    };

    StoryMerger(const A& approximation, const Built& built, Parts& parts, std::vector<std::uint32_t>& data_index)
        : approximation_(approximation), built_(built), parts_(parts), data_index_(data_index) {}

    void merge() {
        bool is_any_merged = false;
        for (std::size_t i = parts_.nodes.size(); i-- > 0;) {  // children before parents
            if (!tells_its_children(i)) continue;
            Node& node = parts_.nodes[i];
            node.stand_in_reach = 1;
            const auto children = unsigned(std::popcount(node.child_mask));
            std::fill_n(data_index_.begin() + std::ptrdiff_t(node.first_child), children, no_stand_in);
            is_any_merged = true;
            drop_small_leaves(i);
        }
        if (!is_any_merged) return;
        if (!is_dropped_.empty()) close_gaps_between_nodes();
        close_gaps_between_stand_ins();
    }

  private:
    bool tells_its_children(std::size_t i) const {
        const Node& node = parts_.nodes[i];
        if (node.child_mask == 0 || data_index_[i] == no_stand_in) return false;
        std::array<ChildDraft<Draft>, 8> children;
        unsigned count = 0;
        for (unsigned mask = node.child_mask; mask != 0; mask &= mask - 1, ++count) {
            const std::size_t child = node.first_child + count;
            if (data_index_[child] == no_stand_in || parts_.nodes[child].stand_in_reach != 0) return false;
            const std::uint32_t at = built_.draft_of_node[child];
            children[count] = {unsigned(std::countr_zero(mask)), &built_.cells[at].cell, &built_.drafts[at]};
        }
        const std::uint32_t at = built_.draft_of_node[i];
        return approximation_.reproduces(built_.cells[at].cell, built_.drafts[at],
                                         std::span<const ChildDraft<Draft>>(children.data(), count));
    }

    /// The parent takes over their items, which follow its own. Items in several cells stay where they are.
    void drop_small_leaves(std::size_t i) {
        if constexpr ((Part::facts.offers & A::facts.accepts & unique) == 0 || Part::facts.splits_for_order) return;
        Node& node = parts_.nodes[i];
        if (built_.end_item[built_.draft_of_node[i]] - node.first_item > culling_pays_above) return;
        const auto begin = parts_.nodes.begin() + std::ptrdiff_t(node.first_child);
        const auto children = unsigned(std::popcount(node.child_mask));
        if (std::any_of(begin, begin + children, [](const Node& child) { return child.child_mask != 0; })) return;
        is_dropped_.resize(parts_.nodes.size());
        std::fill_n(is_dropped_.begin() + std::ptrdiff_t(node.first_child), children, true);
        node.child_mask = 0;
        node.first_child = 0;
    }

    void close_gaps_between_nodes() {
        std::vector<std::uint32_t> place(parts_.nodes.size());
        std::uint32_t kept = 0;
        for (std::size_t i = 0; i < place.size(); ++i) {
            place[i] = kept;
            if (is_dropped_[i]) continue;
            parts_.nodes[kept] = parts_.nodes[i];
            data_index_[kept] = data_index_[i];
            if constexpr (!std::is_empty_v<typename Part::node_data>) parts_.node_data[kept] = parts_.node_data[i];
            ++kept;
        }
        parts_.nodes.resize(kept);
        data_index_.resize(kept);
        if constexpr (!std::is_empty_v<typename Part::node_data>) parts_.node_data.resize(kept);
        for (Node& node : parts_.nodes) {
            if (node.child_mask != 0) node.first_child = place[node.first_child];
        }
    }

    void close_gaps_between_stand_ins() {
        std::uint32_t kept = 0;
        for (std::uint32_t& at : data_index_) {
            if (at == no_stand_in) continue;
            parts_.cell_data[kept] = parts_.cell_data[at];
            at = kept++;
        }
        parts_.cell_data.resize(kept);
    }

    const A& approximation_;
    const Built built_;
    Parts& parts_;
    std::vector<std::uint32_t>& data_index_;  ///< by node
    std::vector<bool> is_dropped_;
};

}  // namespace farfield::detail
