// A hierarchy is built in phases: split (cell_splitter.hpp, or polygon_splitter.hpp where polygons are cut) ->
// order, depth first -> drafts of stand-ins, bottom up -> samples move up (move_up.hpp) -> which stand-ins pay -> which
// of these are needed (prune_stand_ins.hpp) -> freeze. Only freezing makes runs: policies may still move items before
// it.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "farfield/build/build_control.hpp"
#include "farfield/build/build_node.hpp"
#include "farfield/build/cell_splitter.hpp"
#include "farfield/build/move_up.hpp"
#include "farfield/build/polygon_splitter.hpp"
#include "farfield/build/prune_stand_ins.hpp"
#include "farfield/build/sample_race.hpp"
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

    HierarchyBuilder(std::span<const P> primitives, const Partition_& partition, const A& approximation, const C& cost,
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
        freeze();
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
        if constexpr (finishes_early) {
            if (merges) {
                finish_bottom_up();
                if constexpr (A::facts.samples_primitives) move_up();
                choose_what_pays([&](std::size_t n) { return finished_[n]; });
                if constexpr (A::facts.samples_primitives) drop_idle_nodes();
                return;
            }
        }
        std::vector<typename A::stand_in_draft> drafts(nodes_.size());
        sample(drafts, merges);
        if constexpr (A::facts.merges_octants) {
            if (merges) merge(drafts);
        }
        if constexpr (A::facts.samples_primitives) move_up();
        if (root_draft_ != nullptr) *root_draft_ = drafts[0];
        choose_what_pays(
            [&](std::size_t n) { return finished_stand_in(approximation_, nodes_[n].cell, drafts[n], data_.pool); });
        if constexpr (A::facts.samples_primitives) drop_idle_nodes();
        if constexpr (A::facts.compares && Partition_::facts.children_are_octants) {
            prune_redundant_stand_ins<Partition_>(approximation_, std::span(nodes_),
                                                  std::span<const typename A::stand_in_draft>(drafts));
        }
    }

    /// Drafts are large, and once its parent has been merged a cell's draft is of use only where stand-ins are compared
    /// with one another or put into a pool in the order of nodes. Elsewhere a subtree that fits into a processor's
    /// cache is drafted, merged and finished depth first, in a few drafts' memory.
    static constexpr bool finishes_early = A::facts.merges_octants && !A::facts.compares && !A::facts.has_pool;

    void finish_bottom_up() {
        using Draft = typename A::stand_in_draft;
        constexpr std::uint32_t most_items = 4096;
        const auto is_small = [&](const DraftCell& n) { return n.end_item - n.first_item <= most_items; };
        // The largest subtrees that are small, and what is above them.
        std::vector<std::uint32_t> roots, place(nodes_.size(), 0);
        std::uint32_t drafts_kept = 0;
        for (std::uint32_t n = 0; n < nodes_.size(); ++n) {
            const DraftCell& node = nodes_[n];
            if (n != 0 && place[n] == 0) continue;
            place[n] = ++drafts_kept;
            if (is_small(node)) {
                roots.push_back(n);
                continue;
            }
            for (int c = 0; c < std::popcount(node.child_mask); ++c) place[node.first_child + unsigned(c)] = 1;
        }
        finished_.resize(nodes_.size());
        std::vector<Draft> kept(drafts_kept + 1);
        constexpr std::size_t chunk = 8;
        control_.run(BuildPhase::sampling, (roots.size() + chunk - 1) / chunk, [&](std::size_t i) {
            Sampler sampler = sampler_;
            std::vector<Draft> drafts(8 * std::size_t(data_.facts.report.levels));
            for (std::size_t r = i * chunk; r < std::min((i + 1) * chunk, roots.size()); ++r) {
                finish_subtree(roots[r], kept[place[roots[r]]], std::span(drafts), sampler);
            }
        });
        run_bottom_up(control_, levels_of(std::span<const DraftCell>(nodes_)), [&](std::size_t n) {
            if (place[n] == 0 || is_small(nodes_[n])) return;
            Sampler sampler = sampler_;
            Draft& draft = kept[place[n]];
            draft = own_draft(nodes_[n], sampler);
            merge(n, draft, [&](std::uint32_t child) { return &kept[place[child]]; });
            finished_[n] = finished_stand_in(approximation_, nodes_[n].cell, draft, data_.pool);
        });
        if (root_draft_ != nullptr) *root_draft_ = kept[place[0]];
    }
    /// The first eight drafts are for the node's children, and all others for what is below these.
    template <class Draft>
    void finish_subtree(std::uint32_t n, Draft& draft, std::span<Draft> drafts, Sampler& sampler) {
        const DraftCell& node = nodes_[n];
        for (int c = 0; c < std::popcount(node.child_mask); ++c) {
            finish_subtree(node.first_child + unsigned(c), drafts[std::size_t(c)], drafts.subspan(8), sampler);
        }
        draft = own_draft(node, sampler);
        merge(n, draft, [&](std::uint32_t child) { return &drafts[child - node.first_child]; });
        finished_[n] = finished_stand_in(approximation_, node.cell, draft, data_.pool);
    }

    /// Primitives lie in the user's order and are wanted in the hierarchy's: every one is a miss, unless asked for
    /// early.
    void prefetch(std::uint32_t position) const {
#if defined(__GNUC__)
        if (position >= data_.order.size()) return;
        const char* primitive = reinterpret_cast<const char*>(&primitives_[data_.order[position]]);
        __builtin_prefetch(primitive);
        if constexpr (sizeof(P) > 16) __builtin_prefetch(primitive + sizeof(P) - 1);
#endif
    }

    template <class Sink>
    void send_polygons(std::uint32_t position, Sink& sink) const {
        if constexpr (cuts) {
            if (const Polygon fragment = Fragments(data_.fragments)[position]; !fragment.vertices.empty()) {
                sink(fragment);
                return;
            }
        }
        prefetch(position + 12);
        if constexpr (PrimitiveWithPolygons<P>) {
            local_polygons(primitives_[data_.order[position]], data_.facts.origin, sink);
        }
    }

    /// Every cell's draft by itself: of its own run where children are merged afterwards, else of its subtree.
    template <class Draft>
    void sample(std::vector<Draft>& drafts, bool merges) {
        constexpr std::size_t chunk = 64;
        control_.run(BuildPhase::sampling, (nodes_.size() + chunk - 1) / chunk, [&](std::size_t i) {
            Sampler sampler = sampler_;
            for (std::size_t n = i * chunk; n < std::min((i + 1) * chunk, nodes_.size()); ++n) {
                const DraftCell& node = nodes_[n];
                const std::uint32_t end = merges ? node.first_item + std::uint32_t(node.count) : node.end_item;
                if (node.first_item == end || !(node.cost > least_cost_)) continue;
                drafts[n] = draft_of(node, end, sampler);
            }
        });
    }
    auto draft_of(const DraftCell& node, std::uint32_t end, Sampler& sampler) const {
        const auto contents = [&](auto&& sink) {
            for (std::uint32_t at = node.first_item; at < end; ++at) send_polygons(at, sink);
        };
        return approximation_.sample(node.cell, contents, sampler);
    }
    /// Of the cell's own run, to which children are merged.
    auto own_draft(const DraftCell& node, Sampler& sampler) const {
        if (node.count == 0 || !(node.cost > least_cost_)) return typename A::stand_in_draft{};
        return draft_of(node, node.first_item + std::uint32_t(node.count), sampler);
    }

    template <class Draft>
    void merge(std::vector<Draft>& drafts) {
        run_bottom_up(control_, levels_of(std::span<const DraftCell>(nodes_)),
                      [&](std::size_t n) { merge(n, drafts[n], [&](std::uint32_t child) { return &drafts[child]; }); });
    }
    template <class Draft, class DraftOfChild>
    void merge(std::size_t n, Draft& draft, DraftOfChild&& draft_of_child) const {
        const DraftCell& node = nodes_[n];
        std::array<ChildDraft<Draft>, 8> children;
        unsigned count = 0;
        for (unsigned mask = node.child_mask; mask != 0; mask &= mask - 1, ++count) {
            const std::uint32_t at = node.first_child + count;
            children[count] = {unsigned(std::countr_zero(mask)), &nodes_[at].cell, draft_of_child(at)};
        }
        if (count != 0) {
            approximation_.merge(node.cell, draft, std::span<const ChildDraft<Draft>>(children.data(), count));
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

    /// Takes away nodes that moving has emptied, and those below which nothing stands in any more and culling does not
    /// pay.
    void drop_idle_nodes() {
        std::vector<char> stands_in_below(nodes_.size(), 0);
        for (std::size_t n = nodes_.size(); n-- > 0;) {
            DraftCell& node = nodes_[n];
            const auto children =
                std::span(nodes_).subspan(node.first_child, std::size_t(std::popcount(node.child_mask)));
            for (std::size_t c = 0; c < children.size(); ++c) {
                const bool stands_in =
                    stands_in_below[node.first_child + c] != 0 || children[c].stand_in != no_stand_in;
                if (stands_in) stands_in_below[n] = 1;
            }
            if (stands_in_below[n] == 0 && node.end_item - node.first_item <= max_items_unculled) {
                drop_descendants(node);
                continue;
            }
            unsigned mask = node.child_mask;
            std::uint32_t first_left = 0;
            for (DraftCell& child : children) {
                const unsigned bit = mask & (0u - mask);
                mask &= mask - 1;
                if (child.first_item == child.end_item) {
                    drop(child);
                    node.child_mask = std::uint8_t(node.child_mask & ~bit);
                } else if (first_left == 0) {
                    first_left = std::uint32_t(&child - nodes_.data());
                }
            }
            node.first_child = first_left;
        }
    }

    /// The items of a node's descendants follow its own and become its own.
    void drop_descendants(DraftCell& node) {
        for (std::uint32_t n = node.first_child; node.child_mask != 0; ++n) {
            if (nodes_[n].is_pruned) continue;
            node.child_mask = std::uint8_t(node.child_mask & (node.child_mask - 1));
            drop(nodes_[n]);
        }
        node.first_child = 0;
    }
    void drop(DraftCell& node) {
        drop_descendants(node);
        node.is_pruned = true;
        --data_.facts.report.stand_ins_that_would_not_pay;
    }

    /// Nodes in the order that they will have, which is that of the pool.
    std::vector<std::uint32_t> nodes_by_place() const {
        std::vector<std::uint32_t> order(nodes_.size());
        for (std::size_t n = 0; n < nodes_.size(); ++n) order[nodes_[n].place] = std::uint32_t(n);
        return order;
    }

    /// "The cost of rendering the primitives is no more than the cost of rendering the color-cube": then there is none.
    /// stand_in_of(node) is what finished_stand_in() makes of its draft.
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
            for (const std::uint32_t n : nodes_by_place()) {
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
            for (const std::uint32_t n : nodes_by_place()) keep_if_it_pays(n, all[n]);
        }
    }
    /// A stand-in once samples have moved.
    auto sampled([[maybe_unused]] std::size_t n, typename A::stand_in_data data) const {
        if constexpr (A::facts.samples_primitives) data = approximation_.sampled(data, sampled_cells_[n]);
        return data;
    }

    // --- freezing

    void freeze() {
        const std::vector<std::uint32_t> by_place = nodes_by_place();
        std::uint32_t count = 0;
        for (const std::uint32_t n : by_place) {
            if (!nodes_[n].is_pruned) nodes_[n].place = count++;
        }
        data_.nodes.resize(count);
        if constexpr (!std::is_empty_v<typename Partition_::node_data>) data_.node_data.reserve(count);
        std::vector<std::uint32_t> stand_in_of(count, no_stand_in);
        for (const std::uint32_t n : by_place) {
            const DraftCell& node = nodes_[n];
            if (node.is_pruned) continue;
            Node& out = data_.nodes[node.place];
            out.first_item = node.first_item;
            out.child_mask = node.child_mask;
            out.first_child = node.child_mask != 0 ? nodes_[node.first_child].place : 0;
            out.levels_replaced = node.levels_replaced;
            if constexpr (!std::is_empty_v<typename Partition_::node_data>) data_.node_data.push_back(node.data);
            if constexpr (A::facts.stands_in) {
                if (node.stand_in == no_stand_in) continue;
                stand_in_of[node.place] = std::uint32_t(data_.stand_ins.size());
                data_.stand_ins.push_back(stand_ins_[node.stand_in]);
            }
        }
        for (std::size_t i = count; i-- > 0;) mark_stand_ins(data_.nodes[i], i, stand_in_of);
        data_.facts.root_has_stand_in = stand_in_of[0] != no_stand_in ? 1u : 0u;
        data_.facts.report.items = data_.order.size();
        data_.facts.report.pieces = pieces();
        data_.facts.report.nodes = count;
        data_.facts.report.leaves = std::uint32_t(
            std::count_if(data_.nodes.begin(), data_.nodes.end(), [](const Node& n) { return n.child_mask == 0; }));
        data_.facts.report.stand_ins = std::uint32_t(data_.stand_ins.size());
    }

    /// Items that are pieces of polygons: all but instances.
    std::uint64_t pieces() const {
        std::uint64_t count = 0;
        const std::vector<std::uint32_t>& first = data_.fragments.first_vertex;
        for (std::size_t i = 1; i < first.size(); ++i) count += first[i] != first[i - 1];
        return count;
    }

    void mark_stand_ins(Node& node, std::size_t index, const std::vector<std::uint32_t>& stand_in_of) {
        std::uint32_t child = node.first_child;
        for (unsigned mask = node.child_mask; mask != 0; mask &= mask - 1, ++child) {
            if (stand_in_of[child] == no_stand_in) continue;
            if (node.stand_in_mask == 0) node.first_child_data = stand_in_of[child];
            node.stand_in_mask = std::uint8_t(node.stand_in_mask | (mask & (0u - mask)));
        }
        mark_levels_below(node, std::span<const Node>(data_.nodes).subspan(node.first_child),
                          stand_in_of[index] != no_stand_in);
    }

    std::span<const P> primitives_;
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
    std::vector<typename A::stand_in_data> finished_{};   ///< parallel to nodes_, where they are finished early
    std::vector<typename A::stand_in_data> stand_ins_{};  ///< those that pay, by BuildNode::stand_in
    float least_cost_ = -1;                               ///< of a subtree that is drafted
    std::vector<SampledCell> sampled_cells_;              ///< parallel to nodes_; empty where nothing moves
};

}  // namespace farfield::detail
