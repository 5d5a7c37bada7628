// The first levels of a hierarchy that is built outside of memory: cells that hold too much to be built at once, down
// to parts of the scene that do not. It is made of counts alone, before anything is built.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "farfield/composition.hpp"
#include "farfield/frame/subtree.hpp"
#include "farfield/geometry/cell.hpp"
#include "farfield/hierarchy/node.hpp"
#include "farfield/partition.hpp"

namespace farfield::detail {

/// Where an item goes in a cell that is split.
inline constexpr unsigned stays_in_cell = 8;

template <class Partition_>
unsigned child_of_item(const Partition_& partition, const Cell& cell, const Item& item) {
    struct Emit {
        unsigned& child;
        void operator()(unsigned c) const { child = c; }
        void keep() const {}
    };
    unsigned child = stays_in_cell;
    partition.place(
        cell, typename Partition_::node_data{}, item, [](const Box&) { return true; }, Emit{child});
    return child;
}

/// How many items each cell of the first levels holds.
template <class Partition_>
class CellCounts {
  public:
    /// Memory grows eightfold with each level: 18 MiB for 7.
    CellCounts(const Partition_& partition, const Cell& root, unsigned levels)
        : partition_(partition), root_(root), own_(levels + std::size_t(1)) {
        for (unsigned depth = 0; depth <= levels; ++depth) own_[depth].resize(std::size_t(1) << (3 * depth));
    }
    /// The cell that counts an item.
    struct Place {
        std::uint32_t depth = 0, at = 0;
        friend bool operator==(const Place&, const Place&) = default;
    };
    /// The cells down to where the last item was counted. The next one is mostly near it.
    struct Path {
        struct Step {
            Cell cell;
            unsigned child = stays_in_cell;  ///< whose cell the next step has
            bool is_split = false;
        };
        std::vector<Step> steps{};
    };
    Path path() const {
        return {std::vector<typename Path::Step>(own_.size(), {root_, stays_in_cell, is_split(root_)})};
    }
    Place place_of(const Item& item, Path& path) const {
        Place place;
        for (; place.depth + 1 < own_.size(); ++place.depth) {
            typename Path::Step& step = path.steps[place.depth];
            if (!step.is_split) break;
            const unsigned child = child_of_item(partition_, step.cell, item);
            if (child == stays_in_cell) break;
            if (child != step.child) {
                step.child = child;
                const Cell cell = partition_.child(step.cell, {}, child);
                path.steps[place.depth + 1] = {cell, stays_in_cell, is_split(cell)};
            }
            place.at = place.at * 8 + child;
        }
        return place;
    }
    void add(Place place, std::uint32_t count) { own_[place.depth][place.at] += count; }
    /// Makes counts of subtrees of what add() has counted of cells.
    void sum_up() {
        total_ = own_;
        for (std::size_t depth = own_.size() - 1; depth-- > 0;) {
            for (std::size_t at = 0; at < total_[depth].size(); ++at) {
                for (std::size_t c = 0; c < 8; ++c) total_[depth][at] += total_[depth + 1][8 * at + c];
            }
        }
    }
    std::uint64_t total(unsigned depth, std::size_t at) const { return total_[depth][at]; }
    std::uint64_t own(unsigned depth, std::size_t at) const { return own_[depth][at]; }
    /// Items of cells that keep more than `most` of them, but for the last level, which is not split.
    std::uint64_t in_long_runs(std::uint32_t most) const {
        std::uint64_t sum = 0;
        for (std::size_t depth = 0; depth + 1 < own_.size(); ++depth) {
            for (const std::uint32_t items : own_[depth]) sum += items > most ? items : 0;
        }
        return sum;
    }
    unsigned levels() const { return unsigned(own_.size() - 1); }
    const Cell& root() const { return root_; }
    /// Whether the partition allows it.
    bool is_split(const Cell& cell) const {
        typename Partition_::node_data data{};
        const Split answer = partition_.choose(cell, {}, data);
        return answer == Split::yes || answer == Split::always;
    }
    const Partition_& partition() const { return partition_; }

  private:
    const Partition_& partition_;
    Cell root_;
    std::vector<std::vector<std::uint32_t>> own_, total_;  ///< by depth and place in Morton order
};

/// A cell of the first levels.
struct TopNode {
    static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

    Cell cell;
    std::uint64_t items = 0;        ///< in its subtree
    std::uint64_t own_items = 0;    ///< that stay in it, where it is split here
    std::uint32_t first_child = 0;  ///< of those that are not empty, which lie together; blocks depth first
    std::uint8_t child_mask = 0;    ///< 0: it is a part, built by itself
    std::uint32_t part = none;      ///< which, in the order of the partition
    std::uint32_t own_begin = 0;    ///< where its own items begin among all such, depth first
};

/// Cells with more items than a part is to have are split, as long as that is known to help. Parts in a row go into one
/// group, up to `most_items`, which no part exceeds if that can be.
template <class Partition_>
class TopTree {
  public:
    TopTree(const CellCounts<Partition_>& counts, std::uint64_t most_items) : most_items_(most_items) {
        nodes_.push_back({.cell = counts.root(), .items = counts.total(0, 0)});
        split(counts, 0, 0, 0, std::min(most_items, items_of_part));
        number_parts(0);
    }
    /// The same again, from its nodes.
    TopTree(std::vector<TopNode> nodes, std::uint64_t most_items) : most_items_(most_items), nodes_(std::move(nodes)) {
        number_parts(0);
    }

    std::span<const TopNode> nodes() const { return nodes_; }
    bool has_top() const { return nodes_[0].child_mask != 0; }
    /// Nodes that are parts, in order.
    std::span<const std::uint32_t> parts() const { return parts_; }
    /// Items that stay in cells above the parts.
    std::uint64_t own_items() const { return own_items_; }
    std::size_t group_count() const { return group_begin_.size() - 1; }
    std::span<const std::uint32_t> group(std::size_t g) const {
        return parts().subspan(group_begin_[g], group_begin_[g + 1] - group_begin_[g]);
    }
    std::size_t group_of_part(std::uint32_t part) const { return group_of_part_[part]; }
    std::uint64_t items_of_group(std::size_t g) const {
        std::uint64_t sum = 0;
        for (const std::uint32_t n : group(g)) sum += nodes_[n].items;
        return sum;
    }

    /// The node that an item belongs to: a part, or one above, in which it stays.
    std::uint32_t node_of(const Partition_& partition, const Item& item) const {
        std::uint32_t n = 0;
        while (nodes_[n].child_mask != 0) {
            const unsigned child = child_of_item(partition, nodes_[n].cell, item);
            if (child == stays_in_cell) break;
            n = nodes_[n].first_child + bits_set[nodes_[n].child_mask & ((1u << child) - 1)];
        }
        return n;
    }

  private:
    /// What takes as many is built in a processor's cache.
    static constexpr std::uint64_t items_of_part = 32768;

    void split(const CellCounts<Partition_>& counts, std::uint32_t n, unsigned depth, std::size_t at,
               std::uint64_t most) {
        const std::uint64_t items = nodes_[n].items;
        if (items <= most || depth == counts.levels() || !counts.is_split(nodes_[n].cell)) return;
        // What is too large for the children of a cell is kept in memory to the end.
        if (items <= most_items_ && counts.own(depth, at) > items / 8) return;
        std::uint8_t mask = 0;
        for (unsigned c = 0; c < 8; ++c) {
            if (counts.total(depth + 1, 8 * at + c) != 0) mask = std::uint8_t(mask | 1u << c);
        }
        if (mask == 0) return;
        const auto first = std::uint32_t(nodes_.size());
        nodes_[n].child_mask = mask;
        nodes_[n].first_child = first;
        nodes_[n].own_items = counts.own(depth, at);
        for (unsigned c = 0; c < 8; ++c) {
            if ((mask >> c & 1) == 0) continue;
            nodes_.push_back({.cell = counts.partition().child(nodes_[n].cell, {}, c),
                              .items = counts.total(depth + 1, 8 * at + c)});
        }
        std::uint32_t child = first;
        for (unsigned c = 0; c < 8; ++c) {
            if ((mask >> c & 1) != 0) split(counts, child++, depth + 1, 8 * at + c, most);
        }
    }

    void number_parts(std::uint32_t n) {
        TopNode& node = nodes_[n];
        node.own_begin = std::uint32_t(own_items_);
        own_items_ += node.own_items;
        const auto children = unsigned(std::popcount(node.child_mask));
        if (children == 0) {
            node.part = std::uint32_t(parts_.size());
            if (parts_.empty() || items_in_group_ + node.items > most_items_) {
                group_begin_.back() = std::uint32_t(parts_.size());
                group_begin_.push_back(0);
                items_in_group_ = 0;
            }
            items_in_group_ += node.items;
            group_of_part_.push_back(std::uint32_t(group_begin_.size() - 2));
            parts_.push_back(n);
            group_begin_.back() = std::uint32_t(parts_.size());
        }
        for (unsigned c = 0; c < children; ++c) number_parts(nodes_[n].first_child + c);
    }

    std::uint64_t most_items_, items_in_group_ = 0, own_items_ = 0;
    std::vector<TopNode> nodes_;
    std::vector<std::uint32_t> parts_, group_of_part_;
    std::vector<std::uint32_t> group_begin_{0};
};

}  // namespace farfield::detail
