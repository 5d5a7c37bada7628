// A partition of your own: a kd-tree whose planes lie where the primitives are, half of them on either side.
//
// J. L. Bentley, "Multidimensional Binary Search Trees Used for Associative Searching", Communications of the ACM
// 18(9), 1975. His is over points; a primitive that crosses the plane goes to both sides here, so cells hold nothing
// that sticks out and come in exact order from any viewpoint.
#pragma once

#include <algorithm>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <vector>

#include "farfield/policy.hpp"

struct MedianSplit {
    // ---- Options: any number of public members with defaults, or none.

    std::uint16_t max_depth = 40;
    /// Cells with fewer primitives are left alone.
    std::uint32_t least_items = 4;

    // ---- Required by farfield::Partition.

    /// Kept for every node: where its plane lies. Trivially copyable; an empty struct takes no memory.
    struct node_data {
        float position;
        std::uint32_t axis;
    };

    static constexpr farfield::PartitionFacts facts{
        .offers = farfield::shared, .ordering = farfield::Ordering::cells, .file_tag = 0x6d730001u};

    /// The cell around everything. `bounds_center` and `bounds_half` are what is culled: as large, as nothing sticks
    /// out.
    farfield::Cell root(const farfield::Box& bounds) const {
        return bounds.is_empty() ? farfield::Cell{} : cell_of(bounds, 0);
    }

    /// Whether and where to split. Items are all that the cell has; the answer must not depend on their order.
    farfield::Split choose(const farfield::Cell& cell, std::span<const farfield::Item> items, node_data& data) const {
        if (items.size() < least_items) return farfield::Split::no;
        if (cell.depth >= max_depth) return farfield::Split::too_deep;
        data = median_plane(cell, items);
        return makes_progress(cell, items, data) ? farfield::Split::yes : farfield::Split::no;
    }

    /// To which children an item goes; emit.keep() would leave it with the node itself.
    template <class Touches, class Emit>
    void place(const farfield::Cell& cell, const node_data& data, const farfield::Item& item, Touches&& touches,
               Emit&& emit) const {
        const bool lower = goes_lower(item, data), upper = goes_upper(item, data);
        // Asking the primitive is dear, and needed only where its box crosses the plane.
        const bool crosses = lower && upper;
        const bool in_lower = lower && (!crosses || touches(child(cell, data, 0).box()));
        const bool in_upper = upper && (!crosses || touches(child(cell, data, 1).box()));
        // Rounding must not lose a primitive.
        if (in_lower || !in_upper) emit(0);
        if (in_upper) emit(1);
    }

    /// Computed anew in every descent, so cells are never stored.
    farfield::Cell child(const farfield::Cell& parent, const node_data& data, unsigned i) const {
        farfield::Box box = parent.box();
        (i == 0 ? box.upper : box.lower)[int(data.axis)] = data.position;
        return cell_of(box, std::uint16_t(parent.depth + 1));
    }

    /// All children, present or not. The viewpoint is a point where w is 1, a direction to the viewer where it is 0.
    void front_to_back(const farfield::Cell&, const node_data& data, glm::vec4 viewpoint,
                       farfield::ChildOrder& order) const {
        const bool upper_first = viewpoint[int(data.axis)] > data.position * viewpoint.w;
        order[0] = upper_first ? 1 : 0;
        order[1] = upper_first ? 0 : 1;
    }

    // ---- Helpers, nobody's business.

  private:
    static farfield::Cell cell_of(const farfield::Box& box, std::uint16_t depth) {
        const glm::vec3 center = box.center(), half = 0.5f * box.size();
        return {center, half, center, half, depth, 0};
    }

    static bool goes_lower(const farfield::Item& item, const node_data& data) {
        return item.bounds.lower[int(data.axis)] <= data.position;
    }
    static bool goes_upper(const farfield::Item& item, const node_data& data) {
        return item.bounds.upper[int(data.axis)] > data.position;
    }

    /// Across the cell's longest side.
    static node_data median_plane(const farfield::Cell& cell, std::span<const farfield::Item> items) {
        node_data data{0, 0};
        for (std::uint32_t axis = 1; axis < 3; ++axis) {
            if (cell.half[int(axis)] > cell.half[int(data.axis)]) data.axis = axis;
        }
        std::vector<float> centers;
        centers.reserve(items.size());
        for (const farfield::Item& item : items) centers.push_back(item.bounds.center()[int(data.axis)]);
        const auto middle = centers.begin() + std::ptrdiff_t(centers.size() / 2);
        std::nth_element(centers.begin(), middle, centers.end());
        // Centers of what reaches in from next door may lie outside.
        const farfield::Box box = cell.box();
        data.position = glm::clamp(*middle, box.lower[int(data.axis)], box.upper[int(data.axis)]);
        return data;
    }

    /// Where nearly all cross the plane, halving goes on for ever and stores everything twice each time.
    static bool makes_progress(const farfield::Cell& cell, std::span<const farfield::Item> items,
                               const node_data& data) {
        const farfield::Box box = cell.box();
        const int axis = int(data.axis);
        if (!(box.lower[axis] < data.position && data.position < box.upper[axis])) return false;
        const auto both = std::count_if(items.begin(), items.end(), [&](const farfield::Item& item) {
            return goes_lower(item, data) && goes_upper(item, data);
        });
        return std::size_t(both) * 2 < items.size();
    }
};

static_assert(farfield::Partition<MedianSplit>);
