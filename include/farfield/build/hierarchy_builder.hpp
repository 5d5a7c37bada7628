// A hierarchy is built in phases: split (cell_splitter.hpp, or polygon_splitter.hpp where polygons are cut) ->
// order, depth first -> drafts of stand-ins (stand_in_drafter.hpp) -> samples move up (move_up.hpp) -> which stand-ins
// pay, and which nodes then do nothing (idle_nodes.hpp) -> which stand-ins are needed (prune_stand_ins.hpp) -> freeze
// (freeze.hpp). Only freezing makes runs: policies may still move items before it.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "farfield/build/build_control.hpp"
#include "farfield/build/build_node.hpp"
#include "farfield/build/cell_splitter.hpp"
#include "farfield/build/freeze.hpp"
#include "farfield/build/group_by_key.hpp"
#include "farfield/build/idle_nodes.hpp"
#include "farfield/build/move_up.hpp"
#include "farfield/build/polygon_splitter.hpp"
#include "farfield/build/prune_stand_ins.hpp"
#include "farfield/build/sample_race.hpp"
#include "farfield/build/stand_in_drafter.hpp"
#include "farfield/composition.hpp"
#include "farfield/hierarchy/hierarchy_data.hpp"

namespace farfield::detail {

template <class A>
struct DraftOfApproximation {
    using type = void;
};
template <class A>
requires(A::facts.stands_in) struct DraftOfApproximation<A> {
    using type = typename A::stand_in_draft;
};
template <class A>
using DraftOf = typename DraftOfApproximation<A>::type;

/// Options are borrowed. H is a SpatialHierarchy.
template <class H, Primitive P, OrthographicSampler Sampler>
class HierarchyBuilder {
    using Partition_ = typename H::partition_type;
    using A = typename H::approximation_type;
    using C = typename H::cost_model_type;

  public:
    using Data = HierarchyData<Partition_, A>;

    HierarchyBuilder(PrimitiveSpan<P> primitives, const Partition_& partition, const A& approximation, const C& cost,
                     const Sampler& sampler, const BuildBudget& budget, const BuildControl& control)
        : primitives_(primitives),
          partition_(partition),
          approximation_(approximation),
          cost_(cost),
          sampler_(sampler),
          budget_(budget),
          control_(control) {}

    Data build() {
        {
            Splitter splitter(primitives_, partition_, approximation_, cost_, budget_, control_, data_);
            splitter.split();
            nodes_ = std::move(splitter.drafts());
            order_depth_first([&](std::size_t n) { splitter.append_items(nodes_[n]); });
        }
        if constexpr (A::facts.stands_in) make_stand_ins();
        freeze<Partition_, A>(nodes_, stand_ins_, data_);
        if constexpr (groups_by_key<H, P>) group_runs(primitives_, data_);
        return std::move(data_);
    }

    /// Builds a part of a scene (BuildBudget::part), for whoever puts parts together: its root has a stand-in whether
    /// or not that pays, and what this is made from.
    Data build_part(std::add_pointer_t<DraftOf<A>> root) requires(A::facts.stands_in) {
        root_draft_ = root;
        return build();
    }

  private:
    using DraftCell = BuildNode<typename Partition_::node_data>;
    static constexpr bool cuts = H::assignment == Assignment::clipped;
    static auto splitter_type() {
        if constexpr (cuts) {
            return std::type_identity<PolygonSplitter<Partition_, A, C, P>>{};
        } else {
            return std::type_identity<CellSplitter<Partition_, A, C, P>>{};
        }
    }
    using Splitter = typename decltype(splitter_type())::type;

    /// New places of nodes (blocks of siblings, depth first) and of items, which append_items(node) appends to the
    /// order; costs summed up from the leaves.
    template <class AppendItems>
    void order_depth_first(AppendItems&& append_items) {
        std::uint32_t next = 1, items = 0;
        std::vector<std::pair<std::uint32_t, bool>> stack{{0, false}};
        while (!stack.empty()) {
            const auto [n, children_done] = stack.back();
            stack.pop_back();
            DraftCell& node = nodes_[n];
            if (children_done) {
                node.end_item = items;
                continue;
            }
            node.first_item = items;
            append_items(n);
            items += std::uint32_t(node.count);
            stack.emplace_back(n, true);
            const auto children = unsigned(std::popcount(node.child_mask));
            for (unsigned c = 0; c < children; ++c) nodes_[node.first_child + c].place = next + c;
            next += children;
            for (unsigned c = children; c-- > 0;) stack.emplace_back(node.first_child + c, false);
        }
        for (std::size_t n = nodes_.size(); n-- > 0;) {
            const DraftCell& node = nodes_[n];
            for (int c = 0; c < std::popcount(node.child_mask); ++c) {
                nodes_[n].cost += nodes_[node.first_child + unsigned(c)].cost;
            }
        }
    }

    // --- stand-ins

    void make_stand_ins() {
        bool merges = false;
        if constexpr (A::facts.merges_octants && Partition_::facts.children_are_octants) {
            merges = approximation_.merges_children();
        }
        // Cells of a few pieces are most of them; where their parents need no drafts, neither do they.
        if (cuts && !merges) least_cost_ = cost_.cost(approximation_.expected_work());
        StandInDrafter<H, P, Sampler> drafter(primitives_, approximation_, sampler_, control_, std::span(nodes_), data_,
                                              least_cost_);
        if constexpr (drafter.finishes_early) {
            if (merges) {
                const auto finished = drafter.finish_bottom_up(root_draft_);
                choose_among_moved([&](std::size_t n) { return finished[n]; });
                return;
            }
        }
        const std::vector<typename A::stand_in_draft> drafts = drafter.drafts(merges);
        if (root_draft_ != nullptr) *root_draft_ = drafts[0];
        choose_among_moved(
            [&](std::size_t n) { return finished_stand_in(approximation_, nodes_[n].cell, drafts[n], data_.pool); });
        if constexpr (A::facts.compares && Partition_::facts.children_are_octants) {
            prune_redundant_stand_ins<Partition_>(approximation_, std::span(nodes_), std::span(drafts));
        }
    }

    /// stand_in_of(node) is what finished_stand_in() makes of its draft.
    template <class StandInOf>
    void choose_among_moved(StandInOf&& stand_in_of) {
        if constexpr (A::facts.samples_primitives) move_up();
        choose_what_pays(stand_in_of);
        if constexpr (A::facts.samples_primitives) {
            data_.facts.report.stand_ins_that_would_not_pay -= IdleNodes(std::span(nodes_)).drop();
        }
    }

    // --- samples

    void move_up() {
        constexpr std::size_t chunk = 4096;
        const float scale = data_.facts.root.to_ordinary();
        std::vector<Racer> racers(primitives_.size());
        control_.run_quietly((racers.size() + chunk - 1) / chunk, [&](std::size_t i) {
            for (std::size_t p = i * chunk; p < std::min((i + 1) * chunk, racers.size()); ++p) {
                racers[p] = racer_of(approximation_, primitives_[p], std::uint32_t(p), data_.facts.origin, scale);
            }
        });
        std::vector<std::uint32_t> moved;
        moved.reserve(data_.order.size());
        const SampleRace<A> race(approximation_, racers, scale);
        MoveUp<A, DraftCell> samples(race, nodes_, data_.order, control_);
        samples.find_samples();
        control_.run_quietly((nodes_.size() + chunk - 1) / chunk, [&](std::size_t i) {
            for (std::size_t n = i * chunk; n < std::min((i + 1) * chunk, nodes_.size()); ++n) {
                nodes_[n].count = samples.run(n).size();
                nodes_[n].cost = 0;
                for (const std::uint32_t p : samples.run(n)) nodes_[n].cost += cost_.cost(work_of(primitives_[p]));
            }
        });
        order_depth_first(
            [&](std::size_t n) { moved.insert(moved.end(), samples.run(n).begin(), samples.run(n).end()); });
        sampled_cells_ = samples.sampled_cells();
        data_.order = std::move(moved);
    }

    /// "The cost of rendering the primitives is no more than the cost of rendering the color-cube": then there is none.
    template <class StandInOf>
    void choose_what_pays(StandInOf&& stand_in_of) {
        const auto keep_if_it_pays = [&](std::uint32_t n, const typename A::stand_in_data& data) {
            DraftCell& node = nodes_[n];
            const bool pays =
                (node.cost > least_cost_ && node.cost > cost_.cost(work_of_stand_in(approximation_, data))) ||
                (n == 0 && root_draft_ != nullptr);
            if (pays) {
                node.stand_in = std::uint32_t(stand_ins_.size());
                stand_ins_.push_back(data);
            } else {
                ++data_.facts.report.stand_ins_that_would_not_pay;
            }
            return pays;
        };
        if constexpr (A::facts.has_pool) {
            for (const std::uint32_t n : nodes_by_place(std::span<const DraftCell>(nodes_))) {
                const std::size_t pool_size = data_.pool.size();
                if (!keep_if_it_pays(n, sampled(n, stand_in_of(n)))) data_.pool.resize(pool_size);
            }
        } else {
            constexpr std::size_t chunk = 256;
            std::vector<typename A::stand_in_data> all(nodes_.size());
            control_.run_quietly((all.size() + chunk - 1) / chunk, [&](std::size_t i) {
                for (std::size_t n = i * chunk; n < std::min((i + 1) * chunk, all.size()); ++n) {
                    all[n] = sampled(n, stand_in_of(n));
                }
            });
            for (const std::uint32_t n : nodes_by_place(std::span<const DraftCell>(nodes_))) keep_if_it_pays(n, all[n]);
        }
    }
    /// A stand-in once samples have moved.
    auto sampled([[maybe_unused]] std::size_t n, typename A::stand_in_data data) const {
        if constexpr (A::facts.samples_primitives) data = approximation_.sampled(data, sampled_cells_[n]);
        return data;
    }

    PrimitiveSpan<P> primitives_;
    const Partition_& partition_;
    const A& approximation_;
    const C& cost_;
    const Sampler& sampler_;
    BuildBudget budget_;
    const BuildControl& control_;

    /// Null where the whole scene is built. Of no use to what makes no stand-ins.
    std::add_pointer_t<DraftOf<A>> root_draft_ = nullptr;
    Data data_;
    std::vector<DraftCell> nodes_;                        ///< parents before children
    std::vector<typename A::stand_in_data> stand_ins_{};  ///< those that pay, by BuildNode::stand_in
    float least_cost_ = -1;                               ///< of a subtree that is drafted
    std::vector<SampledCell> sampled_cells_;              ///< parallel to nodes_; empty where nothing moves
};

}  // namespace farfield::detail
