// How a hierarchy is built, in phases: split (cell_splitter.hpp, or cell_clipper.hpp where polygons are cut) -> order,
// depth first -> stand-ins, bottom up -> freeze, which keeps what pays and is not told already (story_merger.hpp). Only
// freezing makes runs: policies may still move items before it.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "farfield/cell_clipper.hpp"
#include "farfield/cell_splitter.hpp"
#include "farfield/hierarchy_parts.hpp"
#include "farfield/policy.hpp"
#include "farfield/story_merger.hpp"

namespace farfield {

/// Runs f(0) ... f(count - 1). Executors may run them at once and in any order; parallel.hpp has one with threads.
struct SerialExecutor {
    template <class F>
    void operator()(std::size_t count, F&& f) const {
        for (std::size_t i = 0; i < count; ++i) f(i);
    }
};

namespace detail {

template <Partition Part, Approximation A, CostModel C, Primitive P, OrthographicSampler Sampler, class Executor>
class HierarchyBuilder {
  public:
    using Parts = HierarchyParts<Part, A>;

    HierarchyBuilder(std::span<const P> primitives, const Part& partition, const A& approximation, const C& cost,
                     const Sampler& sampler, const BuildOptions& options, const Executor& executor)
        : primitives_(primitives),
          partition_(partition),
          approximation_(approximation),
          cost_(cost),
          sampler_(sampler),
          options_(options),
          executor_(executor) {}

    Parts build() {
        {
            Splitter splitter(primitives_, partition_, approximation_, cost_, options_, executor_, parts_);
            splitter.split();
            drafts_ = std::move(splitter.drafts());
            order_depth_first(splitter);
        }
        std::vector<typename decltype(draft_type())::type> drafts;
        if constexpr (A::facts.stands_in) make_drafts(drafts);
        freeze(drafts);
        return std::move(parts_);
    }

  private:
    using DraftCell = DraftNode<typename Part::node_data>;
    static constexpr bool cuts = (Part::facts.offers & A::facts.accepts & (unique | clipped)) == clipped;

    static auto splitter_type() {
        if constexpr (cuts) {
            return std::type_identity<CellClipper<Part, A, C, P, Executor>>{};
        } else {
            return std::type_identity<CellSplitter<Part, A, C, P, Executor>>{};
        }
    }
    using Splitter = typename decltype(splitter_type())::type;

    static auto draft_type() {
        if constexpr (A::facts.stands_in) {
            return std::type_identity<typename A::draft>{};
        } else {
            return std::type_identity<char>{};
        }
    }

    /// New places of nodes (blocks of siblings, depth first) and of items; costs summed up from the leaves.
    void order_depth_first(Splitter& splitter) {
        new_index_.resize(drafts_.size());
        first_item_.resize(drafts_.size());
        end_item_.resize(drafts_.size());
        std::uint32_t next = 1;
        std::vector<std::pair<std::uint32_t, bool>> stack{{0, false}};
        while (!stack.empty()) {
            const auto [n, children_done] = stack.back();
            stack.pop_back();
            if (children_done) {
                end_item_[n] = std::uint32_t(parts_.order.size());
                continue;
            }
            const DraftCell& node = drafts_[n];
            first_item_[n] = std::uint32_t(parts_.order.size());
            splitter.append_items(node);
            stack.emplace_back(n, true);
            const auto children = unsigned(std::popcount(node.child_mask));
            for (unsigned c = 0; c < children; ++c) new_index_[node.first_child + c] = next + c;
            next += children;
            for (unsigned c = children; c-- > 0;) stack.emplace_back(node.first_child + c, false);
        }
        for (std::size_t n = drafts_.size(); n-- > 0;) {
            const DraftCell& node = drafts_[n];
            for (int c = 0; c < std::popcount(node.child_mask); ++c) {
                drafts_[n].cost += drafts_[node.first_child + unsigned(c)].cost;
            }
        }
    }

    /// Primitives lie in the user's order and are wanted in the hierarchy's: every one is a miss, unless asked for
    /// early.
    void prefetch(std::uint32_t position) const {
#if defined(__GNUC__)
        if (position >= parts_.order.size()) return;
        const char* primitive = reinterpret_cast<const char*>(&primitives_[parts_.order[position]]);
        __builtin_prefetch(primitive);
        if constexpr (sizeof(P) > 16) __builtin_prefetch(primitive + sizeof(P) - 1);
#endif
    }

    template <class Sink>
    void send_polygons(std::uint32_t position, Sink& sink) const {
        if constexpr (cuts) {
            if (const Polygon fragment = Fragments(parts_.fragments)[position]; !fragment.vertices.empty()) {
                sink(fragment);
                return;
            }
        }
        prefetch(position + 12);
        if constexpr (PrimitiveWithPolygons<P>) {
            local_polygons(primitives_[parts_.order[position]], parts_.origin, sink);
        }
    }

    template <class Draft>
    void make_drafts(std::vector<Draft>& drafts) {
        drafts.resize(drafts_.size());
        const bool all = approximation_.wants_all_contents(Part::facts);
        // Cells of a few pieces are most of them; where their parents need no drafts, neither do they.
        if (cuts && all) least_cost_ = cost_.cost(approximation_.expected_work());
        constexpr std::size_t chunk = 64;
        executor_((drafts_.size() + chunk - 1) / chunk, [&](std::size_t i) {
            Sampler sampler = sampler_;
            for (std::size_t n = i * chunk; n < std::min((i + 1) * chunk, drafts_.size()); ++n) {
                const std::uint32_t end = all ? end_item_[n] : first_item_[n] + std::uint32_t(drafts_[n].count);
                if (first_item_[n] == end || !(drafts_[n].cost > least_cost_)) continue;
                const auto contents = [&](auto&& sink) {
                    for (std::uint32_t at = first_item_[n]; at < end; ++at) send_polygons(at, sink);
                };
                drafts[n] = approximation_.sample(drafts_[n].cell, contents, sampler);
            }
        });
        if (all) return;
        for (std::size_t n = drafts_.size(); n-- > 0;) {
            const DraftCell& node = drafts_[n];
            std::array<ChildDraft<Draft>, 8> children;
            unsigned count = 0;
            for (unsigned mask = node.child_mask; mask != 0; mask &= mask - 1, ++count) {
                const std::uint32_t at = node.first_child + count;
                children[count] = {unsigned(std::countr_zero(mask)), &drafts_[at].cell, &drafts[at]};
            }
            if (count != 0) {
                approximation_.merge(node.cell, drafts[n], std::span<const ChildDraft<Draft>>(children.data(), count));
            }
        }
    }

    template <class Draft>
    void freeze(std::vector<Draft>& drafts) {
        const std::size_t count = drafts_.size();
        std::vector<std::uint32_t> old_index(count);
        for (std::size_t n = 0; n < count; ++n) old_index[new_index_[n]] = std::uint32_t(n);
        parts_.nodes.resize(count);
        std::vector<std::uint32_t> data_index(count, no_stand_in);
        for (std::size_t i = 0; i < count; ++i) {
            const std::uint32_t n = old_index[i];
            const DraftCell& node = drafts_[n];
            Node& out = parts_.nodes[i];
            out.first_item = first_item_[n];
            out.child_mask = node.child_mask;
            out.first_child = node.child_mask != 0 ? new_index_[node.first_child] : 0;
            if constexpr (!std::is_empty_v<typename Part::node_data>) parts_.node_data.push_back(node.data);
            if constexpr (A::facts.stands_in) {
                const std::size_t pool_size = parts_.pool.size();
                const auto data = approximation_.finish(node.cell, drafts[n], parts_.pool);
                if (node.cost > least_cost_ && node.cost > cost_.cost(approximation_.work(data))) {
                    data_index[i] = std::uint32_t(parts_.cell_data.size());
                    parts_.cell_data.push_back(data);
                } else {
                    parts_.pool.resize(pool_size);
                    ++parts_.report.stand_ins_that_would_not_pay;
                }
            }
        }
        if constexpr (A::facts.compares && Part::facts.halves) {
            StoryMerger<Part, A, DraftCell, Draft>(approximation_, {drafts_, drafts, end_item_, old_index}, parts_,
                                                   data_index)
                .merge();
        }
        for (std::size_t i = parts_.nodes.size(); i-- > 0;) mark_stand_ins(parts_.nodes[i], i, data_index);
        parts_.root_has_stand_in = data_index[0] != no_stand_in;
        parts_.report.items = parts_.order.size();
        parts_.report.nodes = std::uint32_t(parts_.nodes.size());
        parts_.report.leaves = std::uint32_t(
            std::count_if(parts_.nodes.begin(), parts_.nodes.end(), [](const Node& n) { return n.child_mask == 0; }));
        parts_.report.stand_ins = std::uint32_t(parts_.cell_data.size());
        if constexpr (std::is_empty_v<typename A::cell_data>) parts_.cell_data = {};
    }

    void mark_stand_ins(Node& node, std::size_t index, const std::vector<std::uint32_t>& data_index) {
        unsigned deepest = Node::nothing_below;
        std::uint32_t child = node.first_child;
        for (unsigned mask = node.child_mask; mask != 0; mask &= mask - 1, ++child) {
            unsigned below = parts_.nodes[child].levels_to_last_stand_in;
            if (data_index[child] != no_stand_in) {
                if (below == 0) below = parts_.nodes[child].stand_in_reach;
                if (node.stand_in_mask == 0) node.first_child_data = data_index[child];
                node.stand_in_mask = std::uint8_t(node.stand_in_mask | (mask & (0u - mask)));
            }
            if (below != Node::nothing_below) {
                // Where cells are not halved nobody asks for more than whether there are any.
                const unsigned levels = std::min(below + 1, Node::nothing_below - 1u);
                deepest = deepest == Node::nothing_below ? levels : std::max(deepest, levels);
            }
        }
        if (deepest == Node::nothing_below && data_index[index] != no_stand_in) deepest = 0;
        node.levels_to_last_stand_in = std::uint8_t(deepest);
    }

    std::span<const P> primitives_;
    const Part& partition_;
    const A& approximation_;
    const C& cost_;
    const Sampler& sampler_;
    const BuildOptions& options_;
    const Executor& executor_;

    Parts parts_;
    std::vector<DraftCell> drafts_;  ///< parents before children
    std::vector<std::uint32_t> new_index_, first_item_, end_item_;
    float least_cost_ = -1;  ///< of a subtree that is drafted
};

}  // namespace detail
}  // namespace farfield
