// What lies above the parts of a scene: cells whose stand-ins are made of those of their children, last of all, and the
// pages that hold them, which come first in the file.
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

#include "farfield/approximation.hpp"
#include "farfield/build/build_node.hpp"
#include "farfield/build/painted_contents.hpp"
#include "farfield/build_pages/file_in_place.hpp"
#include "farfield/build_pages/page_build.hpp"
#include "farfield/build_pages/page_share.hpp"
#include "farfield/build_pages/top_tree.hpp"
#include "farfield/composition.hpp"
#include "farfield/hierarchy/node.hpp"
#include "farfield/paging/page_forest.hpp"

namespace farfield {
namespace detail {

template <class Build>
class TopPages {
    using H = typename Build::hierarchy_type;
    using P = typename Build::primitive_type;
    using Sampler = typename Build::sampler_type;
    using Data = typename H::Data;
    using Partition_ = typename H::partition_type;
    using A = typename H::approximation_type;
    using Tree = TopTree<Partition_>;
    using Part = BuiltPart<A>;

  public:
    explicit TopPages(Build& build) : build_(build) {}

    /// To see how many pages it takes.
    PageForest<H, P> forest(const Tree& tree, std::span<const P> own_items) const {
        const H h = hierarchy_of(top_data(tree));
        const std::vector<UnitElsewhere> elsewhere(tree.nodes().size());
        return PageForest<H, P>({{&h, own_items, elsewhere}}, build_.plan.page_bytes, build_.plan.page_bytes);
    }

    /// Writes the first pages and returns where the root is.
    UnitElsewhere write(const Tree& tree, std::span<const Part> parts, std::span<const P> own_items, FileInPlace& out) {
        Data data = top_data(tree);
        std::vector<UnitElsewhere> elsewhere(tree.nodes().size());
        std::vector<typename A::stand_in_draft> drafts(tree.nodes().size());
        Sampler sampler = build_.options.build.sampler;
        const A& approximation = build_.options.build.approximation;
        for (std::size_t n = tree.nodes().size(); n-- > 0;) {
            const TopNode& node = tree.nodes()[n];
            if (node.child_mask == 0) {
                const Part& part = parts[node.part];
                drafts[n] = part.draft;
                data.stand_ins[n] = part.stand_in;
                elsewhere[n] = part.root;
                data.nodes[n].stand_in_levels_below = part.root.node.stand_in_levels_below;
                data.nodes[n].levels_replaced = part.root.node.levels_replaced;
                continue;
            }
            if (node.own_items != 0) {
                const auto own = own_items.subspan(node.own_begin, std::size_t(node.own_items));
                const auto contents = [&](auto&& sink) {
                    for (const P& p : own) local_polygons(p, build_.plan.facts.origin, sink);
                };
                drafts[n] = with_painted(sampler, node.cell, contents, [&](const auto& painted) {
                    return approximation.sample(node.cell, painted, sampler);
                });
            }
            std::array<ChildDraft<typename A::stand_in_draft>, 8> children;
            unsigned count = 0;
            for (unsigned mask = node.child_mask; mask != 0; mask &= mask - 1, ++count) {
                const std::uint32_t at = node.first_child + count;
                children[count] = {unsigned(std::countr_zero(mask)), &tree.nodes()[at].cell, &drafts[at]};
            }
            approximation.merge(node.cell, drafts[n], {children.data(), count});
            std::vector<typename H::pool_element> no_pool;
            data.stand_ins[n] = finished_stand_in(approximation, node.cell, drafts[n], no_pool);
            mark_levels_below(data.nodes[n], std::span<const Node>(data.nodes).subspan(node.first_child), true);
        }
        count_top(tree);
        const H h = hierarchy_of(std::move(data));
        PageForest<H, P> forest({{&h, own_items, elsewhere}}, build_.plan.page_bytes, build_.plan.page_bytes);
        std::uint32_t number = 0;
        forest.write(build_.plan.facts.fingerprint,
                     [&](std::span<const std::byte> page) { out.write_at(build_.offset_of(number++), page); });
        return forest.root_of(0);
    }

  private:
    /// As a hierarchy, with stand-ins that are not made yet and parts as leaves.
    Data top_data(const Tree& tree) const {
        Data data;
        data.facts = build_.plan.facts;
        data.facts.report.items = tree.own_items();
        data.facts.primitive_count = tree.own_items();
        data.facts.root_has_stand_in = 1;
        for (const TopNode& n : tree.nodes()) {
            Node node;
            node.first_child = n.child_mask != 0 ? n.first_child : 0;
            node.first_item = n.own_begin;
            node.first_child_data = node.first_child;  // every node has a stand-in
            node.child_mask = node.stand_in_mask = n.child_mask;
            data.nodes.push_back(node);
        }
        data.stand_ins.resize(data.nodes.size());
        return data;
    }
    H hierarchy_of(Data data) const {
        return H(build_.options.build.partition, build_.options.build.approximation, build_.options.build.cost_model,
                 std::move(data));
    }
    void count_top(const Tree& tree) {
        const auto above = std::uint32_t(tree.nodes().size() - tree.parts().size());
        build_.plan.facts.report.nodes += above;
        build_.plan.facts.report.stand_ins += above;
    }

    Build& build_;
};

}  // namespace detail

}  // namespace farfield
