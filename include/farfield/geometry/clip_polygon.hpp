// Convex polygons cut by planes, so that polygons that share an edge get the same point of it, bit by bit.
#pragma once

#include "farfield/settings.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <utility>
#include <vector>

#include "farfield/geometry/cell.hpp"
#include "farfield/geometry/polygon.hpp"
#include "farfield/geometry/rgba8.hpp"

namespace farfield {

/// dot(normal, p - center of a cell) = offset. Relative to the cell: far from the origin an absolute offset in single
/// precision would miss the polygon that the plane was laid through.
struct CuttingPlane {
    glm::vec3 normal{0};  ///< of unit length
    float offset = 0;

    friend bool operator==(const CuttingPlane&, const CuttingPlane&) = default;
};

enum class Side : std::uint8_t { behind, on, in_front };

/// A plane in local coordinates, in double precision: cutting and finding the viewer's side go by the same numbers.
class LocalPlane {
  public:
    LocalPlane(const CuttingPlane& plane, const Cell& cell)
        : normal_(plane.normal),
          offset_(double(plane.offset) + glm::dot(glm::dvec3(plane.normal), glm::dvec3(cell.center))) {
        // Two steps of the largest coordinate: cut points are rounded by up to sqrt(3) / 2 steps in all.
        const glm::dvec3 reach = glm::abs(glm::dvec3(cell.center)) + glm::dvec3(cell.half);
        tolerance_ = 0x1p-22 * glm::max(reach.x, glm::max(reach.y, reach.z));
    }

    const glm::dvec3& normal() const { return normal_; }
    /// The axis that the normal lies along, or -1.
    int axis() const {
        if (normal_.y == 0 && normal_.z == 0) return 0;
        if (normal_.x == 0) return normal_.z == 0 ? 1 : normal_.y == 0 ? 2 : -1;
        return -1;
    }
    /// Points no farther from the plane than this lie on it.
    double tolerance() const { return tolerance_; }
    double height(glm::vec3 p) const { return glm::dot(normal_, glm::dvec3(p)) - offset_; }
    /// The same number where the normal lies along that axis.
    double height_along(int axis, glm::vec3 p) const { return normal_[axis] * double(p[axis]) - offset_; }
    /// The height, or 0 where the point counts as on the plane.
    double height_or_on(glm::vec3 p) const {
        const double h = height(p);
        return std::abs(h) <= tolerance_ ? 0 : h;
    }
    /// The height of a viewpoint as LocalView gives it; only its sign means something.
    double height(glm::vec4 p) const { return glm::dot(normal_, glm::dvec3(glm::vec3(p))) - offset_ * double(p.w); }

  private:
    glm::dvec3 normal_;
    double offset_ = 0, tolerance_ = 0;
};

/// A vertex and its color, not premultiplied.
struct Corner {
    glm::vec3 position{0};
    Rgba8 color;
};

/// See polygon.hpp.
inline glm::dvec3 doubled_area(std::span<const Corner> polygon) {
    return doubled_area<double>(polygon.size(), [&](std::size_t i) { return polygon[i].position; });
}

/// The point where the edge a b, whose ends lie on different sides, meets the plane, whichever end comes first.
inline Corner crossing(Corner a, double height_a, Corner b, double height_b) {
    const auto is_before = [](glm::vec3 p, glm::vec3 q) {
        return p.x != q.x ? p.x < q.x : p.y != q.y ? p.y < q.y : p.z < q.z;
    };
    if (is_before(b.position, a.position)) {
        std::swap(a, b);
        std::swap(height_a, height_b);
    }
    const double t = height_a / (height_a - height_b);
    const auto byte = [&](std::uint8_t p, std::uint8_t q) {
        return std::uint8_t(double(p) + (double(q) - double(p)) * t + 0.5);
    };
    const glm::dvec3 from(a.position), to(b.position);
    return {glm::vec3(from + (to - from) * t),
            {byte(a.color.r, b.color.r), byte(a.color.g, b.color.g), byte(a.color.b, b.color.b),
             byte(a.color.a, b.color.a)}};
}

/// Appends the part of a convex polygon on one side of a plane, in its order; corners on the plane go to both sides.
/// Nothing is appended where rounding leaves no area, seen along `normal`.
inline bool append_part(std::span<const Corner> polygon, const LocalPlane& plane, Side side, glm::vec3 normal,
                        std::vector<Corner>& out) {
    const double sign = side == Side::behind ? -1 : 1;
    const std::size_t begin = out.size();
    const auto add = [&](const Corner& c) {
        if (out.size() == begin || out.back().position != c.position) out.push_back(c);
    };
    double from = plane.height_or_on(polygon[0].position);
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const std::size_t next = i + 1 < polygon.size() ? i + 1 : 0;
        const double to = plane.height_or_on(polygon[next].position);
        if (from * sign >= 0) add(polygon[i]);
        if ((from < 0 && to > 0) || (from > 0 && to < 0)) add(crossing(polygon[i], from, polygon[next], to));
        from = to;
    }
    while (out.size() > begin + 1 && out.back().position == out[begin].position) out.pop_back();
    const std::span<const Corner> part(out.data() + begin, out.size() - begin);
    if (part.size() >= 3 && glm::dot(doubled_area(part), glm::dvec3(normal)) > 0) return true;
    out.resize(begin);
    return false;
}

}  // namespace farfield
