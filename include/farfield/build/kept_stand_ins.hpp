// What stands in for every cell, kept from one version to the next: drafts, samples, and what of them pays. The second
// of the layers of cell_tree.hpp.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>
#include <utility>
#include <vector>

#include "farfield/approximation.hpp"
#include "farfield/build/build_control.hpp"
#include "farfield/build/kept_cells.hpp"
#include "farfield/build/painted_contents.hpp"
#include "farfield/build/prune_stand_ins.hpp"
#include "farfield/build/sample_race.hpp"
#include "farfield/hierarchy/node.hpp"

namespace farfield::detail {

template <class H, Primitive P, OrthographicSampler Sampler>
class KeptStandIns : protected KeptCells<H, P> {
  protected:
    using Cells = KeptCells<H, P>;
    using Cells::approximation_, Cells::cell_of_, Cells::cost_, Cells::facts_, Cells::items_, Cells::primitives_,
        Cells::touched_, Cells::twigs_;
    using Cells::compares, Cells::none, Cells::samples, Cells::stands_in;
    using Cells::for_each_child, Cells::children_of, Cells::is_split, Cells::is_stale, Cells::mark_stale,
        Cells::visit_runs;
    using typename Cells::Partition_, typename Cells::A, typename Cells::C, typename Cells::Twig, typename Cells::Tally;

    KeptStandIns(const Partition_& partition, const A& approximation, const C& cost, const Sampler& sampler)
        : Cells(partition, approximation, cost), sampler_(sampler) {}

    void set_racer(std::uint32_t i) {
        racers_[i] = racer_of(approximation_, primitives_[i], i, facts_.origin, facts_.root.to_ordinary());
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
                twigs_[n].draft = with_painted(sampler, twigs_[n].cell, contents, [&](const auto& painted) {
                    return approximation_.sample(twigs_[n].cell, painted, sampler);
                });
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
            twig.left = race.left_of(twig.cell, twig.about.area, run_, sampled, twig.own.size(), [&](auto&& take) {
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

    Sampler sampler_;
    std::vector<Racer> racers_;          ///< by primitive, where samples move, as holder_
    std::vector<std::uint32_t> holder_;  ///< the cell in whose sample it is, or none

    // While a version is made.
    std::vector<std::uint32_t> run_;
    std::vector<pool_element_of<A>> pool_;
};

}  // namespace farfield::detail
