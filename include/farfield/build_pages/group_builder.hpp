// Parts of a scene that lie side by side are built in memory, each as it would be in the whole, and cut into pages that
// they share.
#pragma once

#include "farfield/settings.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "farfield/build.hpp"
#include "farfield/build/build_control.hpp"
#include "farfield/build/hierarchy_builder.hpp"
#include "farfield/build_pages/file_in_place.hpp"
#include "farfield/build_pages/page_build.hpp"
#include "farfield/build_pages/page_share.hpp"
#include "farfield/build_pages/spare_buffers.hpp"
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
    /// `scattered`: the primitives of the share, part after part.
    GroupBuilder(const Build& build, FileInPlace& scattered) : build_(build), scattered_(scattered) {}

    struct BuiltGroup {
        std::vector<std::byte> pages;
        std::vector<Part> parts;
        std::uint64_t needed_bytes = 0;  ///< 0, or there are no pages, which were too small
    };
    /// `first_item`: where the group begins among the primitives of the share.
    BuiltGroup operator()(const Tree& tree, std::size_t group, std::uint64_t first_item) {
        const std::span<const std::uint32_t> nodes = tree.group(group);
        std::vector<P> buffer = primitives_.take();
        const auto count = std::size_t(tree.items_of_group(group));
        if (buffer.size() < count) buffer.resize(count);
        const std::span<P> primitives = std::span(buffer).first(count);
        scattered_.read_at(first_item * sizeof(P), std::as_writable_bytes(primitives));
        const AnyExecutor alone;
        const ProgressCallback quiet;
        const BuildControl control(alone, quiet);
        BuiltGroup out;
        out.parts.resize(nodes.size());
        std::vector<H> hierarchies;
        std::vector<PageTree<H, P>> trees;
        hierarchies.reserve(nodes.size());
        std::size_t begin = 0;
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            const auto of_part =
                std::span<const P>(primitives).subspan(begin, std::size_t(tree.nodes()[nodes[i]].items));
            begin += of_part.size();
            BuildBudget budget;
            budget.part = &tree.nodes()[nodes[i]].cell;
            budget.origin_of_part = build_.plan.facts.origin;
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
        out.pages = pages_.take();
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
        primitives_.give_back(std::move(buffer));
        return out;
    }
    /// The pages of a group have been written.
    void give_back(BuiltGroup& group) { pages_.give_back(std::move(group.pages)); }

  private:
    const Build& build_;
    FileInPlace& scattered_;
    SpareBuffers<P> primitives_;
    SpareBuffers<std::byte> pages_;
};

}  // namespace detail

}  // namespace farfield
