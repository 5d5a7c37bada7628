// A phase of a build: every cell's stand-in is drafted, from its own run and the drafts of its children or from its
// whole subtree.
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
#include "farfield/build/painted_contents.hpp"
#include "farfield/composition.hpp"
#include "farfield/hierarchy/hierarchy_data.hpp"

namespace farfield::detail {

/// Everything is borrowed. H is a SpatialHierarchy; nodes come parents before children, and have their places and
/// items.
template <class H, Primitive P, OrthographicSampler Sampler>
class StandInDrafter {
    using Partition_ = typename H::partition_type;
    using A = typename H::approximation_type;
    using Draft = typename A::stand_in_draft;
    using DraftCell = BuildNode<typename Partition_::node_data>;

  public:
    using Data = HierarchyData<Partition_, A>;

    /// Cells that cost no more than least_cost are not drafted.
    StandInDrafter(PrimitiveSpan<P> primitives, const A& approximation, const Sampler& sampler,
                   const BuildControl& control, std::span<const DraftCell> nodes, Data& data, float least_cost)
        : primitives_(primitives),
          approximation_(approximation),
          sampler_(sampler),
          control_(control),
          nodes_(nodes),
          data_(data),
          least_cost_(least_cost) {}

    /// The drafts of all nodes: merged from their children's, or each by itself.
    std::vector<Draft> drafts(bool merges) {
        std::vector<Draft> drafts(nodes_.size());
        sample(drafts, merges);
        if constexpr (A::facts.merges_octants) {
            if (merges) merge(drafts);
        }
        return drafts;
    }

    /// Drafts are large, and once its parent has been merged a cell's draft is of use only where stand-ins are compared
    /// with one another or put into a pool in the order of nodes. Elsewhere a subtree that fits into a processor's
    /// cache is drafted, merged and finished depth first, in a few drafts' memory.
    static constexpr bool finishes_early = A::facts.merges_octants && !A::facts.compares && !A::facts.has_pool;

    /// The finished stand-ins of all nodes, from merged drafts; the root's draft in `root`, unless that is null.
    std::vector<typename A::stand_in_data> finish_bottom_up(Draft* root) {
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
        if (root != nullptr) *root = kept[place[0]];
        return std::move(finished_);
    }

  private:
    static constexpr bool cuts = H::assignment == Assignment::clipped;

    /// The first eight drafts are for the node's children, and all others for what is below these.
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
        if (position < data_.order.size()) prefetch_primitive<P>(primitives_, data_.order[position]);
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
    Draft draft_of(const DraftCell& node, std::uint32_t end, Sampler& sampler) const {
        const auto contents = [&](auto&& sink) {
            for (std::uint32_t at = node.first_item; at < end; ++at) send_polygons(at, sink);
        };
        return with_painted(sampler, node.cell, contents,
                            [&](const auto& painted) { return approximation_.sample(node.cell, painted, sampler); });
    }
    /// Of the cell's own run, to which children are merged.
    Draft own_draft(const DraftCell& node, Sampler& sampler) const {
        if (node.count == 0 || !(node.cost > least_cost_)) return Draft{};
        return draft_of(node, node.first_item + std::uint32_t(node.count), sampler);
    }

    void merge(std::vector<Draft>& drafts) {
        run_bottom_up(control_, levels_of(std::span<const DraftCell>(nodes_)),
                      [&](std::size_t n) { merge(n, drafts[n], [&](std::uint32_t child) { return &drafts[child]; }); });
    }
    template <class DraftOfChild>
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

    PrimitiveSpan<P> primitives_;
    const A& approximation_;
    const Sampler& sampler_;
    const BuildControl& control_;
    std::span<const DraftCell> nodes_;
    Data& data_;
    float least_cost_;
    std::vector<typename A::stand_in_data> finished_{};  ///< parallel to nodes_
};

}  // namespace farfield::detail
