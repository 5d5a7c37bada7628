#include "scenes/load/mesh.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace farfield::scenes::detail {
namespace {

constexpr double most = 0x1p100, least = 0x1p-100;

/// The power of ten that is at least `length`; in steps, since std::pow is not the same in every C library.
double power_of_ten_above(double length) {
    double power = 1.0;
    while (power < length) power *= 10.0;
    while (power / 10.0 >= length) power /= 10.0;
    return power;
}

}  // namespace

glm::dvec3 origin_of(const BoxD& box) {
    const double side = box.largest_side();
    glm::dvec3 origin(0.0);
    if (!(side > 0.0) || !std::isfinite(side)) return origin;
    const double unit = power_of_ten_above(side);
    const glm::dvec3 center = box.center();
    for (int axis = 0; axis < 3; ++axis) {
        const double farthest = std::max(std::abs(box.lower[axis]), std::abs(box.upper[axis]));
        // Halves are rounded down, so that what begins at a round number begins at 0.
        if (!(farthest > 16.0 * side)) continue;
        const double multiple = std::ceil(center[axis] / unit - 0.5) * unit;
        origin[axis] = std::isfinite(multiple) ? multiple : center[axis];
    }
    return origin;
}

glm::dvec3 origin_of_centers(BoxD centers) {
    if (!centers.is_empty() && centers.largest_side() == 0) {
        centers.lower -= 1.0;
        centers.upper += 1.0;
    }
    return origin_of(centers);
}

glm::vec3 in_single_precision(const glm::dvec3& point, const glm::dvec3& origin, std::string_view kind,
                              std::size_t index) {
    const glm::dvec3 local = point - origin;
    for (int axis = 0; axis < 3; ++axis) {
        if (std::abs(local[axis]) <= most) continue;  // false for NaN, too
        throw std::runtime_error(
            std::string(kind) + ' ' + std::to_string(index) +
            (std::isfinite(local[axis]) ? " is too far away to be drawn: more than 2^100" : " is not finite"));
    }
    return glm::vec3(local);
}

void check_size(const BoxD& box) {
    const double side = box.largest_side();
    if (side > 0.0 && side < least)
        throw std::runtime_error("is too small to be drawn: its longest side is below 2^-100");
}

Loaded in_single_precision(const Mesh& mesh) {
    BoxD box = BoxD::empty();
    for (const MeshTriangle& triangle : mesh.triangles) {
        for (const std::uint32_t corner : triangle.corners) box.add(mesh.positions[corner]);
    }
    Loaded loaded;
    loaded.origin = origin_of(box);
    if (!mesh.triangles.empty()) check_size(box);
    loaded.triangles.reserve(mesh.triangles.size());
    for (const MeshTriangle& triangle : mesh.triangles) {
        VertexColoredTriangle& single = loaded.triangles.emplace_back();
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t corner = triangle.corners[k];
            single.vertices[k] = in_single_precision(mesh.positions[corner], loaded.origin, "vertex", corner);
        }
        single.rgba = triangle.colors;
    }
    return loaded;
}

}  // namespace farfield::scenes::detail
