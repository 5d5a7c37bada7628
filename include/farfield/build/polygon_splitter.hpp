// The first phase of a build, the other form of cell_splitter.hpp, for partitions that cut: convex pieces of polygons
// go down, cut where they cross a plane. Large cells one after the other, level by level; then what is below each
// smaller one by itself, on any number of threads, put together in order.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "farfield/build/build_control.hpp"
#include "farfield/build/polygon_subtree.hpp"
#include "farfield/build/read_polygons.hpp"
#include "farfield/build/read_primitives.hpp"
#include "farfield/composition.hpp"
#include "farfield/fail.hpp"
#include "farfield/geometry/cell_polygons.hpp"
#include "farfield/hierarchy/hierarchy_data.hpp"

namespace farfield::detail {

/// Cells, parents before children, and the pieces that each keeps for its own run.
template <Partition Partition_, Approximation A, CostModel C, PrimitiveWithPolygons P>
class PolygonSplitter {
  public:
    using Branch = PolygonSubtree<Partition_>;
    using Draft = typename Branch::Draft;

    PolygonSplitter(std::span<const P> primitives, const Partition_& partition, const A&, const C& cost,
                    const BuildBudget& budget, const BuildControl& control, HierarchyData<Partition_, A>& data)
        : primitives_(primitives),
          partition_(partition),
          cost_(cost),
          budget_(budget),
          control_(control),
          data_(data) {}

    void split() {
        PolygonReader intake;
        take_polygons(intake);
        const std::vector<SupportingPlane> planes = std::move(intake.planes);
        Branch top(partition_, planes);
        const std::size_t polygons = intake.items.size();
        const std::uint64_t most_pieces =
            budget_.pieces_per_polygon == 0
                ? Branch::Budget::unlimited
                : budget_.free_pieces + polygons * std::uint64_t(budget_.pieces_per_polygon);
        const typename Branch::Budget budget{
            most_pieces, budget_.memory_bytes,
            sizeof(Node) + stored_size<typename Partition_::node_data> + stored_size<typename A::stand_in_data>,
            sizeof(std::uint32_t)};
        top.start(data_.facts.root, std::move(intake.items), std::move(intake.corners));
        // With a budget of memory all levels are compared with it, one by one. A single part is not put off either:
        // it would be silent until it ends.
        const bool puts_off = budget.bytes == 0 && polygons > small_branch;
        top.grow(puts_off ? small_branch : 0, budget,
                 [&](std::size_t done, std::size_t total) { control_.report(BuildPhase::splitting, done, total); });
        std::vector<Branch> below(top.deferred_leaves.size(), Branch(partition_, planes));
        grow_below(top, below, most_pieces, planes);
        put_together(std::move(top), below);
    }

    std::vector<Draft>& drafts() { return drafts_; }
    /// Appends what a cell keeps.
    void append_items(const Draft& node) {
        FragmentArrays& out = data_.fragments;
        for (std::size_t i = node.first; i < node.first + node.count; ++i) {
            const ClippedItem& item = kept_[i];
            for (const Corner& c : std::span(corners_).subspan(item.first_corner, item.corners)) {
                out.vertices.push_back(c.position);
                out.colors.push_back(c.color);
            }
            data_.order.push_back(item.source);
            out.first_vertex.push_back(std::uint32_t(out.vertices.size()));
        }
    }

  private:
    /// Large enough that the parts are few, small enough to lie in a cache.
    static constexpr std::size_t small_branch = 4096;

    void take_polygons(PolygonReader& intake) {
        std::vector<ClippedItem> instances;
        read_primitives(primitives_, cost_, data_.facts, [&](const Item& item) {
            const P& primitive = primitives_[item.source];
            if constexpr (PrimitiveWithInstance<P>) {
                if (primitive_traits<P>::visit_instance(primitive, [](const auto&) {})) {
                    instances.push_back({item.bounds, item.source, 0, 0, 0, item.cost});
                    intake.interrupt();
                    return;
                }
            }
            std::size_t triangles = 0;
            local_polygons(primitive, data_.facts.origin,
                           [&](const Polygon& polygon) { triangles += polygon.vertices.size() - 2; });
            local_polygons(primitive, data_.facts.origin, [&](const Polygon& polygon) {
                intake.add(polygon, item.source, item.cost / float(triangles));
            });
        });
        intake.items.insert(intake.items.begin(), instances.begin(), instances.end());
        data_.facts.report.polygons_joined = intake.joined;
        data_.facts.report.polygons_without_area = intake.without_area;
        data_.facts.root = partition_.root(data_.facts.bounds);
        data_.fragments.first_vertex.push_back(0);
    }

    /// Each part may have its share of the pieces that are left, so that all can be split at once. Those that it is too
    /// small for are then split again, one by one, with all that the others have left over.
    void grow_below(const Branch& top, std::vector<Branch>& below, std::uint64_t most_pieces,
                    std::span<const SupportingPlane> planes) {
        const auto leaf = [&](std::size_t i) -> const Draft& { return top.drafts[top.deferred_leaves[i]]; };
        const auto left = [&](std::uint64_t pieces) { return most_pieces > pieces ? most_pieces - pieces : 0; };
        const double share = double(left(top.kept.size())) / double(std::max<std::size_t>(top.deferred_items, 1));
        std::size_t done = top.kept.size() - top.deferred_items;
        std::uint64_t pieces = done;
        control_.run_in_slices(
            below.size(),
            [&](std::size_t i) {
                below[i].start(leaf(i), top);
                const double most = std::min((1 + share) * double(leaf(i).count), 0x1p62);
                below[i].grow(0, {.pieces = std::uint64_t(most)}, [](std::size_t, std::size_t) {});
            },
            [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) {
                    done += leaf(i).count;
                    pieces += below[i].kept.size();
                }
                control_.report(BuildPhase::splitting, done, top.kept.size());
            });
        for (std::size_t i = 0; i < below.size() && left(pieces) != 0; ++i) {
            if (below[i].report.cells_over_piece_budget == 0) continue;
            pieces -= below[i].kept.size();
            below[i] = Branch(partition_, planes);
            below[i].start(leaf(i), top);
            below[i].grow(0, {.pieces = left(pieces)}, [&, level = 0](std::size_t, std::size_t) mutable {
                if (++level % 16 == 0) control_.report(BuildPhase::splitting, done, top.kept.size());
            });
            pieces += below[i].kept.size();
        }
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
                detail::fail<std::length_error>("farfield: the hierarchy would exceed 2^32 nodes, items or vertices");
            }
            for (std::size_t n = 0; n < branch.drafts.size(); ++n) {
                Draft draft = branch.drafts[n];
                draft.first += first_item;
                // Its first draft is the one that was put off.
                if (draft.child_mask != 0) draft.first_child += std::uint32_t(first_draft) - 1;
                if (n == 0) {
                    drafts_[top.deferred_leaves[b]] = draft;
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
            data_.facts.report.levels = std::max<std::uint32_t>(data_.facts.report.levels, draft.cell.depth + 1u);
        }
    }

    void add_counts(const BuildReport& r) {
        data_.facts.report.empty_cells_pruned += r.empty_cells_pruned;
        data_.facts.report.cells_at_depth_limit += r.cells_at_depth_limit;
        data_.facts.report.cells_that_cannot_be_told_apart += r.cells_that_cannot_be_told_apart;
        data_.facts.report.cells_over_memory_budget += r.cells_over_memory_budget;
        data_.facts.report.cells_over_piece_budget += r.cells_over_piece_budget;
        data_.facts.report.cells_out_of_order += r.cells_out_of_order;
    }

    std::span<const P> primitives_;
    const Partition_& partition_;
    const C& cost_;
    BuildBudget budget_;
    const BuildControl& control_;
    HierarchyData<Partition_, A>& data_;

    std::vector<Draft> drafts_;
    std::vector<ClippedItem> kept_;
    std::vector<Corner> corners_;
};

}  // namespace farfield::detail
