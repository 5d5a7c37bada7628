// Cells of a partition that cuts, from one of them on down: the serial part of polygon_splitter.hpp.
#pragma once

#include "farfield/settings.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "farfield/build/build_node.hpp"
#include "farfield/composition.hpp"
#include "farfield/fail.hpp"
#include "farfield/geometry/cell_polygons.hpp"
#include "farfield/hierarchy/hierarchy_data.hpp"

namespace farfield::detail {

/// Cells below one cell, and what each keeps.
template <Partition Partition_>
class PolygonSubtree {
  public:
    using Draft = BuildNode<typename Partition_::node_data>;
    /// What there may be before no cell is split any more.
    struct Budget {
        static constexpr std::uint64_t unlimited = ~std::uint64_t(0);
        std::uint64_t pieces = unlimited;
        std::uint64_t bytes = 0;           ///< looked at between levels; 0: no limit
        std::uint64_t node = 0, item = 0;  ///< bytes of one
    };

    std::vector<Draft> drafts;                   ///< parents before children
    std::vector<ClippedItem> kept;               ///< a draft's items lie at [first, first + count)
    std::vector<Corner> corners;                 ///< some of which nobody needs any more
    std::vector<std::uint32_t> deferred_leaves;  ///< leaves so far, small enough to be split elsewhere
    std::size_t deferred_items = 0;              ///< in those leaves
    BuildReport report{};

    PolygonSubtree(const Partition_& partition, std::span<const SupportingPlane> planes)
        : partition_(&partition), planes_(planes) {}

    void start(const Cell& cell, std::vector<ClippedItem> items, std::vector<Corner> their_corners) {
        drafts.push_back({.cell = cell, .count = items.size()});
        items_ = std::move(items);
        corners = std::move(their_corners);
    }
    /// From a cell that another one put off.
    void start(const Draft& draft, const PolygonSubtree& from) {
        std::vector<ClippedItem> items(from.kept.begin() + std::ptrdiff_t(draft.first),
                                       from.kept.begin() + std::ptrdiff_t(draft.first + draft.count));
        std::vector<Corner> own;
        for (ClippedItem& item : items) {
            const auto begin = from.corners.begin() + item.first_corner;
            item.first_corner = std::uint32_t(own.size());
            own.insert(own.end(), begin, begin + item.corners);
        }
        start(draft.cell, std::move(items), std::move(own));
    }

    /// Cells of at most `small_count` items are put off.
    /// after_level(items in their last cell, all items) is called after each level.
    template <class AfterLevel>
    void grow(std::size_t small_count, const Budget& budget, AfterLevel&& after_level) {
        for (std::size_t begin = 0; begin < drafts.size();) {
            const std::size_t end = drafts.size();
            const bool is_spent =
                budget.bytes != 0 && end * budget.node + (kept.size() + items_.size()) * budget.item > budget.bytes;
            if (corners.size() > 0xf0000000u || kept.size() + items_.size() > 0xf0000000u || end > 0xf0000000u) {
                detail::fail<std::length_error>("farfield: the hierarchy would exceed 2^32 nodes, items or vertices");
            }
            next_.clear();
            for (std::size_t n = begin; n < end; ++n) {
                if (drafts[n].count > small_count) {
                    const std::size_t pieces = kept.size() + next_.size() + items_.size() - drafts[n].first;
                    divide(n, is_spent, pieces >= budget.pieces);
                } else {
                    deferred_leaves.push_back(std::uint32_t(n));
                    deferred_items += drafts[n].count;
                    keep(n);
                }
            }
            items_.swap(next_);
            begin = end;
            after_level(kept.size() - deferred_items, kept.size() + items_.size());
        }
        items_ = {};
        next_ = {};
    }

  private:
    void divide(std::size_t n, bool has_no_bytes, bool has_no_pieces) {
        const ClippedItems items({items_.data() + drafts[n].first, drafts[n].count}, corners, planes_);
        Draft& node = drafts[n];
        node.answer = items.size() == 0 ? Split::no : partition_->choose(node.cell, items, node.data);
        const bool would_split = node.answer == Split::yes || node.answer == Split::always;
        if (would_split && !has_no_bytes && !has_no_pieces) {
            cut(n, items);
            return;
        }
        report.cells_out_of_order += node.answer != Split::no;
        report.cells_over_memory_budget += would_split && has_no_bytes;
        report.cells_over_piece_budget += would_split && has_no_pieces;
        report.cells_at_depth_limit += node.answer == Split::too_deep;
        report.cells_that_cannot_be_told_apart += node.answer == Split::inseparable;
        keep(n);
    }

    void keep(std::size_t n) {
        Draft& node = drafts[n];
        const auto begin = items_.begin() + std::ptrdiff_t(node.first);
        kept.insert(kept.end(), begin, begin + std::ptrdiff_t(node.count));
        node.first = kept.size() - node.count;
        for (std::size_t i = node.first; i < kept.size(); ++i) node.cost += cost_of(kept[i]);
    }

    static float cost_of(const ClippedItem& item) {
        return item.corners == 0 ? item.cost : item.cost * float(item.corners - 2);
    }

    void cut(std::size_t n, const ClippedItems& items) {
        const Cell cell = drafts[n].cell;
        const Cuts cuts = partition_->cuts(cell, std::as_const(drafts[n].data));
        for (auto& list : lists_) list.clear();
        for (std::size_t i = 0; i < items.size(); ++i) {
            Sides sides{};
            hand_down(items[i], cell, cuts, 0, sides, drafts[n].data);
        }
        std::array<Box, 8> boxes;
        for (unsigned c = 0; c < 8; ++c) {
            boxes[c] = Box::empty();
            for (const ClippedItem& item : lists_[c]) boxes[c].add(item.bounds);
        }
        partition_->fit(cell, drafts[n].data, std::span<const Box>(boxes));
        const typename Partition_::node_data data = drafts[n].data;
        drafts[n].is_leaf = false;
        drafts[n].first_child = std::uint32_t(drafts.size());
        drafts[n].first = kept.size();
        drafts[n].count = 0;
        unsigned children = 0;
        for (unsigned c = 0; c < 8; ++c) {
            if (lists_[c].empty()) continue;
            ++children;
            drafts[n].child_mask = std::uint8_t(drafts[n].child_mask | 1u << c);
            drafts.push_back(
                {.cell = partition_->child(cell, data, c), .first = next_.size(), .count = lists_[c].size()});
            next_.insert(next_.end(), lists_[c].begin(), lists_[c].end());
        }
        report.empty_cells_pruned += cuts.children - children;
    }

    /// Past planes [plane, count).
    void hand_down(const ClippedItem& item, const Cell& cell, const Cuts& cuts, unsigned plane, Sides& sides,
                   const typename Partition_::node_data& data) {
        for (; plane < cuts.count; ++plane) {
            const LocalPlane local_plane(cuts.planes[plane], cell);
            const ClippedItems one({&item, 1}, corners, planes_);
            const PlaneRelation relation = one.relation(0, cuts.planes[plane], local_plane, cell);
            if (relation != PlaneRelation::crossing || item.corners == 0) {
                sides[plane] = relation == PlaneRelation::behind ? Side::behind
                               : relation == PlaneRelation::on   ? Side::on
                                                                 : Side::in_front;
                continue;
            }
            const ClippedItem behind = part_of(item, local_plane, Side::behind),
                              in_front = part_of(item, local_plane, Side::in_front);
            // Where rounding leaves no area on one side, all of it goes to the other.
            const bool on_one_side = behind.corners == 0 || in_front.corners == 0;
            const Sides before = sides;
            for (const Side side : {Side::behind, Side::in_front}) {
                const ClippedItem& part = side == Side::behind ? behind : in_front;
                if (on_one_side ? side != larger_side(item, local_plane) : part.corners == 0) continue;
                sides = before;
                sides[plane] = side;
                hand_down(on_one_side ? item : part, cell, cuts, plane + 1, sides, data);
            }
            return;
        }
        lists_[partition_->child_at(data, sides)].push_back(item);
    }

    ClippedItem part_of(const ClippedItem& item, const LocalPlane& plane, Side side) {
        ClippedItem part = item;
        part.first_corner = std::uint32_t(corners.size());
        scratch_.assign(corners.begin() + item.first_corner, corners.begin() + item.first_corner + item.corners);
        const glm::vec3 normal = planes_[item.polygon].normal;
        part.corners =
            append_part(scratch_, plane, side, normal, corners) ? std::uint32_t(corners.size() - part.first_corner) : 0;
        part.bounds = Box::empty();
        for (const Corner& c : std::span(corners).subspan(part.first_corner, part.corners)) {
            part.bounds.add(c.position);
        }
        return part;
    }

    Side larger_side(const ClippedItem& item, const LocalPlane& plane) const {
        double sum = 0;
        for (const Corner& c : std::span(corners).subspan(item.first_corner, item.corners)) {
            sum += plane.height(c.position);
        }
        return sum < 0 ? Side::behind : Side::in_front;
    }

    const Partition_* partition_;
    std::span<const SupportingPlane> planes_;
    std::vector<ClippedItem> items_, next_;  ///< of this level and the next
    std::array<std::vector<ClippedItem>, 8> lists_;
    std::vector<Corner> scratch_;
};

}  // namespace farfield::detail
