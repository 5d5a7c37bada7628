// The outline of a box on the screen: "it is only necessary to tile a cube's polygonal silhouette" (Greene 1996,
// section 5.2).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <limits>

#include "farfield/cell.hpp"
#include "farfield/coverage/surface.hpp"
#include "farfield/raster/sample_projection.hpp"
#include "farfield/raster/triangle_triage.hpp"

namespace farfield {

/// Convex whatever rounding does: the hull of the snapped corners, in integers. Two corners or one where all of the box
/// is snapped to a line or a point: of use to who asks with a polygon grown. Rejected: the table of outlines by the
/// eye's region, whose corners rounding may turn inwards.
struct Silhouette {
    TilePolygon outline;
    /// q of no point of the box is larger.
    float nearest_q = 0;
    /// The sides that face the eye. A ray enters the box where it meets the last of them, so that none of what lies
    /// inside has, at a sample, a larger q than any of these planes. They are raised by as much as rounding and
    /// snapping may raise what is drawn. (The depth of a sliver on the screen, made from corners that lie all but on a
    /// line, is known only within that of its corners: where one comes before what hides it, it is by that error, and
    /// may be left out.)
    std::array<DepthPlane, 3> fronts;
    int front_count = 0;  ///< at least one

    /// Of something that is only known to be nowhere nearer.
    void set_front(float q) {
        nearest_q = q;
        fronts[0] = DepthPlane(q, 0, 0, q, q);
        front_count = 1;
    }

    /// False where the box reaches behind the near plane or so far off the screen that it would have to be clipped.
    bool project(glm::vec3 center, glm::vec3 half, const SampleProjection& to) {
        std::array<Point, 8> points;
        const float guard = SampleProjection::guard_band * 256;
        float least_depth = 0;
        for (unsigned corner = 0; corner < 8; ++corner) {
            const glm::vec3 side(corner & 1 ? half.x : -half.x, corner & 2 ? half.y : -half.y,
                                 corner & 4 ? half.z : -half.z);
            const glm::vec3 p = to.project(center + side);
            if (!(p.z > to.near_depth)) return false;
            const float inverse = to.inverse_w(p.z), x = p.x * inverse + to.offset_x, y = p.y * inverse + to.offset_y;
            if (!(x > -guard && x < guard && y > -guard && y < guard)) return false;
            points[corner] = {snapped_to_256th(x), snapped_to_256th(y)};
            least_depth = corner == 0 ? p.z : std::min(least_depth, p.z);
        }
        // A box is nowhere nearer than its nearest corner, but for rounding, which goes by what depths are sums of.
        const float rounding = glm::dot(glm::abs(to.forward), glm::abs(center - to.eye) + half) * 0x1p-20f +
                               std::abs(least_depth) * 0x1p-18f;
        const float depth = std::max(least_depth - rounding, to.near_depth);
        nearest_q = to.q(depth, to.inverse_w(depth));
        find_fronts(center, half, to, nearest_q - to.q(least_depth, to.inverse_w(least_depth)), points);

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

    /// A point at depth d that is seen at (X, Y), samples from where the view's axis meets the screen, is eye + d
    /// forward + w (X right + Y down) / focal, w being d in perspective and 1 in orthographic views. With its
    /// coordinate on one axis given, q is linear in X and Y.
    void find_fronts(glm::vec3 center, glm::vec3 half, const SampleProjection& to, float rounding_q,
                     const std::array<Point, 8>& points) {
        // How far contents may be snapped, in samples: see CoverageRenderer::hidden.
        constexpr float snapping = 8.0f / 256;
        const float to_x = to.offset_x * (1.0f / 256), to_y = to.offset_y * (1.0f / 256);
        float reach_x = 0, reach_y = 0;
        for (const Point& p : points) {
            reach_x = std::max(reach_x, std::abs(float(p.x) * (1.0f / 256) - to_x));
            reach_y = std::max(reach_y, std::abs(float(p.y) * (1.0f / 256) - to_y));
        }
        const float by_sample = 1 / (to.focal * to.focal * 256);  // to.right has a length of 256 focal
        front_count = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const float a = to.right[axis] * by_sample, b = to.down[axis] * by_sample;
            const float behind_lower = center[axis] - half[axis] - to.eye[axis],
                        behind_upper = center[axis] + half[axis] - to.eye[axis];
            const float sums = std::abs(center[axis]) + half[axis] + std::abs(to.eye[axis]);
            float q, by_plane, error;
            if (to.is_perspective) {
                const float plane = behind_lower > 0 ? behind_lower : behind_upper < 0 ? behind_upper : 0.0f;
                by_plane = to.q_of_inverse / plane;
                q = by_plane * to.forward[axis];
                error = sums * 0x1p-22f / std::abs(plane);
            } else {
                const float plane = to.forward[axis] > 0 ? behind_lower : behind_upper;
                by_plane = -to.q_of_depth / to.forward[axis];
                q = -by_plane * plane;
                error = sums * 0x1p-22f / std::abs(plane);
            }
            const float by_x = by_plane * a, by_y = by_plane * b;
            const float most = std::abs(q) + std::abs(by_x) * reach_x + std::abs(by_y) * reach_y;
            const float raised =
                q + most * (error + 0x1p-18f) + rounding_q + (std::abs(by_x) + std::abs(by_y)) * snapping;
            const float at_first = raised + by_x * (0.5f - to_x) + by_y * (0.5f - to_y);
            if (!std::isfinite(at_first) || !std::isfinite(by_x) || !std::isfinite(by_y)) continue;
            fronts[std::size_t(front_count++)] =
                DepthPlane(at_first, by_x, by_y, -std::numeric_limits<float>::infinity(), nearest_q);
        }
        if (front_count == 0) set_front(nearest_q);
    }
};

}  // namespace farfield
