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

    PolygonSplitter(PrimitiveSpan<P> primitives, const Partition_& partition, const A& approximation, const C& cost,
                    const BuildBudget& budget, const BuildControl& control, HierarchyData<Partition_, A>& data)
        : primitives_(primitives),
          partition_(partition),
          cost_(cost),
          least_cost_(Partition_::facts.splits_for_order ? -1.0f : least_cost_to_split(approximation, cost, 2)),
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
            sizeof(std::uint32_t), least_cost_};
        // With a budget of memory all cells are compared with it, one by one. A single part is not put off either: it
        // would be silent until it ends.
        const bool puts_off = budget.bytes == 0 && polygons > small_branch;
        top.grow(data_.facts.root, {std::move(intake.items), std::move(intake.corners)}, puts_off ? small_branch : 0,
                 budget,
                 [&](std::size_t done, std::size_t total) { control_.report(BuildPhase::splitting, done, total); });
        std::vector<Branch> below(top.deferred.size(), Branch(partition_, planes));
        grow_below(top, below, most_pieces, planes);
        put_together(std::move(top), below);
    }

    std::vector<Draft>& drafts() { return drafts_; }
    /// What cells keep lies in the order of a descent already.
    void append_items(const Draft&) {}

  private:
    /// Large enough that the parts are few, small enough to lie in a cache.
    static constexpr std::size_t small_branch = 4096;

    void take_polygons(PolygonReader& intake) {
        std::vector<ClippedItem> instances;
        intake.reserve(primitives_.size());
        read_primitives(primitives_, cost_, budget_.world, data_.facts, [&](const Item& item) {
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
        data_.facts.report.polygons = intake.items.size() - instances.size();
        data_.facts.report.polygons_joined = intake.joined;
        data_.facts.report.polygons_without_area = intake.without_area;
        data_.facts.root = partition_.root(bounds_of_root(data_.facts, budget_.world));
    }

    /// Each part may have its share of the pieces that are left, so that all can be split at once. Those that it is too
    /// small for are then split again, one by one, with all that the others have left over.
    void grow_below(const Branch& top, std::vector<Branch>& below, std::uint64_t most_pieces,
                    std::span<const SupportingPlane> planes) {
        const auto leaf = [&](std::size_t i) -> const Draft& { return top.drafts[top.deferred[i].draft]; };
        const auto left = [&](std::uint64_t pieces) { return most_pieces > pieces ? most_pieces - pieces : 0; };
        const std::size_t all = top.kept.size() + top.deferred_items;
        const double share = double(left(all)) / double(std::max<std::size_t>(top.deferred_items, 1));
        std::size_t done = top.kept.size();
        std::uint64_t pieces = done;
        control_.run_in_slices(
            below.size(),
            [&](std::size_t i) {
                const double most = std::min((1 + share) * double(leaf(i).count), 0x1p62);
                below[i].grow(leaf(i).cell, top.deferred[i].contents, 0,
                              {.pieces = std::uint64_t(most), .least_cost = least_cost_},
                              [](std::size_t, std::size_t) {});
            },
            [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) {
                    done += leaf(i).count;
                    pieces += below[i].kept.size();
                }
                control_.report(BuildPhase::splitting, done, all);
            });
        for (std::size_t i = 0; i < below.size() && left(pieces) != 0; ++i) {
            if (below[i].report.cells_over_piece_budget == 0) continue;
            pieces -= below[i].kept.size();
            below[i] = Branch(partition_, planes);
            below[i].grow(leaf(i).cell, top.deferred[i].contents, 0,
                          {.pieces = left(pieces), .least_cost = least_cost_},
                          [&](std::size_t, std::size_t) { control_.report(BuildPhase::splitting, done, all); });
            pieces += below[i].kept.size();
        }
    }

    /// Drafts of the parts behind those of the top; pieces in the order of a descent.
    void put_together(Branch&& top, std::span<const Branch> below) {
        std::size_t drafts = top.drafts.size(), items = top.kept.size(), vertices = top.fragments.vertices.size();
        for (const Branch& branch : below) {
            drafts += branch.drafts.size();
            items += branch.kept.size();
            vertices += branch.fragments.vertices.size();
        }
        if (drafts > 0xfffffff0u || items > 0xfffffff0u || vertices > 0xfffffff0u) {
            detail::fail<std::length_error>("farfield: the hierarchy would exceed 2^32 nodes, items or vertices");
        }
        drafts_ = std::move(top.drafts);
        drafts_.reserve(drafts);
        data_.order.reserve(items);
        data_.fragments.first_vertex.reserve(items + 1);
        data_.fragments.first_vertex.push_back(0);
        data_.fragments.vertices.reserve(vertices);
        data_.fragments.colors.reserve(vertices);
        // The top kept its pieces and put off its parts in the order of a descent, too.
        std::size_t top_kept = 0;
        for (std::size_t b = 0; b < below.size(); ++b) {
            const std::uint32_t place = top.deferred[b].draft;
            append_pieces(top, top_kept, top.deferred[b].kept_before);
            top_kept = top.deferred[b].kept_before;
            const Branch& branch = below[b];
            // Its first draft is the one that was put off.
            const auto before = std::uint32_t(drafts_.size() - 1);
            for (std::size_t n = 0; n < branch.drafts.size(); ++n) {
                Draft& draft = n == 0 ? drafts_[place] : drafts_.emplace_back();
                draft = branch.drafts[n];
                if (draft.child_mask != 0) draft.first_child += before;
            }
            append_pieces(branch, 0, branch.kept.size());
            add_counts(branch.report);
        }
        append_pieces(top, top_kept, top.kept.size());
        add_counts(top.report);
        for (const Draft& draft : drafts_) {
            data_.facts.report.levels = std::max<std::uint32_t>(data_.facts.report.levels, draft.cell.depth + 1u);
        }
    }

    void append_pieces(const Branch& from, std::size_t begin, std::size_t end) {
        FragmentArrays& out = data_.fragments;
        const std::uint32_t first = from.fragments.first_vertex[begin], last = from.fragments.first_vertex[end];
        const auto moved = std::uint32_t(out.vertices.size()) - first;  // modulo 2^32
        const auto append = [](auto& to, const auto& array, std::size_t b, std::size_t e) {
            to.insert(to.end(), array.begin() + std::ptrdiff_t(b), array.begin() + std::ptrdiff_t(e));
        };
        append(data_.order, from.kept, begin, end);
        append(out.vertices, from.fragments.vertices, first, last);
        append(out.colors, from.fragments.colors, first, last);
        for (std::size_t i = begin; i < end; ++i) {
            out.first_vertex.push_back(from.fragments.first_vertex[i + 1] + moved);
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

    PrimitiveSpan<P> primitives_;
    const Partition_& partition_;
    const C& cost_;
    float least_cost_;
    BuildBudget budget_;
    const BuildControl& control_;
    HierarchyData<Partition_, A>& data_;

    std::vector<Draft> drafts_;
};

}  // namespace farfield::detail
