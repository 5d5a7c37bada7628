// Cells whose items fit into a processor's cache are split to their leaves one after the other, instead of level by
// level with all others: each level would read and write all items of the scene in memory once more. What is decided
// about a cell follows from its items alone, so the cells are the same.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "farfield/build/build_control.hpp"
#include "farfield/build/build_node.hpp"
#include "farfield/build/cell_decision.hpp"
#include "farfield/hierarchy/build_report.hpp"
#include "farfield/partition.hpp"

namespace farfield::detail {

/// Adds what a decision has refused to what is reported.
inline void count_refusals(const CellDecision& d, BuildReport& report) {
    report.splits_that_would_not_pay += d.would_not_pay;
    report.cells_at_depth_limit += d.too_deep;
    report.cells_that_cannot_be_told_apart += d.one_place;
    report.cells_over_memory_budget += d.no_memory;
}

/// Only where every item goes to one child or stays.
template <Partition Partition_>
class SmallSubtrees {
  public:
    using Draft = BuildNode<typename Partition_::node_data>;
    static constexpr std::size_t most_items = 16384;  ///< half a megabyte

    /// A place for as many items, which lie in a row. Until the next call.
    std::size_t add(std::uint32_t node, std::size_t count) {
        roots_.push_back({node, items_});
        items_ += count;
        return items_ - count;
    }
    std::size_t items() const { return items_; }

    /// Splits what was added: `items` has all their items, and `kept` takes their sources, with positions that begin at
    /// `kept_begin`. decide(node, items, targets) is decide_about_cell(), and fills in what the node is told by it.
    /// Calls done(n) now and then, with the number of items that are in their last place.
    template <class Decide, class Done>
    void split(std::vector<Draft>& drafts, const Partition_& partition, std::span<Item> items,
               std::span<std::uint32_t> kept, std::size_t kept_begin, const BuildControl& control, Decide&& decide,
               Done&& done) {
        std::vector<std::size_t> ends;  // of tasks, among the roots
        for (std::size_t r = 0, begin = 0; r < roots_.size(); ++r) {
            const std::size_t end = r + 1 < roots_.size() ? roots_[r + 1].first : items_;
            if (end - begin < most_items && r + 1 < roots_.size()) continue;
            ends.push_back(r + 1);
            begin = end;
        }
        tasks_.resize(ends.size());
        control.run_in_slices(
            ends.size(),
            [&](std::size_t t) {
                Task task{partition, kept, kept_begin, {}, std::vector<Item>(most_items), {}};
                for (std::size_t r = t == 0 ? 0 : ends[t - 1]; r < ends[t]; ++r) {
                    roots_[r].task = std::uint32_t(t);
                    task.next = roots_[r].first;
                    Draft& root = drafts[roots_[r].node];
                    root = task.split(root, items.data() + roots_[r].first, task.other.data(), decide, tasks_[t]);
                }
            },
            [&](std::size_t, std::size_t end) {
                done(ends[end - 1] < roots_.size() ? roots_[ends[end - 1]].first : items_);
            });
    }

    /// All cells level after level, as if they had been split so, and how many levels there are. `drafts` has those
    /// that were added and all above them.
    std::size_t put_in_level_order(std::vector<Draft>& drafts, BuildReport& report) {
        std::size_t count = drafts.size(), levels = 0;
        for (const NodesBelow& below : tasks_) {
            count += below.nodes.size();
            report.splits_that_would_not_pay += below.report.splits_that_would_not_pay;
            report.cells_at_depth_limit += below.report.cells_at_depth_limit;
            report.cells_that_cannot_be_told_apart += below.report.cells_that_cannot_be_told_apart;
            report.empty_cells_pruned += below.report.empty_cells_pruned;
        }
        // Where the children of a cell are: among the drafts, or below a task's roots.
        constexpr std::uint32_t among_drafts = 0xffffffffu;
        std::vector<std::uint32_t> of_draft(drafts.size(), among_drafts), of_ordered;
        for (const Root& root : roots_) of_draft[root.node] = root.task;
        std::vector<Draft> ordered;
        ordered.reserve(count);
        of_ordered.reserve(count);
        ordered.push_back(drafts[0]);
        of_ordered.push_back(of_draft[0]);
        for (std::size_t n = 0, end = 0; n < ordered.size(); ++n) {
            if (n == end) {
                end = ordered.size();
                ++levels;
            }
            const std::uint32_t task = of_ordered[n], first = ordered[n].first_child;
            const auto children = std::uint32_t(std::popcount(ordered[n].child_mask));
            if (children == 0) continue;
            ordered[n].first_child = std::uint32_t(ordered.size());
            const std::vector<Draft>& from = task == among_drafts ? drafts : tasks_[task].nodes;
            for (std::uint32_t c = first; c < first + children; ++c) {
                ordered.push_back(from[c]);
                of_ordered.push_back(task == among_drafts ? of_draft[c] : task);
            }
        }
        drafts = std::move(ordered);
        return levels;
    }

  private:
    struct Root {
        std::uint32_t node;
        std::size_t first;  ///< of its items
        std::uint32_t task = 0;
    };
    /// What roots of one task have below them. Children of a cell lie in a row.
    struct NodesBelow {
        std::vector<Draft> nodes;
        BuildReport report;
    };
    struct Task {
        const Partition_& partition;
        std::span<std::uint32_t> kept;
        std::size_t kept_begin;
        std::vector<std::uint16_t> targets;
        std::vector<Item> other;
        std::size_t next;  ///< place in `kept`

        /// Items are moved between two places, from level to level.
        template <class Decide>
        Draft split(Draft node, Item* from, Item* to, const Decide& decide, NodesBelow& below) {
            targets.resize(std::max(targets.size(), node.count));
            const std::span<const Item> items(from, node.count);
            const CellDecision d = decide(node, items, std::span(targets).first(node.count));
            count_refusals(d, below.report);
            node.first = kept_begin + next;
            node.count = d.kept;
            if (node.is_leaf) {
                for (const Item& item : items) kept[next++] = item.source;
                return node;
            }
            std::array<Item*, 8> ends{};
            Item* end = to;
            for (unsigned c = 0; c < 8; ++c) {
                ends[c] = end;
                end += d.count[c];
            }
            for (std::size_t i = 0; i < items.size(); ++i) {
                if (targets[i] == 0) {
                    kept[next++] = items[i].source;
                } else {
                    *ends[unsigned(std::countr_zero(targets[i]))]++ = items[i];
                }
            }
            node.first_child = std::uint32_t(below.nodes.size());
            const auto children = std::size_t(std::popcount(node.child_mask));
            below.nodes.resize(below.nodes.size() + children);
            below.report.empty_cells_pruned += 8 - unsigned(children);
            std::size_t at = node.first_child;
            for (unsigned mask = node.child_mask; mask != 0; mask &= mask - 1) {
                const auto c = unsigned(std::countr_zero(mask));
                const Draft child{.cell = partition.child(node.cell, node.data, c), .count = d.count[c]};
                Item* const first = ends[c] - d.count[c];
                const Draft grown = split(child, first, from + (first - to), decide, below);
                below.nodes[at++] = grown;
            }
            return node;
        }
    };

    std::vector<Root> roots_;
    std::size_t items_ = 0;
    std::vector<NodesBelow> tasks_;
};

}  // namespace farfield::detail
