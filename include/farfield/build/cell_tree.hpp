// What a build knows of every cell, kept, so that a change of a few primitives asks anew about the cells that they lie
// in and no others. Whatever is decided about a cell follows from its contents and its children's answers, so the
// result is that of a build from nothing, byte for byte. Layers: which cells there are (kept_cells.hpp), what stands in
// for them (kept_stand_ins.hpp), and here the arrays of a version, copied where they are those of the version before.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "farfield/build/build_control.hpp"
#include "farfield/build/build_node.hpp"
#include "farfield/build/group_by_key.hpp"
#include "farfield/build/kept_stand_ins.hpp"
#include "farfield/build/read_primitives.hpp"
#include "farfield/build/version_before.hpp"
#include "farfield/hierarchy/fingerprint.hpp"
#include "farfield/hierarchy/hierarchy_data.hpp"

namespace farfield::detail {

/// After anything is thrown, only build() is of use.
template <class H, Primitive P, OrthographicSampler Sampler>
class CellTree : KeptStandIns<H, P, Sampler> {
    using StandIns = KeptStandIns<H, P, Sampler>;
    using Cells = KeptCells<H, P>;
    using Cells::approximation_, Cells::cell_of_, Cells::cost_, Cells::facts_, Cells::free_, Cells::items_,
        Cells::partition_, Cells::primitives_, Cells::removed_, Cells::touched_, Cells::twigs_, Cells::version_;
    using Cells::for_each_child, Cells::is_stale, Cells::list_touched, Cells::new_twig, Cells::put_in, Cells::settle,
        Cells::take_out;
    using Cells::none, Cells::samples, Cells::stands_in;
    using StandIns::append_all, StandIns::append_run, StandIns::finish, StandIns::items_in, StandIns::make_drafts,
        StandIns::move_samples, StandIns::set_racer;
    using StandIns::holder_, StandIns::racers_;
    using typename Cells::Partition_, typename Cells::A, typename Cells::C, typename Cells::Twig, typename Cells::Tally;

  public:
    using Data = typename H::Data;
    using Arrays = typename H::Arrays;

    CellTree(const Partition_& partition, const A& approximation, const C& cost, const Sampler& sampler,
             const BoxD& world)
        : StandIns(partition, approximation, cost, sampler), world_(world) {}

    Data build(PrimitiveSpan<P> primitives, const BuildControl& control) {
        primitives_ = primitives;
        ++version_;
        facts_ = {};
        items_.clear();
        read_primitives(primitives, cost_, world_, facts_, [&](const Item& item) { items_.push_back(item); });
        facts_.root = partition_.root(bounds_of_root(facts_, world_));
        fingerprint_ = {};
        parts_.resize(items_.size());
        for (std::size_t i = 0; i < items_.size(); ++i) set_fingerprint(std::uint32_t(i));
        twigs_.clear();
        free_.clear();
        removed_.clear();
        cell_of_.assign(items_.size(), 0);
        const std::uint32_t root = new_twig(none, facts_.root);
        twigs_[root].own.resize(items_.size());
        std::iota(twigs_[root].own.begin(), twigs_[root].own.end(), 0u);
        twigs_[root].items = std::uint32_t(items_.size());
        if constexpr (samples) {
            racers_.resize(items_.size());
            for (const std::uint32_t i : twigs_[root].own) set_racer(i);
            holder_.assign(items_.size(), none);
        }
        settle(root);
        return frozen({}, control, {});
    }

    /// The primitives differ from those before at the indices `changed` alone, which has all that are new or gone.
    /// `before` is what came of those; it is copied from where nothing changes. Throws what build() throws of
    /// primitives that are refused, before anything has changed.
    Data update(PrimitiveSpan<P> primitives, std::span<const std::uint32_t> changed, const Arrays& before,
                const BuildControl& control) {
        std::vector<Item> items;
        HierarchyFacts facts = facts_;
        if (!read_changed(primitives, changed, facts, items)) return build(primitives, control);
        primitives_ = primitives;
        facts_ = facts;
        ++version_;
        for (const std::uint32_t i : changed) {
            if (i >= items_.size()) continue;
            fingerprint_.remove(parts_[i]);
            take_out(i);
        }
        resize(primitives.size());
        for (const Item& item : items) {
            items_[item.source] = item;
            set_fingerprint(item.source);
            if constexpr (samples) set_racer(item.source);
            put_in(item);
        }
        settle(0);
        return frozen(changed, control, before);
    }

  private:
    using Before = VersionBefore<Arrays, Data>;

    /// False if the coordinates or the root's cell are others now, and so everything.
    bool read_changed(PrimitiveSpan<P> primitives, std::span<const std::uint32_t> changed, HierarchyFacts& facts,
                      std::vector<Item>& items) const {
        // Rounding keeps the order, so what reaches furthest does so in single precision too.
        bool shrinks = false;
        std::vector<bool> is_changed(std::max(items_.size(), primitives.size()));
        for (const std::uint32_t i : changed) {
            is_changed[i] = true;
            if (i < items_.size()) shrinks = shrinks || reaches_border(items_[i].bounds);
        }
        auto whole = decltype(primitive_traits<P>::bounds(std::declval<const P&>()))::empty();
        for (const std::uint32_t i : changed) {
            if (i < primitives.size()) whole.add(checked_bounds(primitives[i], i));
        }
        if constexpr (has_double_bounds<P>) {
            if (shrinks) {
                for (const P& p : primitives) whole.add(primitive_traits<P>::bounds(p));
            } else {
                // What has not changed reaches as far as it did, if not by the same bits: that is looked at below.
                const BoxD b{glm::dvec3(facts_.bounds.lower), glm::dvec3(facts_.bounds.upper)};
                const BoxD in_double = whole;
                const bool grows = !in_double.is_empty() && !contains(b, in_double, facts_.origin);
                if (grows) {
                    for (const P& p : primitives) whole.add(primitive_traits<P>::bounds(p));
                }
                shrinks = grows;
            }
            if (shrinks && origin_of<P>(whole, world_) != facts_.origin) return false;
        }
        if (shrinks) {
            facts.bounds = Box::empty();
            for (std::size_t i = 0; i < std::min(items_.size(), primitives.size()); ++i) {
                if (!is_changed[i]) facts.bounds.add(items_[i].bounds);
            }
        }
        for (const std::uint32_t i : changed) {
            if (i >= primitives.size()) continue;
            items.push_back(read_item(primitives[i], i, cost_, facts_.origin).first);
            add_bounds(facts.bounds, items.back().bounds, i);
        }
        const Cell root = partition_.root(bounds_of_root(facts, world_));
        return std::memcmp(&root, &facts_.root, sizeof root) == 0;
    }
    bool reaches_border(const Box& b) const {
        for (int axis = 0; axis < 3; ++axis) {
            if (b.lower[axis] == facts_.bounds.lower[axis] || b.upper[axis] == facts_.bounds.upper[axis]) return true;
        }
        return false;
    }
    /// Strictly, so that rounding does not matter.
    static bool contains(const BoxD& local, const BoxD& b, glm::dvec3 origin) {
        for (int axis = 0; axis < 3; ++axis) {
            if (!(double(float(b.lower[axis] - origin[axis])) > local.lower[axis] &&
                  double(float(b.upper[axis] - origin[axis])) < local.upper[axis]))
                return false;
        }
        return true;
    }

    void set_fingerprint(std::uint32_t i) {
        parts_[i] = Fingerprint::part(i, primitive_traits<P>::bounds(primitives_[i]));
        fingerprint_.add(parts_[i]);
    }
    void resize(std::size_t count) {
        items_.resize(count);
        parts_.resize(count);
        cell_of_.resize(count, none);
        if constexpr (samples) {
            racers_.resize(count);
            holder_.resize(count, none);
        }
    }

    Data frozen(std::span<const std::uint32_t> changed, const BuildControl& control, const Arrays& before) {
        touched_.clear();
        list_touched(0);
        if constexpr (stands_in) make_drafts(control);
        if constexpr (samples) move_samples(changed);
        finish(0);
        data_ = {};
        data_.nodes.reserve(before.nodes.size() + before.nodes.size() / 16 + 64);
        data_.order.reserve(items_.size());
        if constexpr (stands_in) data_.stand_ins.reserve(before.stand_ins.size() + before.stand_ins.size() / 16 + 64);
        data_.nodes.emplace_back();
        if (twigs_[0].has_stand_in) append_stand_in(0);
        const Before version(before);
        freeze(0, 0, version, version.whole(), twigs_[0].has_stand_in);
        data_.facts = facts_;
        tell_facts(data_.facts);
        free_.insert(free_.end(), removed_.begin(), removed_.end());
        removed_.clear();
        primitives_ = {};
        return std::move(data_);
    }

    /// Node `at` is there, and so is its stand-in; all that lies in it and below follows.
    void freeze(std::uint32_t at, std::uint32_t n, const Before& before, const typename Before::Subtree& old,
                bool has_stand_in) {
        // Data in a pool say where it lies, and are made anew.
        if (!A::facts.has_pool && old.exists() && !is_stale(n)) {
            before.copy(old, has_stand_in, at, data_);
            return;
        }
        const Twig& twig = twigs_[n];
        Node node{.first_item = std::uint32_t(data_.order.size()),
                  .levels_replaced = std::uint8_t(twig.reproduces ? 1 : 0)};
        if (twig.takes_all) {
            append_all(n, data_.order);
            group_last_run(node);
        } else {
            append_run(n, data_.order);
            group_last_run(node);
            const auto first = std::uint32_t(data_.nodes.size());
            for_each_child(n, [&](unsigned c, std::uint32_t child) {
                if (items_in(child) == 0) return;
                node.child_mask = std::uint8_t(node.child_mask | 1u << c);
                data_.nodes.emplace_back();
                if (twig.reproduces || !twigs_[child].has_stand_in) return;
                if (node.stand_in_mask == 0) node.first_child_data = std::uint32_t(data_.stand_ins.size());
                node.stand_in_mask = std::uint8_t(node.stand_in_mask | 1u << c);
                append_stand_in(child);
            });
            if (node.child_mask != 0) node.first_child = first;
            std::uint32_t to = first;
            for_each_child(n, [&](unsigned c, std::uint32_t child) {
                if ((node.child_mask >> c & 1) == 0) return;
                freeze(to++, child, before, before.child(old, c), (node.stand_in_mask >> c & 1) != 0);
            });
        }
        mark_levels_below(node, std::span<const Node>(data_.nodes).subspan(node.first_child), has_stand_in);
        data_.nodes[at] = node;
    }

    void group_last_run([[maybe_unused]] const Node& node) {
        if constexpr (groups_by_key<H, P>) {
            group_by_key(primitives_, std::span(data_.order).subspan(node.first_item), keys_);
        }
    }

    void append_stand_in([[maybe_unused]] std::uint32_t n) {
        if constexpr (stands_in && A::facts.has_pool) {
            data_.stand_ins.push_back(finished_stand_in(approximation_, twigs_[n].cell, twigs_[n].draft, data_.pool));
        } else if constexpr (stands_in) {
            data_.stand_ins.push_back(twigs_[n].data);
        }
    }

    void tell_facts(HierarchyFacts& facts) const {
        facts.primitive_count = facts.report.primitives = items_.size();
        facts.fingerprint = fingerprint_.of(items_.size());
        WorkSum work;
        for (const P& p : primitives_) work.add(work_of(p));
        facts.work = work.total();
        facts.root_has_stand_in = twigs_[0].has_stand_in ? 1u : 0u;
        const Tally& t = twigs_[0].tally;
        BuildReport& r = facts.report;
        r.items = data_.order.size();
        r.nodes = std::uint32_t(data_.nodes.size());
        r.leaves = std::uint32_t(
            std::count_if(data_.nodes.begin(), data_.nodes.end(), [](const Node& n) { return n.child_mask == 0; }));
        r.levels = t.levels;
        r.empty_cells_pruned = t.empty;
        r.splits_that_would_not_pay = t.would_not_pay;
        r.cells_at_depth_limit = t.too_deep;
        r.cells_that_cannot_be_told_apart = t.one_place;
        r.stand_ins = std::uint32_t(data_.stand_ins.size());
        r.stand_ins_that_would_not_pay = t.idle;
    }

    BoxD world_;
    Fingerprint fingerprint_;
    std::vector<std::uint64_t> parts_;  ///< of the fingerprint, by primitive
    Data data_;                         ///< while a version is made
    std::vector<KeyedItem> keys_;       ///< the same
};

}  // namespace farfield::detail
