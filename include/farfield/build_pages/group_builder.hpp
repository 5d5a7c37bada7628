// Parts of a scene that lie side by side are built in memory, each as it would be in the whole, and cut into pages that
// they share.
#pragma once

#include "farfield/settings.hpp"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <utility>
#include <vector>

#include "farfield/build.hpp"
#include "farfield/build/build_control.hpp"
#include "farfield/build/hierarchy_builder.hpp"
#include "farfield/build_pages/page_build.hpp"
#include "farfield/build_pages/page_share.hpp"
#include "farfield/build_pages/scattered_file.hpp"
#include "farfield/build_pages/top_tree.hpp"
#include "farfield/composition.hpp"
#include "farfield/executor.hpp"
#include "farfield/geometry/box.hpp"
#include "farfield/paging/page_forest.hpp"

namespace farfield {
namespace detail {

/// Any number of threads may build groups with one.
template <class Build>
class GroupBuilder {
    using H = typename Build::hierarchy_type;
    using P = typename Build::primitive_type;
    using Sampler = typename Build::sampler_type;
    using Partition_ = typename H::partition_type;
    using A = typename H::approximation_type;
    using Tree = TopTree<Partition_>;
    using Part = BuiltPart<A>;

  public:
    explicit GroupBuilder(const Build& build) : build_(build) {}

    struct BuiltGroup {
        std::vector<std::byte> pages;
        std::vector<Part> parts;
        std::uint64_t needed_bytes = 0;  ///< 0, or there are no pages, which were too small
    };
    /// `first_item`: where the group begins among the primitives of the share.
    BuiltGroup operator()(const Tree& tree, std::size_t group, const std::filesystem::path& scattered,
                          std::uint64_t first_item) const {
        const std::span<const std::uint32_t> nodes = tree.group(group);
        std::vector<std::size_t> ends;
        const std::vector<P> primitives =
            sorted_by_part(tree, nodes, read_scattered<P>(scattered, first_item, tree.items_of_group(group)), ends);
        const AnyExecutor alone;
        const ProgressCallback quiet;
        const BuildControl control(alone, quiet);
        BuiltGroup out;
        out.parts.resize(nodes.size());
        std::vector<H> hierarchies;
        std::vector<PageTree<H, P>> trees;
        hierarchies.reserve(nodes.size());
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            const std::size_t first = i == 0 ? 0 : ends[i - 1];
            const auto of_part = std::span<const P>(primitives).subspan(first, ends[i] - first);
            BuildBudget budget;
            budget.part = &tree.nodes()[nodes[i]].cell;
            // So that primitives in double precision have the origin that they have in the whole.
            budget.world = whole_world();
            const auto& b = build_.options.build;
            hierarchies.emplace_back(b.partition, b.approximation, b.cost_model,
                                     HierarchyBuilder<H, P, Sampler>(of_part, b.partition, b.approximation,
                                                                     b.cost_model, b.sampler, budget, control)
                                         .build_part(&out.parts[i].draft));
            trees.push_back({&hierarchies.back(), of_part});
        }
        PageForest<H, P> forest(trees, build_.plan.page_bytes, build_.plan.page_bytes);
        if (!forest.fits()) return {{}, {}, forest.needed_bytes()};
        const std::size_t page_bytes = build_.plan.page_bytes;
        out.pages.resize(forest.page_count() * page_bytes);
        for (std::uint32_t p = 0; p < forest.page_count(); ++p) {
            forest.fill(p, std::span(out.pages).subspan(p * page_bytes, page_bytes), p, build_.plan.facts.fingerprint);
        }
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            out.parts[i].root = forest.root_of(i);
            out.parts[i].stand_in = *hierarchies[i].root_stand_in();
            out.parts[i].report = hierarchies[i].report();
            out.parts[i].report.levels += hierarchies[i].root_cell().depth;
        }
        return out;
    }

  private:
    BoxD whole_world() const {
        BoxD world = BoxD::empty();
        if constexpr (has_double_bounds<P>) {
            const glm::dvec3 o = build_.plan.facts.origin;
            world = BoxD{o, o};
        }
        return world;
    }
    std::vector<P> sorted_by_part(const Tree& tree, std::span<const std::uint32_t> nodes, std::vector<P> mixed_up,
                                  std::vector<std::size_t>& ends) const {
        if (nodes.size() == 1) {
            ends = {mixed_up.size()};
            return mixed_up;
        }
        const std::uint32_t first_part = tree.nodes()[nodes[0]].part;
        std::vector<std::uint32_t> part_of;
        part_of.reserve(mixed_up.size());
        std::vector<std::size_t> next(nodes.size() + 1);
        for (const P& p : mixed_up) {
            const Item item{local_bounds(p, build_.plan.facts.origin), 0, 0};
            part_of.push_back(tree.nodes()[tree.node_of(build_.options.build.partition, item)].part - first_part);
            ++next[part_of.back() + std::size_t(1)];
        }
        for (std::size_t i = 1; i < next.size(); ++i) next[i] += next[i - 1];
        ends.assign(next.begin() + 1, next.end());
        std::vector<P> sorted(mixed_up.size());
        for (std::size_t i = 0; i < mixed_up.size(); ++i) sorted[next[part_of[i]]++] = mixed_up[i];
        return sorted;
    }

    const Build& build_;
};

}  // namespace detail

}  // namespace farfield
