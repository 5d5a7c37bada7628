// The first phase of a build, as cell_splitter.hpp is, for partitions that cut: convex pieces of polygons go down, cut
// where they cross a plane. Large cells one after the other, level by level; then what is below each smaller one by
// itself, on any number of threads, put together in order.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "farfield/clipped_branch.hpp"
#include "farfield/clipped_items.hpp"
#include "farfield/hierarchy_parts.hpp"
#include "farfield/policy.hpp"
#include "farfield/polygon_intake.hpp"
#include "farfield/scene_intake.hpp"

namespace farfield::detail {

/// Cells, parents before children, and the pieces that each keeps for its own run.
template <Partition Part, Approximation A, CostModel C, PrimitiveWithPolygons P, class Executor>
class CellClipper {
  public:
    using Branch = ClippedBranch<Part>;
    using Draft = typename Branch::Draft;

    CellClipper(std::span<const P> primitives, const Part& partition, const A&, const C& cost,
                const BuildOptions& options, const Executor& executor, HierarchyParts<Part, A>& parts)
        : primitives_(primitives),
          partition_(partition),
          cost_(cost),
          options_(options),
          executor_(executor),
          parts_(parts) {}

    void split() {
        PolygonIntake intake;
        take_polygons(intake);
        const std::vector<SupportingPlane> planes = std::move(intake.planes);
        Branch top(partition_, planes);
        top.start(parts_.root, std::move(intake.items), std::move(intake.corners));
        const typename Branch::Budget budget{
            options_.memory_budget_bytes,
            sizeof(Node) + stored_size<typename Part::node_data> + stored_size<typename A::cell_data>,
            sizeof(std::uint32_t)};
        // With a budget all levels are compared with it, one by one.
        top.grow(budget.limit != 0 ? 0 : small_branch, budget);
        std::vector<Branch> below(top.put_off.size(), Branch(partition_, planes));
        executor_(below.size(), [&](std::size_t i) {
            below[i].start(top.drafts[top.put_off[i]], top);
            below[i].grow(0, {});
        });
        put_together(std::move(top), below);
    }

    std::vector<Draft>& drafts() { return drafts_; }
    /// Appends what a cell keeps.
    void append_items(const Draft& node) {
        FragmentArrays& out = parts_.fragments;
        for (std::size_t i = node.first; i < node.first + node.count; ++i) {
            const ClippedItem& item = kept_[i];
            for (const Corner& c : std::span(corners_).subspan(item.first_corner, item.corners)) {
                out.vertices.push_back(c.position);
                out.colors.push_back(c.color);
            }
            parts_.order.push_back(item.source);
            out.first_vertex.push_back(std::uint32_t(out.vertices.size()));
        }
    }

  private:
    /// Large enough that the parts are few, small enough to lie in a cache.
    static constexpr std::size_t small_branch = 4096;

    void take_polygons(PolygonIntake& intake) {
        std::vector<ClippedItem> instances;
        take_scene(primitives_, cost_, parts_, [&](const Item& item) {
            const P& primitive = primitives_[item.source];
            if constexpr (PrimitiveWithInstance<P>) {
                if (primitive_traits<P>::visit_instance(primitive, [](const auto&) {})) {
                    instances.push_back({item.bounds, item.source, 0, 0, 0, item.cost});
                    intake.interrupt();
                    return;
                }
            }
            std::size_t triangles = 0;
            local_polygons(primitive, parts_.origin,
                           [&](const Polygon& polygon) { triangles += polygon.vertices.size() - 2; });
            local_polygons(primitive, parts_.origin, [&](const Polygon& polygon) {
                intake.add(polygon, item.source, item.cost / float(triangles));
            });
        });
        intake.items.insert(intake.items.begin(), instances.begin(), instances.end());
        parts_.report.polygons_joined = intake.joined;
        parts_.report.polygons_without_area = intake.without_area;
        parts_.root = partition_.root(parts_.bounds);
        parts_.fragments.first_vertex.push_back(0);
    }

    void put_together(Branch&& top, std::span<const Branch> below) {
        drafts_ = std::move(top.drafts);
        kept_ = std::move(top.kept);
        corners_ = std::move(top.corners);
        add_counts(top.report);
        for (std::size_t b = 0; b < below.size(); ++b) {
            const Branch& branch = below[b];
            const std::size_t first_draft = drafts_.size(), first_item = kept_.size(), first_corner = corners_.size();
            if (first_draft + branch.drafts.size() > 0xfffffff0u || first_item + branch.kept.size() > 0xfffffff0u ||
                first_corner + branch.corners.size() > 0xfffffff0u) {
                throw std::length_error("farfield: the hierarchy would exceed 2^32 nodes, items or vertices");
            }
            for (std::size_t n = 0; n < branch.drafts.size(); ++n) {
                Draft draft = branch.drafts[n];
                draft.first += first_item;
                // Its first draft is the one that was put off.
                if (draft.child_mask != 0) draft.first_child += std::uint32_t(first_draft) - 1;
                if (n == 0) {
                    drafts_[top.put_off[b]] = draft;
                } else {
                    drafts_.push_back(draft);
                }
            }
            for (ClippedItem item : branch.kept) {
                item.first_corner += std::uint32_t(first_corner);
                kept_.push_back(item);
            }
            corners_.insert(corners_.end(), branch.corners.begin(), branch.corners.end());
            add_counts(branch.report);
        }
        for (const Draft& draft : drafts_) {
            parts_.report.levels = std::max<std::uint32_t>(parts_.report.levels, draft.cell.depth + 1u);
        }
    }

    void add_counts(const BuildReport& r) {
        parts_.report.empty_cells_pruned += r.empty_cells_pruned;
        parts_.report.cells_at_depth_limit += r.cells_at_depth_limit;
        parts_.report.cells_that_cannot_be_told_apart += r.cells_that_cannot_be_told_apart;
        parts_.report.cells_over_memory_budget += r.cells_over_memory_budget;
        parts_.report.cells_out_of_order += r.cells_out_of_order;
    }

    std::span<const P> primitives_;
    const Part& partition_;
    const C& cost_;
    const BuildOptions& options_;
    const Executor& executor_;
    HierarchyParts<Part, A>& parts_;

    std::vector<Draft> drafts_;
    std::vector<ClippedItem> kept_;
    std::vector<Corner> corners_;
};

}  // namespace farfield::detail
