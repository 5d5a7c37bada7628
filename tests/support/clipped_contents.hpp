// A cell's contents as a partition that cuts gets them.
#pragma once

#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "farfield/geometry/cell_polygons.hpp"

namespace farfield::test {

inline Cell unit_cell() {
    Cell cell;
    cell.half = cell.bounds_half = glm::vec3(1);
    return cell;
}

/// Polygons and, before them, instances.
struct ClippedContents {
    std::vector<ClippedItem> items;
    std::vector<Corner> corners;
    std::vector<SupportingPlane> planes;

    void add_instance(const Box& bounds) { items.push_back({bounds, std::uint32_t(items.size()), 0, 0, 0, 1}); }
    void add(const std::vector<glm::vec3>& vertices) {
        ClippedItem item{Box::empty(),
                         std::uint32_t(items.size()),
                         std::uint32_t(planes.size()),
                         std::uint32_t(corners.size()),
                         std::uint32_t(vertices.size()),
                         1};
        for (const glm::vec3& v : vertices) corners.push_back({v, {}}), item.bounds.add(v);
        const std::span<const Corner> own = std::span<const Corner>(corners).subspan(item.first_corner);
        const glm::vec3 normal(glm::normalize(doubled_area(own)));
        planes.push_back({normal, double(glm::dot(normal, vertices[0]))});
        items.push_back(item);
    }
    ClippedItems all() const { return {items, corners, planes}; }
};

}  // namespace farfield::test
