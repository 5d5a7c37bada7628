// What a build knows of every cell, kept, so that a change of a few primitives asks anew about the cells that they lie
// in and no others. Whatever is decided about a cell follows from its contents and its children's answers, so the
// result is that of a build from nothing, byte for byte.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <limits>
#include <numeric>
#include <span>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <vector>

#include "farfield/build/build_control.hpp"
#include "farfield/build/build_node.hpp"
#include "farfield/build/cell_decision.hpp"
#include "farfield/build/prune_stand_ins.hpp"
#include "farfield/build/read_primitives.hpp"
#include "farfield/build/sample_race.hpp"
#include "farfield/composition.hpp"
#include "farfield/fail.hpp"
#include "farfield/hierarchy/fingerprint.hpp"
#include "farfield/hierarchy/hierarchy_data.hpp"

namespace farfield::detail {

/// Whether answers about a cell follow from what lies in it: not where items are shared or cut, for then neighbors have
/// a say, nor where the partition looks at all items of a cell.
template <class H>
inline constexpr bool decides_cell_by_cell =
    H::assignment == Assignment::unique&& H::partition_type::facts.children_are_octants&& H::partition_type::facts
                         .chooses_by_cell&& std::is_empty_v<typename H::node_data> &&
    !(H::approximation_type::facts.compares && H::approximation_type::facts.samples_primitives);

/// After anything is thrown, only build() is of use.
template <class H, Primitive P, OrthographicSampler Sampler>
requires(decides_cell_by_cell<H>) class CellTree {
    using Partition_ = typename H::partition_type;
    using A = typename H::approximation_type;
    using C = typename H::cost_model_type;
    static constexpr bool stands_in = A::facts.stands_in, samples = A::facts.samples_primitives,
                          compares = A::facts.compares;

  public:
    using Data = typename H::Data;
    using Arrays = typename H::Arrays;

    CellTree(const Partition_& partition, const A& approximation, const C& cost, const Sampler& sampler,
             const BoxD& world)
        : partition_(partition), approximation_(approximation), cost_(cost), sampler_(sampler), world_(world) {}

    Data build(std::span<const P> primitives, const BuildControl& control) {
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
    Data update(std::span<const P> primitives, std::span<const std::uint32_t> changed, const Arrays& before,
                const BuildControl& control) {
        check_primitive_count(primitives.size());
        std::vector<Item> items;
        HierarchyFacts facts = facts_;
        if (!read_changed(primitives, changed, facts, items)) return build(primitives, control);
        primitives_ = primitives;
        facts_ = facts;
        ++version_;
        for (const std::uint32_t i : changed) {
            if (i < items_.size()) take_out(i);
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

    // --- what changes

    /// False if the coordinates or the root's cell are others now, and so everything.
    bool read_changed(std::span<const P> primitives, std::span<const std::uint32_t> changed, HierarchyFacts& facts,
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
    void set_racer(std::uint32_t i) {
        racers_[i] = racer_of(approximation_, primitives_[i], i, facts_.origin, facts_.root.to_ordinary());
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

    void take_out(std::uint32_t i) {
        fingerprint_.remove(parts_[i]);
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

    // --- stand-ins

    void make_drafts(const BuildControl& control) {
        bool merges = false;
        if constexpr (A::facts.merges_octants) merges = approximation_.merges_children();
        constexpr std::size_t chunk = 64;
        control.run(BuildPhase::sampling, (touched_.size() + chunk - 1) / chunk, [&](std::size_t i) {
            Sampler sampler = sampler_;
            for (std::size_t at = i * chunk; at < std::min((i + 1) * chunk, touched_.size()); ++at) {
                const std::uint32_t n = touched_[at];
                twigs_[n].draft = {};
                if (merges ? twigs_[n].own.empty() : twigs_[n].items == 0) continue;
                const auto contents = [&](auto&& sink) {
                    const auto send = [&](std::span<const std::uint32_t> run) {
                        for (const std::uint32_t p : run) send_polygons(p, sink);
                    };
                    merges ? send(twigs_[n].own) : visit_runs(n, send);
                };
                twigs_[n].draft = approximation_.sample(twigs_[n].cell, contents, sampler);
            }
        });
        if constexpr (A::facts.merges_octants) {
            if (!merges) return;
            for (std::size_t at = touched_.size(); at-- > 0;) {
                Twig& twig = twigs_[touched_[at]];
                std::array<ChildDraft<typename A::stand_in_draft>, 8> children;
                const std::size_t count = drafts_of_children(touched_[at], children);
                if (count != 0)
                    approximation_.merge(twig.cell, twig.draft, std::span(std::as_const(children)).first(count));
            }
        }
    }
    template <class Sink>
    void send_polygons([[maybe_unused]] std::uint32_t primitive, [[maybe_unused]] Sink& sink) const {
        if constexpr (PrimitiveWithPolygons<P>) local_polygons(primitives_[primitive], facts_.origin, sink);
    }
    std::size_t drafts_of_children(std::uint32_t n, auto& children) const {
        std::size_t count = 0;
        for_each_child(n, [&](unsigned c, std::uint32_t child) {
            children[count++] = {c, &twigs_[child].cell, &twigs_[child].draft};
        });
        return count;
    }

    // --- samples

    /// Makes the lists of touched cells anew. What enters or leaves one may have to move, and that is looked for in the
    /// cells where it lies.
    void move_samples(std::span<const std::uint32_t> changed) {
        const SampleRace<A> race(approximation_, racers_, facts_.root.to_ordinary());
        std::vector<std::uint32_t> displaced(changed.begin(), changed.end()), before, now;
        for (std::size_t at = touched_.size(); at-- > 0;) {
            Twig& twig = twigs_[touched_[at]];
            before = twig.least;
            std::array<typename SampleRace<A>::Child, 8> children;
            std::size_t count = 0;
            for_each_child(touched_[at], [&](unsigned, std::uint32_t child) {
                children[count++] = {twigs_[child].least, twigs_[child].about};
            });
            twig.about = race.make_list(
                twig.cell, twig.own, std::span(std::as_const(children)).first(count),
                [&](auto&& add) { visit_runs(touched_[at], add); }, twig.least);
            now = twig.least;
            std::sort(before.begin(), before.end());
            std::sort(now.begin(), now.end());
            std::set_symmetric_difference(before.begin(), before.end(), now.begin(), now.end(),
                                          std::back_inserter(displaced));
        }
        std::sort(displaced.begin(), displaced.end());
        displaced.erase(std::unique(displaced.begin(), displaced.end()), displaced.end());
        for (const std::uint32_t i : displaced) {
            if (i >= items_.size()) break;
            std::uint32_t holder = none;
            for (std::uint32_t n = cell_of_[i]; n != none; n = twigs_[n].parent) {
                if (race.is_in(twigs_[n].least, i)) holder = n;
            }
            if (holder == holder_[i]) continue;
            // Cells that are gone have left touched ones behind.
            mark_stale(holder_[i]);
            mark_stale(holder);
            holder_[i] = holder;
        }
    }

    /// Appends what a cell holds in the end; returns how many of it, the first, are of its sample.
    std::uint32_t append_run(std::uint32_t n, std::vector<std::uint32_t>& out) const {
        const Twig& twig = twigs_[n];
        std::uint32_t sampled = 0;
        if constexpr (samples) {
            for (std::size_t i = 0; i < twig.least.size(); ++i) {
                if (holder_[twig.least[i]] != n) continue;
                out.push_back(twig.least[i]);
                sampled += i < twig.about.sample;
            }
            for (const std::uint32_t i : twig.own) {
                if (holder_[i] == none) out.push_back(i);
            }
        } else {
            out.insert(out.end(), twig.own.begin(), twig.own.end());
        }
        return sampled;
    }
    void append_all(std::uint32_t n, std::vector<std::uint32_t>& out) const {
        append_run(n, out);
        for_each_child(n, [&](unsigned, std::uint32_t child) { append_all(child, out); });
    }
    std::uint32_t items_in(std::uint32_t n) const {
        if constexpr (samples) {
            return twigs_[n].left.cell.items;
        } else {
            return twigs_[n].items;
        }
    }

    // --- what pays, and what of it is needed: see HierarchyBuilder and prune_stand_ins.hpp

    void finish(std::uint32_t n) {
        for_each_child(n, [&](unsigned, std::uint32_t child) {
            if (is_stale(child)) finish(child);
        });
        Twig& twig = twigs_[n];
        tally(n);
        if constexpr (stands_in) {
            finish_stand_in(n);
            if constexpr (samples) {
                twig.stands_in_below = false;
                for_each_child(n, [&](unsigned, std::uint32_t child) {
                    if (twigs_[child].stands_in_below || twigs_[child].has_stand_in) twig.stands_in_below = true;
                });
                twig.takes_all = !twig.stands_in_below && items_in(n) <= max_items_unculled;
            }
            twig.tally.idle = !twig.has_stand_in;
            if (!twig.takes_all || compares) {  // what compares counts before anything is pruned
                for_each_child(n, [&](unsigned, std::uint32_t child) {
                    if (items_in(child) != 0) twig.tally.idle += twigs_[child].tally.idle;
                });
            }
            if constexpr (compares) compare(n);
        }
    }

    void tally(std::uint32_t n) {
        Twig& twig = twigs_[n];
        const unsigned children = children_of(n);
        Tally sum{.empty = children != 0 ? 8 - children : 0,
                  .would_not_pay = twig.would_not_pay,
                  .too_deep = twig.too_deep,
                  .one_place = twig.one_place};
        for_each_child(n, [&](unsigned, std::uint32_t child) {
            const Tally& t = twigs_[child].tally;
            sum.empty += t.empty;
            sum.would_not_pay += t.would_not_pay;
            sum.too_deep += t.too_deep;
            sum.one_place += t.one_place;
            sum.levels = std::max(sum.levels, t.levels);
        });
        ++sum.levels;
        twig.tally = sum;
    }

    void finish_stand_in(std::uint32_t n) {
        Twig& twig = twigs_[n];
        twig.cost = 0;
        run_.clear();
        [[maybe_unused]] const std::uint32_t sampled = append_run(n, run_);
        for (const std::uint32_t i : run_) twig.cost += items_[i].cost;
        for_each_child(n, [&](unsigned, std::uint32_t child) { twig.cost += twigs_[child].cost; });
        pool_.clear();
        twig.data = finished_stand_in(approximation_, twig.cell, twig.draft, pool_);
        if constexpr (samples) {
            const SampleRace<A> race(approximation_, racers_, facts_.root.to_ordinary());
            twig.left = race.left_of(twig.cell, twig.about.area, run_, sampled, [&](auto&& take) {
                for_each_child(n, [&](unsigned, std::uint32_t child) { take(twigs_[child].left); });
            });
            twig.data = approximation_.sampled(twig.data, twig.left.cell);
        }
        twig.has_stand_in = twig.cost > cost_.cost(work_of_stand_in(approximation_, twig.data));
    }

    void compare(std::uint32_t n) {
        Twig& twig = twigs_[n];
        twig.takes_all = twig.reproduces = false;
        if (!is_split(n) || !twig.has_stand_in) return;
        bool all_stand_in = true, all_leaves = true;
        for_each_child(n, [&](unsigned, std::uint32_t child) {
            all_stand_in = all_stand_in && twigs_[child].has_stand_in && !twigs_[child].reproduces;
            all_leaves = all_leaves && (!is_split(child) || twigs_[child].takes_all);
        });
        if (!all_stand_in) return;
        std::array<ChildDraft<typename A::stand_in_draft>, 8> children;
        const std::size_t count = drafts_of_children(n, children);
        twig.reproduces =
            approximation_.reproduces(twig.cell, twig.draft, std::span(std::as_const(children)).first(count));
        twig.takes_all =
            twig.reproduces && may_drop_leaves<Partition_, A> && all_leaves && twig.items <= max_items_unculled;
    }

    // --- freezing

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
        before_ = before;
        freeze(
            0, 0,
            {before.nodes.empty() ? none : 0, std::uint32_t(before.nodes.size()), std::uint32_t(before.order.size())},
            twigs_[0].has_stand_in);
        before_ = {};
        data_.facts = facts_;
        tell_facts(data_.facts);
        free_.insert(free_.end(), removed_.begin(), removed_.end());
        removed_.clear();
        primitives_ = {};
        return std::move(data_);
    }

    /// A subtree as it was in the version before.
    struct Old {
        std::uint32_t node, end_node, end_item;
    };
    Old old_child(const Old& old, unsigned c) const {
        if (old.node == none || (before_.nodes[old.node].child_mask >> c & 1) == 0) return {none, 0, 0};
        const Node& node = before_.nodes[old.node];
        const auto rank = std::uint32_t(std::popcount(node.child_mask & ((1u << c) - 1)));
        const std::uint32_t end = node.first_child + std::uint32_t(std::popcount(node.child_mask));
        Old child{node.first_child + rank, old.end_node, old.end_item};
        if (child.node + 1 < end) child.end_item = before_.nodes[child.node + 1].first_item;
        for (std::uint32_t next = child.node + 1; next < end; ++next) {
            if (before_.nodes[next].child_mask == 0) continue;
            child.end_node = before_.nodes[next].first_child;
            break;
        }
        return child;
    }

    /// Node `at` is there, and so is its stand-in; all that lies in it and below follows.
    void freeze(std::uint32_t at, std::uint32_t n, const Old& old, bool has_stand_in) {
        // Data in a pool say where it lies, and are made anew.
        if (!A::facts.has_pool && old.node != none && !is_stale(n)) {
            copy(at, old, has_stand_in);
            return;
        }
        const Twig& twig = twigs_[n];
        Node node{.first_item = std::uint32_t(data_.order.size()),
                  .levels_replaced = std::uint8_t(twig.reproduces ? 1 : 0)};
        if (twig.takes_all) {
            append_all(n, data_.order);
        } else {
            append_run(n, data_.order);
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
                freeze(to++, child, old_child(old, c), (node.stand_in_mask >> c & 1) != 0);
            });
        }
        mark_levels_below(node, std::span<const Node>(data_.nodes).subspan(node.first_child), has_stand_in);
        data_.nodes[at] = node;
    }

    void append_stand_in([[maybe_unused]] std::uint32_t n) {
        if constexpr (stands_in && A::facts.has_pool) {
            data_.stand_ins.push_back(finished_stand_in(approximation_, twigs_[n].cell, twigs_[n].draft, data_.pool));
        } else if constexpr (stands_in) {
            data_.stand_ins.push_back(twigs_[n].data);
        }
    }

    void copy(std::uint32_t at, const Old& old, bool has_stand_in) {
        const Node& top = before_.nodes[old.node];
        const auto below = top.child_mask == 0 ? std::span<const Node>()
                                               : before_.nodes.subspan(top.first_child, old.end_node - top.first_child);
        // Stand-ins below lie in one piece too, but in another order than nodes.
        std::uint32_t first_stand_in = none, stand_ins = 0;
        const auto look_at = [&](const Node& node) {
            if (node.stand_in_mask == 0) return;
            first_stand_in = std::min(first_stand_in, node.first_child_data);
            stand_ins += std::uint32_t(std::popcount(node.stand_in_mask));
        };
        look_at(top);
        for (const Node& node : below) look_at(node);
        const auto nodes_by = std::uint32_t(data_.nodes.size()) - top.first_child,
                   items_by = std::uint32_t(data_.order.size()) - top.first_item,
                   stand_ins_by = std::uint32_t(data_.stand_ins.size()) - first_stand_in;
        const auto moved = [&](Node node) {
            if (node.child_mask != 0) node.first_child += nodes_by;
            node.first_item += items_by;
            if (node.stand_in_mask != 0) node.first_child_data += stand_ins_by;
            return node;
        };
        data_.nodes[at] = moved(top);
        // Its own stand-in counts where there are none below, and its parent may have taken it away.
        std::uint8_t& levels = data_.nodes[at].stand_in_levels_below;
        if (levels == 0 || levels == Node::nothing_below) levels = has_stand_in ? 0 : Node::nothing_below;
        for (const Node& node : below) data_.nodes.push_back(moved(node));
        if (stand_ins != 0) {
            const auto from = before_.stand_ins.begin() + first_stand_in;
            data_.stand_ins.insert(data_.stand_ins.end(), from, from + stand_ins);
        }
        const auto from = before_.order.begin() + top.first_item;
        data_.order.insert(data_.order.end(), from, from + (old.end_item - top.first_item));
    }

    void tell_facts(HierarchyFacts& facts) const {
        facts.primitive_count = facts.report.primitives = items_.size();
        facts.fingerprint = fingerprint_.of(items_.size());
        facts.work = {};
        for (const P& p : primitives_) facts.work += work_of(p);
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

    Partition_ partition_;
    A approximation_;
    C cost_;
    Sampler sampler_;
    BoxD world_;

    HierarchyFacts facts_;  ///< those that outlast a version
    Fingerprint fingerprint_;
    std::vector<std::uint64_t> parts_;  ///< of the fingerprint, by primitive, as all up to holder_
    std::vector<Item> items_;
    std::vector<std::uint32_t> cell_of_;  ///< where a split leaves it
    std::vector<Racer> racers_;           ///< where samples move, as holder_
    std::vector<std::uint32_t> holder_;   ///< the cell in whose sample it is, or none
    std::vector<Twig> twigs_;             ///< the root first
    std::vector<std::uint32_t> free_;     ///< twigs that are not in use
    std::uint32_t version_ = 0;

    // While a version is made.
    std::span<const P> primitives_;
    Arrays before_{};
    std::vector<std::uint32_t> touched_, removed_, run_;
    std::vector<pool_element_of<A>> pool_;
    Data data_;
};

}  // namespace farfield::detail
