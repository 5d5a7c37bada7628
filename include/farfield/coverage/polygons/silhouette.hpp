// The outline of a box on the screen: "it is only necessary to tile a cube's polygonal silhouette" (Greene 1996,
// section 5.2).
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "farfield/coverage/polygons/surface.hpp"
#include "farfield/geometry/cell.hpp"
#include "farfield/raster/box_fronts.hpp"
#include "farfield/raster/sample_projection.hpp"
#include "farfield/raster/snapping.hpp"

namespace farfield::detail {

/// The outline is the hull of the snapped corners, in integers, and so convex whatever rounding does. It has two
/// corners or one if the whole box is snapped to a line or a point, which still serves a query that grows it. Rejected:
/// the table of outlines by the eye's region, whose corners rounding may turn inwards.
struct Silhouette {
    TilePolygon outline;
    BoxFronts fronts;

    /// Returns false if the box reaches behind the near plane or so far off the screen that it needs clipping.
    bool project(glm::vec3 center, glm::vec3 half, const SampleProjection& projection) {
        std::array<Point, 8> points;
        const float guard = SampleProjection::guard_band * 256;
        float least_depth = 0;
        glm::vec2 low(0), high(0);
        for (unsigned corner = 0; corner < 8; ++corner) {
            const glm::vec3 side(corner & 1 ? half.x : -half.x, corner & 2 ? half.y : -half.y,
                                 corner & 4 ? half.z : -half.z);
            const glm::vec3 p = projection.project(center + side);
            if (!(p.z > projection.near_depth)) return false;
            const float inverse = projection.inverse_w(p.z), x = p.x * inverse + projection.offset_x,
                        y = p.y * inverse + projection.offset_y;
            if (!(x > -guard && x < guard && y > -guard && y < guard)) return false;
            points[corner] = {snapped_to_256th(x), snapped_to_256th(y)};
            low = corner == 0 ? glm::vec2(x, y) : glm::min(low, glm::vec2(x, y));
            high = corner == 0 ? glm::vec2(x, y) : glm::max(high, glm::vec2(x, y));
            least_depth = corner == 0 ? p.z : std::min(least_depth, p.z);
        }
        // A box is nowhere nearer than its nearest corner, up to rounding, which grows with the terms of a depth.
        const float rounding =
            glm::dot(glm::abs(projection.forward), glm::abs(center - projection.anchor) + half) * 0x1p-20f +
            std::abs(least_depth) * 0x1p-18f;
        const float depth = std::max(least_depth - rounding, projection.near_depth);
        const float nearest_q = projection.q(depth, projection.inverse_w(depth));
        const float rounding_q = nearest_q - projection.q(least_depth, projection.inverse_w(least_depth));
        fronts = BoxFronts(center, half, projection, {low, high}, nearest_q, rounding_q);

        // A. M. Andrew, "Another efficient algorithm for convex hulls in two dimensions", 1979.
        std::sort(points.begin(), points.end());
        const auto end = std::unique(points.begin(), points.end());
        const auto count = std::size_t(end - points.begin());
        std::array<Point, 17> hull;
        std::size_t n = 0;
        const auto add = [&](Point p, std::size_t floor) {
            while (n >= floor + 2) {
                const Point a = hull[n - 2], b = hull[n - 1];
                const std::int64_t turn = std::int64_t(b.x - a.x) * (p.y - b.y) - std::int64_t(b.y - a.y) * (p.x - b.x);
                if (turn > 0) break;
                --n;
            }
            hull[n++] = p;
        };
        for (std::size_t i = 0; i < count; ++i) add(points[i], 0);
        const std::size_t lower = n - 1;
        for (std::size_t i = count; i-- > 0;) add(points[i], lower);
        --n;  // the first again
        if (n > std::size_t(TilePolygon::most_corners)) return false;
        outline.corners = int(n);
        for (std::size_t i = 0; i < n; ++i) {
            outline.x[i] = hull[i].x;
            outline.y[i] = hull[i].y;
        }
        return true;
    }

  private:
    struct Point {
        std::int32_t x, y;
        bool operator<(const Point& p) const { return x != p.x ? x < p.x : y < p.y; }
        bool operator==(const Point& p) const { return x == p.x && y == p.y; }
    };
};

}  // namespace farfield::detail
