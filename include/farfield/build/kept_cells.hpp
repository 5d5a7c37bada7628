// What a build knows of every cell, kept from one version to the next: which primitives lie in it, and whether it is
// split. The first of the layers of cell_tree.hpp.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <vector>

#include "farfield/build/build_node.hpp"
#include "farfield/build/cell_decision.hpp"
#include "farfield/build/sample_race.hpp"
#include "farfield/composition.hpp"
#include "farfield/fail.hpp"
#include "farfield/hierarchy/hierarchy_data.hpp"

namespace farfield::detail {

/// Whether answers about a cell follow from what lies in it: not where items are shared or cut, for then neighbors have
/// a say, nor where the partition looks at all items of a cell.
template <class H>
inline constexpr bool decides_cell_by_cell =
    H::assignment == Assignment::unique&& H::partition_type::facts.children_are_octants&& H::partition_type::facts
                         .chooses_by_cell&& std::is_empty_v<typename H::node_data> &&
    !(H::approximation_type::facts.compares && H::approximation_type::facts.samples_primitives);

template <class H, Primitive P>
requires(decides_cell_by_cell<H>) class KeptCells {
  protected:
    using Partition_ = typename H::partition_type;
    using A = typename H::approximation_type;
    using C = typename H::cost_model_type;
    static constexpr bool stands_in = A::facts.stands_in, samples = A::facts.samples_primitives,
                          compares = A::facts.compares;

    KeptCells(const Partition_& partition, const A& approximation, const C& cost)
        : partition_(partition), approximation_(approximation), cost_(cost) {}

    static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

    /// What a report counts, of a cell and all below it.
    struct Tally {
        std::uint32_t empty = 0, would_not_pay = 0, too_deep = 0, one_place = 0;
        std::uint32_t idle = 0;  ///< cells of the hierarchy without a stand-in
        std::uint32_t levels = 0;
    };
    struct NoStandIn {};
    struct NoSamples {};
    struct StandIn {
        typename A::stand_in_draft draft{};
        typename A::stand_in_data data{};
    };
    struct Samples {
        std::vector<std::uint32_t> least;  ///< primitives of the least keys, ascending
        SampleList about;
        LeftOfCell left;
        bool stands_in_below = false;
    };
    static auto stand_in_type() {
        if constexpr (stands_in) {
            return StandIn{};
        } else {
            return NoStandIn{};
        }
    }
    struct Twig : decltype(stand_in_type()), std::conditional_t<samples, Samples, NoSamples> {
        Cell cell;
        std::uint32_t parent = none;
        std::array<std::uint32_t, 8> children{};  ///< 0: none
        std::vector<std::uint32_t> own;           ///< primitives that a split leaves here, ascending
        std::uint32_t items = 0;                  ///< in the subtree, before anything moves
        float split_cost = 0;                     ///< of the subtree
        float cost = 0;                           ///< of the subtree, once samples have moved
        bool would_not_pay = false, too_deep = false, one_place = false;
        bool has_stand_in = false;                   ///< which pays; its parent's may be drawn in its place
        bool reproduces = false;                     ///< its stand-in is drawn in place of its children's
        bool takes_all = false;                      ///< it is a leaf of the hierarchy, whatever lies below
        std::uint32_t touched_in = 0, stale_in = 0;  ///< versions: contents; or anything about it
        Tally tally;
    };

    template <class F>
    void for_each_child(std::uint32_t n, F&& f) const {
        for (unsigned c = 0; c < 8; ++c) {
            if (twigs_[n].children[c] != 0) f(c, twigs_[n].children[c]);
        }
    }
    bool is_split(std::uint32_t n) const {
        return std::any_of(twigs_[n].children.begin(), twigs_[n].children.end(), [](auto c) { return c != 0; });
    }
    bool is_touched(std::uint32_t n) const { return twigs_[n].touched_in == version_; }
    bool is_stale(std::uint32_t n) const { return twigs_[n].stale_in == version_; }

    std::uint32_t new_twig(std::uint32_t parent, const Cell& cell) {
        std::uint32_t n = std::uint32_t(twigs_.size());
        if (free_.empty()) {
            if (n >= 0xfffffff0u) {
                detail::fail<std::length_error>(
                    "farfield: the hierarchy would exceed 2^32 nodes or items; lower max_depth");
            }
            twigs_.emplace_back();
        } else {
            n = free_.back();
            free_.pop_back();
        }
        Twig& twig = twigs_[n];
        twig.cell = cell;
        twig.parent = parent;
        twig.touched_in = twig.stale_in = version_;
        return n;
    }
    /// Numbers are used again in later versions only, for holders may still refer to them in this one.
    void remove(std::uint32_t n) {
        for_each_child(n, [&](unsigned, std::uint32_t child) { remove(child); });
        twigs_[n] = Twig{};
        removed_.push_back(n);
    }

    void take_out(std::uint32_t i) {
        std::vector<std::uint32_t>& own = twigs_[cell_of_[i]].own;
        own.erase(std::lower_bound(own.begin(), own.end(), i));
        for (std::uint32_t n = cell_of_[i]; n != none; n = twigs_[n].parent) {
            touch(n);
            --twigs_[n].items;
        }
    }
    /// Into the cells as they are: whether they stay so is asked afterwards.
    void put_in(const Item& item) {
        std::uint32_t n = 0;
        while (true) {
            touch(n);
            ++twigs_[n].items;
            if (!is_split(n)) break;
            unsigned to = 8;
            struct Emit {
                unsigned& to;
                void operator()(unsigned child) const { to = child; }
                void keep() const {}
            };
            partition_.place(twigs_[n].cell, typename Partition_::node_data{}, item,
                             touches_of(primitives_[item.source], facts_.origin), Emit{to});
            if (to == 8) break;
            if (twigs_[n].children[to] == 0) {
                const std::uint32_t child = new_twig(n, partition_.child(twigs_[n].cell, {}, to));
                twigs_[n].children[to] = child;
            }
            n = twigs_[n].children[to];
        }
        std::vector<std::uint32_t>& own = twigs_[n].own;
        own.insert(std::lower_bound(own.begin(), own.end(), item.source), item.source);
        cell_of_[item.source] = n;
    }
    void touch(std::uint32_t n) { twigs_[n].touched_in = twigs_[n].stale_in = version_; }
    void mark_stale(std::uint32_t n) {
        for (; n != none && !is_stale(n); n = twigs_[n].parent) twigs_[n].stale_in = version_;
    }

    // --- splits

    /// Splits touched cells that hold too much, puts together those that hold too little.
    void settle(std::uint32_t n) {
        settle_children(n);
        for (std::uint32_t& child : twigs_[n].children) {
            if (child == 0 || twigs_[child].items != 0) continue;
            remove(child);
            child = 0;
        }
        if (is_split(n) && !stays_split(n)) put_together(n);
        if (!is_split(n)) {
            divide(n);
            settle_children(n);
        }
        float cost = 0;
        for (const std::uint32_t i : twigs_[n].own) cost += items_[i].cost;
        for_each_child(n, [&](unsigned, std::uint32_t child) { cost += twigs_[child].split_cost; });
        twigs_[n].split_cost = cost;
    }
    void settle_children(std::uint32_t n) {
        for (unsigned c = 0; c < 8; ++c) {
            const std::uint32_t child = twigs_[n].children[c];
            if (child != 0 && is_touched(child)) settle(child);
        }
    }

    unsigned children_of(std::uint32_t n) const {
        return 8 - unsigned(std::count(twigs_[n].children.begin(), twigs_[n].children.end(), 0u));
    }

    /// What a build would decide. Its sums go through all items in order; here it is enough to know that they exceed
    /// what they are compared with by far.
    bool stays_split(std::uint32_t n) const {
        typename Partition_::node_data data{};
        if (partition_.choose(twigs_[n].cell, std::span<const Item>(), data) == Split::always) return true;
        const unsigned children = children_of(n);
        const bool surely_pays = Partition_::facts.splits_for_order ||
                                 rest_surely_costs_more(n, least_cost_to_split(approximation_, cost_, float(children)));
        if (surely_pays && children > 1) return true;
        if (surely_pays) return !all_at_one_place(n);
        return decide(n, all_items(n)).child_mask != 0;
    }
    /// Sums of n floats that are not below 0 differ by less than n / 2^22 of themselves, in whatever order they are
    /// added, where n is up to 2^20; and are no less than that of some of them.
    bool rest_surely_costs_more(std::uint32_t n, float least) const {
        const bool is_summed = twigs_[n].items <= std::uint32_t(1) << 20;
        bool one_does = false;
        float rest = 0;
        for_each_child(n, [&](unsigned, std::uint32_t child) {
            rest += twigs_[child].split_cost;
            one_does = one_does || (!is_summed && rest_surely_costs_more(child, least));
        });
        return is_summed ? rest > least * (1 + float(twigs_[n].items) * 0x1p-21f) : one_does;
    }
    bool all_at_one_place(std::uint32_t n) const {
        std::uint32_t first = none;
        return all_of(n, [&](std::uint32_t i) {
            if (first == none) first = i;
            return items_[i].bounds.center() == items_[first].bounds.center();
        });
    }
    template <class F>
    bool all_of(std::uint32_t n, const F& f) const {
        const Twig& twig = twigs_[n];
        return std::all_of(twig.own.begin(), twig.own.end(), f) &&
               std::all_of(twig.children.begin(), twig.children.end(),
                           [&](std::uint32_t child) { return child == 0 || all_of(child, f); });
    }

    /// As a split leaves them, depth first.
    template <class F>
    void visit_runs(std::uint32_t n, F&& f) const {
        f(std::span<const std::uint32_t>(twigs_[n].own));
        for_each_child(n, [&](unsigned, std::uint32_t child) { visit_runs(child, f); });
    }
    std::vector<std::uint32_t> all_items(std::uint32_t n) const {
        std::vector<std::uint32_t> all;
        all.reserve(twigs_[n].items);
        visit_runs(n, [&](auto run) { all.insert(all.end(), run.begin(), run.end()); });
        std::sort(all.begin(), all.end());
        return all;
    }

    CellDecision decide(std::uint32_t n, std::span<const std::uint32_t> indices) const {
        std::vector<std::uint16_t> targets;
        return decide(n, indices, targets);
    }
    CellDecision decide(std::uint32_t n, std::span<const std::uint32_t> indices,
                        std::vector<std::uint16_t>& targets) const {
        std::vector<Item> items;
        items.reserve(indices.size());
        for (const std::uint32_t i : indices) items.push_back(items_[i]);
        targets.resize(items.size());
        typename Partition_::node_data data{};
        return decide_about_cell(
            partition_, approximation_, cost_, twigs_[n].cell, data, items, targets,
            [&](std::uint32_t i) { return touches_of(primitives_[i], facts_.origin); }, false);
    }

    void put_together(std::uint32_t n) {
        std::vector<std::uint32_t> all = all_items(n);
        for (std::uint32_t& child : twigs_[n].children) {
            if (child != 0) remove(std::exchange(child, 0));
        }
        for (const std::uint32_t i : all) cell_of_[i] = n;
        twigs_[n].own = std::move(all);
    }

    void divide(std::uint32_t n) {
        std::vector<std::uint16_t> targets;
        const CellDecision d = decide(n, twigs_[n].own, targets);
        twigs_[n].would_not_pay = d.would_not_pay;
        twigs_[n].too_deep = d.too_deep;
        twigs_[n].one_place = d.one_place;
        if (d.child_mask == 0) return;
        for (unsigned c = 0; c < 8; ++c) {
            if (d.count[c] == 0) continue;
            const std::uint32_t child = new_twig(n, partition_.child(twigs_[n].cell, {}, c));
            twigs_[n].children[c] = child;
            twigs_[child].own.reserve(d.count[c]);
            twigs_[child].items = std::uint32_t(d.count[c]);
        }
        const std::vector<std::uint32_t> all = std::exchange(twigs_[n].own, {});
        for (std::size_t i = 0; i < all.size(); ++i) {
            const std::uint32_t to = targets[i] == 0 ? n : twigs_[n].children[unsigned(std::countr_zero(targets[i]))];
            twigs_[to].own.push_back(all[i]);
            cell_of_[all[i]] = to;
        }
    }

    /// Parents before children.
    void list_touched(std::uint32_t n) {
        touched_.push_back(n);
        for_each_child(n, [&](unsigned, std::uint32_t child) {
            if (is_touched(child)) list_touched(child);
        });
    }

    Partition_ partition_;
    A approximation_;
    C cost_;

    HierarchyFacts facts_;                ///< those that outlast a version
    std::vector<Item> items_;             ///< by primitive
    std::vector<std::uint32_t> cell_of_;  ///< by primitive: where a split leaves it
    std::vector<Twig> twigs_;             ///< the root first
    std::vector<std::uint32_t> free_;     ///< twigs that are not in use
    std::uint32_t version_ = 0;

    // While a version is made.
    PrimitiveSpan<P> primitives_;
    std::vector<std::uint32_t> touched_, removed_;
};

}  // namespace farfield::detail
