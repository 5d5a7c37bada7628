// The first phase of a build: which primitives go into which cell. Level by level, so that whatever a level decides
// depends on the levels above alone and never on which thread was faster.
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
#include "farfield/build/read_primitives.hpp"
#include "farfield/composition.hpp"
#include "farfield/fail.hpp"
#include "farfield/geometry/triangle_box.hpp"
#include "farfield/hierarchy/hierarchy_data.hpp"

namespace farfield::detail {

/// Cells, parents before children, and the primitives that each keeps for its own run. Fills in what `parts` says of
/// the scene as a whole and of what was refused.
template <Partition Partition_, Approximation A, CostModel C, Primitive P>
class CellSplitter {
  public:
    using Draft = BuildNode<typename Partition_::node_data>;
    static constexpr bool items_are_shared = agreed_assignment<Partition_, A> == Assignment::shared;

    CellSplitter(std::span<const P> primitives, const Partition_& partition, const A& approximation, const C& cost,
                 const BuildBudget& budget, const BuildControl& control, HierarchyData<Partition_, A>& data)
        : primitives_(primitives),
          partition_(partition),
          approximation_(approximation),
          cost_(cost),
          memory_budget_bytes_(budget.memory_bytes),
          control_(control),
          data_(data) {}

    void split() {
        take_primitives();
        while (level_begin_ < drafts_.size()) split_level();
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
        read_primitives(primitives_, cost_, data_.facts, [&](const Item& item) {
            items_.push_back(item);
            if constexpr (items_are_shared) whole_cost_.push_back(item.cost);
            total += item.cost;
        });
        if constexpr (items_are_shared) cells_with_.assign(primitives_.size(), 1);
        data_.facts.root = partition_.root(data_.facts.bounds);
        drafts_.push_back({.cell = data_.facts.root, .count = items_.size(), .cost = total});
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
            l.kept_to = kept_size;
            kept_size += l.kept;
            count_refusals(l);
            if (node.is_leaf) continue;
            const Cell parent = node.cell;
            const auto node_data = node.data;
            const std::uint8_t mask = node.child_mask;
            drafts_[begin + i].first_child = std::uint32_t(drafts_.size());
            for (unsigned c = 0; c < 8; ++c) {
                if ((mask >> c & 1) == 0) continue;
                l.next_to[c] = next_size;
                drafts_.push_back(
                    {.cell = partition_.child(parent, node_data, c), .first = next_size, .count = l.count[c]});
                next_size += l.count[c];
            }
            data_.facts.report.empty_cells_pruned += 8 - unsigned(std::popcount(mask));
        }
        if (drafts_.size() > 0xfffffff0u || kept_size > 0xfffffff0u || next_size > 0xfffffff0u) {
            detail::fail<std::length_error>(
                "farfield: the hierarchy would exceed 2^32 nodes or items; lower max_depth");
        }
        if constexpr (items_are_shared) count_cells(begin, end);
        next_items_.resize(next_size);
        kept_.resize(kept_size);
        control_.run_quietly(level.size(), [&](std::size_t i) { hand_down(drafts_[begin + i], level[i]); });
        std::swap(items_, next_items_);
        for (std::size_t i = 0; i < level.size(); ++i) {
            drafts_[begin + i].first = level[i].kept_to;
            drafts_[begin + i].count = level[i].kept;
        }
        level_begin_ = end;
        if (end > begin) ++data_.facts.report.levels;
        control_.report(BuildPhase::splitting, kept_.size(), kept_.size() + items_.size());
    }

    /// Among the targets: a cell that is split does not hold the item.
    static constexpr std::uint16_t elsewhere = 1u << 8;

    struct LevelNode {
        std::array<std::size_t, 8> count{}, next_to{};
        std::size_t kept = 0, kept_to = 0;
        bool would_not_pay = false, too_deep = false, one_place = false, no_memory = false;
    };

    void decide(Draft& node, LevelNode& l, bool over_budget) {
        const std::span<const Item> items(items_.data() + node.first, node.count);
        node.answer = items.empty() ? Split::no : partition_.choose(node.cell, items, node.data);
        bool splits = node.answer == Split::yes || node.answer == Split::always;
        float rest_cost = 0, kept_cost = 0;
        std::size_t kept = 0;
        if (splits) {
            struct Emit {
                std::uint16_t& target;
                void operator()(unsigned child) const { target = std::uint16_t(target | 1u << child); }
                void keep() const {}
                void drop() const requires(items_are_shared) { target = elsewhere; }
            };
            for (std::size_t i = 0; i < items.size(); ++i) {
                std::uint16_t mask = 0;
                partition_.place(node.cell, std::as_const(node.data), items[i], touches(items[i].source), Emit{mask});
                targets_[node.first + i] = mask;
                if (mask == elsewhere) continue;
                if (mask == 0) {
                    ++kept;
                    kept_cost += items[i].cost;
                    continue;
                }
                rest_cost += items[i].cost;
                for (unsigned m = mask; m != 0; m &= m - 1) ++l.count[unsigned(std::countr_zero(m))];
            }
            for (unsigned c = 0; c < 8; ++c) {
                if (l.count[c] != 0) node.child_mask = std::uint8_t(node.child_mask | 1u << c);
            }
        }
        if (splits && node.answer != Split::always) {
            l.would_not_pay = !pays(rest_cost, float(std::popcount(node.child_mask)));
            l.no_memory = !l.would_not_pay && over_budget;
            splits = !l.would_not_pay && !l.no_memory;
        }
        // A single child with all the items is progress only if a later split can tell them apart.
        if (splits && node.answer != Split::always && cannot_be_told_apart(items, l, node.child_mask)) {
            l.one_place = true;
            splits = false;
        }
        if (node.child_mask == 0) splits = false;
        node.is_leaf = !splits;
        if (splits) {
            l.kept = kept;
            node.cost = kept_cost;
        } else {
            node.child_mask = 0;
            l.kept = items.size();
            node.cost = 0;
            for (const Item& item : items) node.cost += item.cost;
        }
        if (node.answer == Split::too_deep) l.too_deep = pays(node.cost, 1);
        if (node.answer == Split::inseparable) l.one_place = pays(node.cost, 2);
    }

    bool pays(float rest_cost, float children) const {
        return Partition_::facts.splits_for_order || rest_cost > least_cost_to_split(approximation_, cost_, children);
    }

    /// A single child with all the items is progress only if a later split can tell them apart; children that each get
    /// nearly all of them (duplicates by the thousand, as large as the cell) are none.
    static bool cannot_be_told_apart(std::span<const Item> items, const LevelNode& l, std::uint8_t child_mask) {
        if (std::has_single_bit(child_mask)) {
            const glm::vec3 first = items[0].bounds.center();
            return std::all_of(items.begin(), items.end(), [&](const Item& i) { return i.bounds.center() == first; });
        }
        std::size_t handed_down = 0;
        for (const std::size_t n : l.count) handed_down += n;
        return items_are_shared && 4 * handed_down > 3 * items.size() * std::size_t(std::popcount(child_mask));
    }

    auto touches(std::uint32_t source) const {
        return [this, source]([[maybe_unused]] const Box& box) {
            static_cast<void>(this), static_cast<void>(source);  // primitives without polygons
            if constexpr (PrimitiveWithInstance<P>) {
                // An instance may hold more polygons than all the rest of the scene: its bounds have to do.
                if (primitive_traits<P>::visit_instance(primitives_[source], [](const auto&) {})) return true;
            }
            if constexpr (PrimitiveWithPolygons<P>) {
                bool touched = false;
                local_polygons(primitives_[source], data_.facts.origin, [&](const Polygon& polygon) {
                    for (std::size_t i = 2; i < polygon.vertices.size() && !touched; ++i) {
                        touched =
                            triangle_touches(box, polygon.vertices[0], polygon.vertices[i - 1], polygon.vertices[i]);
                    }
                });
                return touched;
            } else {
                return true;
            }
        };
    }

    void count_refusals(const LevelNode& l) {
        data_.facts.report.splits_that_would_not_pay += l.would_not_pay;
        data_.facts.report.cells_at_depth_limit += l.too_deep;
        data_.facts.report.cells_that_cannot_be_told_apart += l.one_place;
        data_.facts.report.cells_over_memory_budget += l.no_memory;
    }

    /// "Its drawing cost in each of these cells is obtained by dividing its original cost by the number of cells in
    /// which it appears" (1996, section 4); counted once a level, since the number changes while other branches split.
    void count_cells(std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            const Draft& node = drafts_[n];
            if (node.is_leaf) continue;
            for (std::size_t i = node.first; i < node.first + node.count; ++i) {
                const unsigned children = targets_[i] == elsewhere ? 0u : unsigned(std::popcount(targets_[i]));
                if (targets_[i] != 0) cells_with_[items_[i].source] += children - 1;
            }
        }
    }

    void hand_down(const Draft& node, LevelNode& l) {
        std::size_t kept_to = l.kept_to;
        for (std::size_t i = node.first; i < node.first + node.count; ++i) {
            Item item = items_[i];
            if constexpr (items_are_shared) item.cost = whole_cost_[item.source] / float(cells_with_[item.source]);
            const unsigned mask = node.is_leaf ? 0u : targets_[i];
            if (mask == elsewhere) continue;
            if (mask == 0) kept_[kept_to++] = item.source;
            for (unsigned m = mask; m != 0; m &= m - 1) next_items_[l.next_to[unsigned(std::countr_zero(m))]++] = item;
        }
    }

    std::uint64_t bytes_so_far() const {
        return drafts_.size() *
               (sizeof(Node) + stored_size<typename Partition_::node_data> +
                stored_size<typename A::stand_in_data>)+(kept_.size() + items_.size()) *
               sizeof(std::uint32_t);
    }

    std::span<const P> primitives_;
    const Partition_& partition_;
    const A& approximation_;
    const C& cost_;
    std::uint64_t memory_budget_bytes_;
    const BuildControl& control_;
    HierarchyData<Partition_, A>& data_;

    std::vector<Draft> drafts_;  ///< level after level
    std::size_t level_begin_ = 0;
    std::vector<Item> items_, next_items_;  ///< of this level and the next
    std::vector<std::uint16_t> targets_;    ///< which children get an item; 0: it stays
    std::vector<std::uint32_t> kept_;       ///< primitives in their last place, by level
    std::vector<float> whole_cost_;         ///< shared items only
    std::vector<std::uint32_t> cells_with_;
};

}  // namespace farfield::detail
