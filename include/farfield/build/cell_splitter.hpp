// The first phase of a build: which primitives go into which cell. Level by level, so that whatever a level decides
// depends on the levels above alone and never on which thread was faster; and at last what has become small.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "farfield/build/build_control.hpp"
#include "farfield/build/build_node.hpp"
#include "farfield/build/cell_decision.hpp"
#include "farfield/build/read_primitives.hpp"
#include "farfield/build/small_subtrees.hpp"
#include "farfield/composition.hpp"
#include "farfield/fail.hpp"
#include "farfield/hierarchy/hierarchy_data.hpp"

namespace farfield::detail {

/// Cells, parents before children, and the primitives that each keeps for its own run. Fills in what `parts` says of
/// the scene as a whole and of what was refused.
template <Partition Partition_, Approximation A, CostModel C, Primitive P>
class CellSplitter {
  public:
    using Draft = BuildNode<typename Partition_::node_data>;
    static constexpr bool items_are_shared = agreed_assignment<Partition_, A> == Assignment::shared;

    CellSplitter(PrimitiveSpan<P> primitives, const Partition_& partition, const A& approximation, const C& cost,
                 const BuildBudget& budget, const BuildControl& control, HierarchyData<Partition_, A>& data)
        : primitives_(primitives),
          partition_(partition),
          approximation_(approximation),
          cost_(cost),
          memory_budget_bytes_(budget.memory_bytes),
          world_(budget.world),
          part_(budget.part),
          origin_of_part_(budget.origin_of_part),
          control_(control),
          data_(data) {}

    void split() {
        take_primitives();
        while (level_begin_ < drafts_.size()) split_level();
        if constexpr (!items_are_shared) split_small_cells();
    }

    std::vector<Draft>& drafts() { return drafts_; }
    /// Appends what a cell keeps.
    void append_items(const Draft& node) {
        if (data_.order.empty()) data_.order.reserve(kept_.size());
        data_.order.insert(data_.order.end(), kept_.begin() + std::ptrdiff_t(node.first),
                           kept_.begin() + std::ptrdiff_t(node.first + node.count));
    }

  private:
    void take_primitives() {
        items_.reserve(primitives_.size());
        float total = 0;
        const auto take = [&](const Item& item) {
            items_.push_back(item);
            if constexpr (items_are_shared) whole_cost_.push_back(item.cost);
            total += item.cost;
        };
        if (part_ != nullptr) {
            read_part(primitives_, cost_, origin_of_part_, data_.facts, take);
        } else {
            read_primitives(primitives_, cost_, world_, data_.facts, take);
        }
        if constexpr (items_are_shared) cells_with_.assign(primitives_.size(), 1);
        data_.facts.root = part_ != nullptr ? *part_ : partition_.root(bounds_of_root(data_.facts, world_));
        drafts_.push_back({.cell = data_.facts.root, .count = items_.size(), .cost = total});
        if (is_small(items_.size())) {
            small_.add(0, items_.size());
            std::swap(items_, small_items_);
        } else if (memory_budget_bytes_ == 0) {
            small_items_.reserve(items_.size());
        }
    }

    /// Decides about each node of the newest level, then hands its items down.
    void split_level() {
        const std::size_t begin = level_begin_, end = drafts_.size();
        const bool over_budget = memory_budget_bytes_ != 0 && bytes_so_far() > memory_budget_bytes_;
        targets_.resize(items_.size());
        std::vector<LevelNode> level(end - begin);
        control_.run_quietly(level.size(), [&](std::size_t i) { decide(drafts_[begin + i], level[i], over_budget); });

        // Where everything goes: serial, and so the same on any number of threads.
        std::size_t next_size = 0, kept_size = kept_.size();
        for (std::size_t i = 0; i < level.size(); ++i) {
            Draft& node = drafts_[begin + i];
            LevelNode& l = level[i];
            if (l.is_small) continue;
            l.kept_to = kept_size;
            kept_size += l.decision.kept;
            count_refusals(l.decision, data_.facts.report);
            if (node.is_leaf) continue;
            const Cell parent = node.cell;
            const auto node_data = node.data;
            const std::uint8_t mask = node.child_mask;
            drafts_[begin + i].first_child = std::uint32_t(drafts_.size());
            for (unsigned c = 0; c < 8; ++c) {
                if ((mask >> c & 1) == 0) continue;
                const std::size_t count = l.decision.count[c];
                l.child_is_small[c] = is_small(count);
                if (is_small(count)) {
                    l.next_to[c] = small_.add(std::uint32_t(drafts_.size()), count);
                } else {
                    l.next_to[c] = next_size;
                    next_size += count;
                }
                drafts_.push_back(
                    {.cell = partition_.child(parent, node_data, c), .first = l.next_to[c], .count = count});
            }
            data_.facts.report.empty_cells_pruned += 8 - unsigned(std::popcount(mask));
        }
        if (drafts_.size() > 0xfffffff0u || kept_size > 0xfffffff0u || next_size > 0xfffffff0u) {
            refuse_size();
        }
        if constexpr (items_are_shared) count_cells(begin, end);
        next_items_.resize(next_size);
        small_items_.resize(small_.items());
        kept_.resize(kept_size);
        control_.run_quietly(level.size(), [&](std::size_t i) { hand_down(drafts_[begin + i], level[i]); });
        std::swap(items_, next_items_);
        for (std::size_t i = 0; i < level.size(); ++i) {
            if (level[i].is_small) continue;
            drafts_[begin + i].first = level[i].kept_to;
            drafts_[begin + i].count = level[i].decision.kept;
        }
        level_begin_ = end;
        if (end > begin) ++data_.facts.report.levels;
        control_.report(BuildPhase::splitting, kept_.size(), kept_.size() + items_.size() + small_items_.size());
    }

    /// Not where memory is bounded: what is too much is asked level by level.
    bool is_small(std::size_t items) const {
        return !items_are_shared && memory_budget_bytes_ == 0 && items <= SmallSubtrees<Partition_>::most_items;
    }

    void split_small_cells() {
        if (small_items_.empty()) return;
        items_ = next_items_ = {};
        const std::size_t begin = kept_.size(), all = begin + small_items_.size();
        kept_.resize(all);
        small_.split(
            drafts_, partition_, std::span(small_items_), std::span(kept_).subspan(begin), begin, control_,
            [this](Draft& node, std::span<const Item> items, std::span<std::uint16_t> targets) {
                return decide(node, items, targets, false);
            },
            [&](std::size_t done) { control_.report(BuildPhase::splitting, begin + done, all); });
        data_.facts.report.levels = std::uint32_t(small_.put_in_level_order(drafts_, data_.facts.report));
        if (drafts_.size() > 0xfffffff0u) refuse_size();
    }
    [[noreturn]] static void refuse_size() {
        detail::fail<std::length_error>("farfield: the hierarchy would exceed 2^32 nodes or items; lower max_depth");
    }

    struct LevelNode {
        CellDecision decision;
        std::array<std::size_t, 8> next_to{};
        std::array<bool, 8> child_is_small{};
        std::size_t kept_to = 0;
        bool is_small = false;  ///< it is split at last
    };

    void decide(Draft& node, LevelNode& l, bool over_budget) {
        l.is_small = is_small(node.count);
        if (l.is_small) return;
        l.decision = decide(node, {items_.data() + node.first, node.count}, {targets_.data() + node.first, node.count},
                            over_budget);
    }
    CellDecision decide(Draft& node, std::span<const Item> items, std::span<std::uint16_t> targets,
                        bool over_budget) const {
        const CellDecision d = decide_about_cell(
            partition_, approximation_, cost_, node.cell, node.data, items, targets,
            [this](std::uint32_t source) { return touches(source); }, over_budget);
        node.child_mask = d.child_mask;
        node.is_leaf = d.child_mask == 0;
        node.cost = d.cost;
        return d;
    }

    auto touches(std::uint32_t source) const { return touches_of(primitives_[source], data_.facts.origin); }

    /// "Its drawing cost in each of these cells is obtained by dividing its original cost by the number of cells in
    /// which it appears" (1996, section 4); counted once a level, since the number changes while other branches split.
    void count_cells(std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            const Draft& node = drafts_[n];
            if (node.is_leaf) continue;
            for (std::size_t i = node.first; i < node.first + node.count; ++i) {
                const unsigned children = targets_[i] == in_other_cells ? 0u : unsigned(std::popcount(targets_[i]));
                if (targets_[i] != 0) cells_with_[items_[i].source] += children - 1;
            }
        }
    }

    void hand_down(const Draft& node, const LevelNode& l) {
        if (l.is_small) return;
        std::size_t kept_to = l.kept_to;
        std::array<Item*, 8> next;
        for (unsigned c = 0; c < 8; ++c) {
            next[c] = (l.child_is_small[c] ? small_items_ : next_items_).data() + l.next_to[c];
        }
        for (std::size_t i = node.first; i < node.first + node.count; ++i) {
            Item item = items_[i];
            if constexpr (items_are_shared) item.cost = whole_cost_[item.source] / float(cells_with_[item.source]);
            const unsigned mask = node.is_leaf ? 0u : targets_[i];
            if (mask == in_other_cells) continue;
            if (mask == 0) kept_[kept_to++] = item.source;
            for (unsigned m = mask; m != 0; m &= m - 1) *next[unsigned(std::countr_zero(m))]++ = item;
        }
    }

    std::uint64_t bytes_so_far() const {
        return drafts_.size() *
               (sizeof(Node) + stored_size<typename Partition_::node_data> +
                stored_size<typename A::stand_in_data>)+(kept_.size() + items_.size()) *
               sizeof(std::uint32_t);
    }

    PrimitiveSpan<P> primitives_;
    const Partition_& partition_;
    const A& approximation_;
    const C& cost_;
    std::uint64_t memory_budget_bytes_;
    BoxD world_;
    const Cell* part_;
    glm::dvec3 origin_of_part_;
    const BuildControl& control_;
    HierarchyData<Partition_, A>& data_;

    std::vector<Draft> drafts_;  ///< level after level
    std::size_t level_begin_ = 0;
    std::vector<Item> items_, next_items_;  ///< of this level and the next
    std::vector<Item> small_items_;         ///< of small cells, which are left for the end
    SmallSubtrees<Partition_> small_;
    std::vector<std::uint16_t> targets_;  ///< which children get an item; 0: it stays
    std::vector<std::uint32_t> kept_;     ///< primitives in their last place, by level
    std::vector<float> whole_cost_;       ///< shared items only
    std::vector<std::uint32_t> cells_with_;
};

}  // namespace farfield::detail
