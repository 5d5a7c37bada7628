// Polygons of primitives as they come, before they are cut: those without area left out, the two triangles of a
// quadrilateral made one polygon again, for a polygon costs a renderer about the same whatever its number of edges.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <span>
#include <vector>

#include "farfield/geometry/cell_polygons.hpp"
#include "farfield/geometry/polygon.hpp"

namespace farfield::detail {

class PolygonReader {
  public:
    std::vector<Corner> corners;
    std::vector<SupportingPlane> planes;
    std::vector<ClippedItem> items;
    std::uint32_t joined = 0, without_area = 0;

    /// Makes room for as many triangles; memory that is not used is not touched.
    void reserve(std::size_t triangles) {
        corners.reserve(3 * triangles);
        planes.reserve(triangles);
        items.reserve(triangles);
    }

    /// The next polygon is not joined with the one before.
    void interrupt() { previous_is_triangle_ = false; }

    /// `cost` is that of one triangle. Whether a polygon is lit already is not kept: only stand-ins say so, and those
    /// of instances are never cut.
    void add(const Polygon& polygon, std::uint32_t source, float cost) {
        const std::size_t begin = corners.size();
        const bool one_color = polygon.colors.size() < polygon.vertices.size();
        for (std::size_t i = 0; i < polygon.vertices.size(); ++i) {
            if (corners.size() != begin && corners.back().position == polygon.vertices[i]) continue;
            corners.push_back({polygon.vertices[i], polygon.colors[one_color ? 0 : i]});
        }
        while (corners.size() > begin + 1 && corners.back().position == corners[begin].position) corners.pop_back();
        const std::span<const Corner> added(corners.data() + begin, corners.size() - begin);
        const glm::dvec3 area = doubled_area(added);
        if (added.size() < 3 || !(glm::dot(area, area) > 0)) {
            corners.resize(begin);
            ++without_area;
            return;
        }
        const bool is_triangle = added.size() == 3;
        if (is_triangle && previous_is_triangle_ && join(added)) {
            corners.resize(begin + 1);
            previous_is_triangle_ = false;
            items.back().cost = 0.5f * (items.back().cost + cost);
            ++joined;
            return;
        }
        planes.push_back(plane_of(added, area));
        ClippedItem item{
            Box::empty(), source, std::uint32_t(planes.size() - 1), std::uint32_t(begin), std::uint32_t(added.size()),
            cost};
        for (const Corner& c : added) item.bounds.add(c.position);
        items.push_back(item);
        previous_is_triangle_ = is_triangle;
    }

  private:
    static SupportingPlane plane_of(std::span<const Corner> polygon, const glm::dvec3& area) {
        SupportingPlane plane{glm::vec3(glm::normalize(area)), 0};
        for (const Corner& c : polygon) plane.offset += glm::dot(glm::dvec3(plane.normal), glm::dvec3(c.position));
        plane.offset /= double(polygon.size());
        return plane;
    }

    /// The previous triangle and this one, which lies behind it in the array, into the previous one's place.
    bool join(std::span<const Corner> triangle) {
        ClippedItem& item = items.back();
        const std::span<const Corner> before(corners.data() + item.first_corner, 3);
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t k = 0; k < 3; ++k) {
                // An edge that one runs along forwards and the other backwards.
                if (!is_same(before[i], triangle[(k + 1) % 3]) || !is_same(before[(i + 1) % 3], triangle[k])) continue;
                const std::array<Corner, 4> quadrilateral{before[i], triangle[(k + 2) % 3], before[(i + 1) % 3],
                                                          before[(i + 2) % 3]};
                if (!lies_in_plane(quadrilateral[1].position, quadrilateral) || !is_convex(quadrilateral) ||
                    !has_one_gradient(quadrilateral)) {
                    return false;
                }
                planes[item.polygon] = plane_of(quadrilateral, doubled_area(quadrilateral));
                std::copy(quadrilateral.begin(), quadrilateral.end(), corners.begin() + item.first_corner);
                item.corners = 4;
                item.bounds.add(quadrilateral[1].position);
                return true;
            }
        }
        return false;
    }

    static bool is_same(const Corner& a, const Corner& b) { return a.position == b.position && a.color == b.color; }

    /// Whether both triangles have one color, or one linear course of colors: any other two triangles that the
    /// quadrilateral is drawn as then look the same.
    static bool has_one_gradient(const std::array<Corner, 4>& q) {
        if (q[0].color == q[1].color && q[0].color == q[2].color && q[0].color == q[3].color) return true;
        // The second corner is an affine combination of the others.
        const glm::dvec3 origin(q[0].position), u = glm::dvec3(q[2].position) - origin,
                                                v = glm::dvec3(q[3].position) - origin,
                                                p = glm::dvec3(q[1].position) - origin, area = glm::cross(u, v);
        const double along_u = glm::dot(glm::cross(p, v), area) / glm::dot(area, area),
                     along_v = glm::dot(glm::cross(u, p), area) / glm::dot(area, area);
        const auto agrees = [&](std::uint8_t a, std::uint8_t b, std::uint8_t c, std::uint8_t d) {
            const double expected = double(a) + along_u * (double(c) - double(a)) + along_v * (double(d) - double(a));
            return std::abs(expected - double(b)) <= 0.5;
        };
        return agrees(q[0].color.r, q[1].color.r, q[2].color.r, q[3].color.r) &&
               agrees(q[0].color.g, q[1].color.g, q[2].color.g, q[3].color.g) &&
               agrees(q[0].color.b, q[1].color.b, q[2].color.b, q[3].color.b) &&
               agrees(q[0].color.a, q[1].color.a, q[2].color.a, q[3].color.a);
    }

    /// Within two steps of its largest coordinate.
    bool lies_in_plane(glm::vec3 p, std::span<const Corner> quadrilateral) const {
        const SupportingPlane& plane = planes[items.back().polygon];
        float largest = 0;
        for (const Corner& c : quadrilateral) {
            const glm::vec3 a = glm::abs(c.position);
            largest = std::max({largest, a.x, a.y, a.z});
        }
        return std::abs(glm::dot(glm::dvec3(plane.normal), glm::dvec3(p)) - plane.offset) <= 0x1p-22 * double(largest);
    }

    /// Every corner turns the same way, by an angle whose sine is above a thousandth.
    static bool is_convex(const std::array<Corner, 4>& q) {
        const glm::dvec3 normal = glm::normalize(doubled_area(q));
        for (std::size_t i = 0; i < 4; ++i) {
            const glm::dvec3 at(q[i].position), in = at - glm::dvec3(q[(i + 3) % 4].position),
                                                out = glm::dvec3(q[(i + 1) % 4].position) - at;
            if (!(glm::dot(glm::cross(in, out), normal) > 0x1p-10 * glm::length(in) * glm::length(out))) return false;
        }
        return true;
    }

    bool previous_is_triangle_ = false;  ///< and the last item
};

}  // namespace farfield::detail
