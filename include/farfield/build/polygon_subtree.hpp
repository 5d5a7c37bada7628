// Cells of a partition that cuts, from one of them on down: the serial part of polygon_splitter.hpp. Depth first, so
// that what is worked on lies in a cache, and what a cell keeps comes in the order of a descent.
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
        std::uint64_t bytes = 0;           ///< 0: no limit
        std::uint64_t node = 0, item = 0;  ///< bytes of one
        float least_cost = -1;             ///< what a cell must cost more than to be split; not where order asks for it
    };
    /// Polygons and instances, with the corners that they refer to.
    struct Contents {
        std::vector<ClippedItem> items{};
        std::vector<Corner> corners{};
    };
    /// A leaf so far, small enough to be split elsewhere.
    struct Deferred {
        std::uint32_t draft;
        std::size_t kept_before;  ///< pieces that come before it
        Contents contents;
    };

    std::vector<Draft> drafts;        ///< parents before children
    std::vector<std::uint32_t> kept;  ///< primitives; a draft's pieces lie at [first, first + count)
    FragmentArrays fragments{{0}, {}, {}};
    std::vector<Deferred> deferred;
    std::size_t deferred_items = 0;
    BuildReport report{};

    PolygonSubtree(const Partition_& partition, std::span<const SupportingPlane> planes)
        : partition_(&partition), planes_(planes) {}

    /// after_step(items in their last cell, all items) is called after every few thousand items that were handed down.
    /// Cells of at most `small_count` items are put off.
    template <class AfterStep>
    void grow(const Cell& cell, Contents contents, std::size_t small_count, const Budget& budget,
              AfterStep&& after_step) {
        items_ = std::move(contents.items);
        corners_ = std::move(contents.corners);
        drafts.push_back({.cell = cell, .count = items_.size()});
        open_.push_back({0, corners_.size()});
        for (std::size_t handed_down = 0; !open_.empty();) {
            const auto [n, corners] = open_.back();
            open_.pop_back();
            // Those that cells before it have made are not needed any more.
            corners_.resize(corners);
            const std::size_t pieces = kept.size() + deferred_items + items_.size();
            if (corners > 0xf0000000u || fragments.vertices.size() > 0xf0000000u || pieces > 0xf0000000u ||
                drafts.size() > 0xf0000000u) {
                detail::fail<std::length_error>("farfield: the hierarchy would exceed 2^32 nodes, items or vertices");
            }
            handed_down += drafts[n].count;
            if (drafts[n].count > small_count) {
                const bool is_spent =
                    budget.bytes != 0 && drafts.size() * budget.node + pieces * budget.item > budget.bytes;
                divide(n, is_spent, pieces >= budget.pieces, budget.least_cost);
            } else {
                put_off(n);
            }
            if (handed_down < items_a_step && !open_.empty()) continue;
            handed_down = 0;
            after_step(kept.size(), kept.size() + deferred_items + items_.size());
        }
        items_ = {};
        corners_ = {};
        lists_ = {};
    }

  private:
    static constexpr std::size_t items_a_step = std::size_t(1) << 14;

    void divide(std::uint32_t n, bool has_no_bytes, bool has_no_pieces, float least_cost) {
        const ClippedItems items(items_of(n), corners_, planes_);
        Draft& node = drafts[n];
        node.answer = items.size() == 0 ? Split::no : partition_->choose(node.cell, items, node.data);
        if (node.answer == Split::yes && !(cost_of(items_of(n)) > least_cost)) node.answer = Split::no;
        const bool would_split = node.answer == Split::yes || node.answer == Split::always;
        if (would_split && !has_no_bytes && !has_no_pieces) {
            cut(n);
            return;
        }
        if (Partition_::facts.splits_for_order) report.cells_out_of_order += node.answer != Split::no;
        report.cells_over_memory_budget += would_split && has_no_bytes;
        report.cells_over_piece_budget += would_split && has_no_pieces;
        report.cells_at_depth_limit += node.answer == Split::too_deep;
        report.cells_that_cannot_be_told_apart += node.answer == Split::inseparable;
        keep(n);
    }

    /// They are the last ones.
    std::span<const ClippedItem> items_of(std::uint32_t n) const {
        return {items_.data() + drafts[n].first, drafts[n].count};
    }
    std::span<const Corner> polygon(const ClippedItem& item) const {
        return std::span(corners_).subspan(item.first_corner, item.corners);
    }

    static float cost_of(std::span<const ClippedItem> items) {
        float sum = 0;
        for (const ClippedItem& i : items) sum += i.corners == 0 ? i.cost : i.cost * float(i.corners - 2);
        return sum;
    }

    void keep(std::uint32_t n) {
        Draft& node = drafts[n];
        for (const ClippedItem& item : items_of(n)) {
            kept.push_back(item.source);
            for (const Corner& c : polygon(item)) {
                fragments.vertices.push_back(c.position);
                fragments.colors.push_back(c.color);
            }
            fragments.first_vertex.push_back(std::uint32_t(fragments.vertices.size()));
        }
        node.cost = cost_of(items_of(n));
        items_.resize(node.first);
        node.first = kept.size() - node.count;
    }

    void put_off(std::uint32_t n) {
        Contents contents;
        contents.items.assign(items_of(n).begin(), items_of(n).end());
        for (ClippedItem& item : contents.items) {
            const std::span<const Corner> own = polygon(item);
            item.first_corner = std::uint32_t(contents.corners.size());
            contents.corners.insert(contents.corners.end(), own.begin(), own.end());
        }
        items_.resize(drafts[n].first);
        deferred_items += drafts[n].count;
        deferred.push_back({n, kept.size(), std::move(contents)});
    }

    void cut(std::uint32_t n) {
        const Cell cell = drafts[n].cell;
        const Cuts cuts = partition_->cuts(cell, std::as_const(drafts[n].data));
        const LocalPlanes local{LocalPlane(cuts.planes[0], cell), LocalPlane(cuts.planes[1], cell),
                                LocalPlane(cuts.planes[2], cell)};
        for (auto& list : lists_) list.clear();
        for (const ClippedItem& item : items_of(n)) hand_down(item, {cell, cuts, local, drafts[n].data}, 0, {});
        std::array<Box, 8> boxes;
        boxes.fill(Box::empty());
        for (unsigned c = 0; c < cuts.children; ++c) {
            for (const ClippedItem& item : lists_[c]) boxes[c].add(item.bounds);
        }
        partition_->fit(cell, drafts[n].data, std::span<const Box>(boxes));
        const typename Partition_::node_data data = drafts[n].data;
        // The last child's items come first, for the first child's are wanted next.
        items_.resize(drafts[n].first);
        std::array<std::size_t, 8> first{};
        for (unsigned c = cuts.children; c-- > 0;) {
            first[c] = items_.size();
            items_.insert(items_.end(), lists_[c].begin(), lists_[c].end());
        }
        drafts[n].is_leaf = false;
        drafts[n].first_child = std::uint32_t(drafts.size());
        drafts[n].first = kept.size();
        drafts[n].count = 0;
        for (unsigned c = 0; c < cuts.children; ++c) {
            if (lists_[c].empty()) continue;
            drafts[n].child_mask = std::uint8_t(drafts[n].child_mask | 1u << c);
            drafts.push_back({.cell = partition_->child(cell, data, c), .first = first[c], .count = lists_[c].size()});
        }
        const auto children = std::uint32_t(drafts.size() - drafts[n].first_child);
        for (std::uint32_t c = children; c-- > 0;) open_.push_back({drafts[n].first_child + c, corners_.size()});
        report.empty_cells_pruned += cuts.children - children;
    }

    using LocalPlanes = std::array<LocalPlane, 3>;
    struct Cutting {
        const Cell& cell;
        const Cuts& cuts;
        const LocalPlanes& local;
        const typename Partition_::node_data& data;
    };

    /// Past planes [plane, count).
    void hand_down(const ClippedItem& item, const Cutting& by, unsigned plane, Sides sides) {
        for (; plane < by.cuts.count; ++plane) {
            const LocalPlane& local_plane = by.local[plane];
            const PlaneRelation relation =
                relation_of(item, polygon(item), planes_, by.cuts.planes[plane], local_plane, by.cell);
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
            for (const Side side : {Side::behind, Side::in_front}) {
                const ClippedItem& part = side == Side::behind ? behind : in_front;
                if (on_one_side ? side != larger_side(item, local_plane) : part.corners == 0) continue;
                sides[plane] = side;
                hand_down(on_one_side ? item : part, by, plane + 1, sides);
            }
            return;
        }
        lists_[partition_->child_at(by.data, sides)].push_back(item);
    }

    ClippedItem part_of(const ClippedItem& item, const LocalPlane& plane, Side side) {
        ClippedItem part = item;
        part.first_corner = std::uint32_t(corners_.size());
        scratch_.assign(polygon(item).begin(), polygon(item).end());
        const glm::vec3 normal = planes_[item.polygon].normal;
        part.corners = append_part(scratch_, plane, side, normal, corners_)
                           ? std::uint32_t(corners_.size() - part.first_corner)
                           : 0;
        part.bounds = Box::empty();
        for (const Corner& c : polygon(part)) part.bounds.add(c.position);
        return part;
    }

    Side larger_side(const ClippedItem& item, const LocalPlane& plane) const {
        double sum = 0;
        for (const Corner& c : polygon(item)) sum += plane.height(c.position);
        return sum < 0 ? Side::behind : Side::in_front;
    }

    /// A draft that is still to be divided, and how many corners it needs.
    struct Open {
        std::uint32_t draft;
        std::size_t corners;
    };

    const Partition_* partition_;
    std::span<const SupportingPlane> planes_;
    std::vector<Open> open_;
    std::vector<ClippedItem> items_;  ///< of open drafts, the next one's last
    std::vector<Corner> corners_;
    std::array<std::vector<ClippedItem>, 8> lists_;
    std::vector<Corner> scratch_;
};

}  // namespace farfield::detail
