// A partition of your own: a kd-tree whose planes lie where the primitives are, half of them on either side (Bentley,
// Communications of the ACM 18(9), 1975). A primitive that crosses a plane goes to both sides, so cells hold nothing
// that sticks out and come in exact order from any viewpoint.
#pragma once

#include <algorithm>
#include <cstdint>
#include <glm/vec4.hpp>
#include <span>
#include <vector>

#include "farfield/partition.hpp"

struct MedianSplit {
    std::uint16_t max_depth = 40;  ///< options are public members with defaults
    static constexpr farfield::PartitionFacts facts{
        .offers = farfield::Assignment::shared, .ordering = farfield::OrderGuarantee::cells, .file_tag = 0x6d730001u};
    struct node_data {  ///< what is kept for every node: where its plane lies
        float position;
        std::uint32_t axis;
    };
    farfield::Cell root(const farfield::Box& bounds) const {
        return bounds.is_empty() ? farfield::Cell{} : cell_of(bounds, 0);
    }
    /// Whether and where to split: at the median of the centers, across the cell's longest side.
    farfield::Split choose(const farfield::Cell& cell, std::span<const farfield::Item> items, node_data& data) const {
        if (cell.depth >= max_depth) return farfield::Split::too_deep;
        data.axis = cell.half.x >= std::max(cell.half.y, cell.half.z) ? 0 : cell.half.y >= cell.half.z ? 1 : 2;
        const int axis = int(data.axis);
        std::vector<float> centers;
        for (const farfield::Item& item : items) centers.push_back(item.bounds.center()[axis]);
        const auto middle = centers.begin() + std::ptrdiff_t(centers.size() / 2);
        std::nth_element(centers.begin(), middle, centers.end());
        data.position = *middle;
        const farfield::Box box = cell.box();
        const bool divides = box.lower[axis] < *middle && *middle < box.upper[axis];
        return divides ? farfield::Split::yes : farfield::Split::no;
    }
    template <class Touches, class Emit>
    void place(const farfield::Cell&, const node_data& data, const farfield::Item& item, Touches&&, Emit&& emit) const {
        if (item.bounds.lower[int(data.axis)] <= data.position) emit(0);
        if (item.bounds.upper[int(data.axis)] > data.position) emit(1);
    }
    farfield::Cell child(const farfield::Cell& parent, const node_data& data, unsigned i) const {
        farfield::Box box = parent.box();
        (i == 0 ? box.upper : box.lower)[int(data.axis)] = data.position;
        return cell_of(box, parent.depth + 1u);
    }
    void front_to_back(const farfield::Cell&, const node_data& data, glm::vec4 viewpoint,
                       farfield::ChildOrder& order) const {
        order[0] = viewpoint[int(data.axis)] > data.position * viewpoint.w ? 1 : 0;
        order[1] = std::uint8_t(1 - order[0]);
    }
    static farfield::Cell cell_of(const farfield::Box& box, unsigned depth) {
        return {box.center(), 0.5f * box.size(), box.center(), 0.5f * box.size(), std::uint16_t(depth), 0};
    }
};
static_assert(farfield::Partition<MedianSplit>);
