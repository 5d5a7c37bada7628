// Whether polygons come in strict order: looked at along rays, as nothing but the picture counts.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "farfield/renderer.hpp"
#include "support/random.hpp"

namespace farfield::test {

/// Keeps the polygons of a frame as they come, in the camera's coordinates: right, up, depth.
class OrderRecorder {
  public:
    static constexpr RendererFacts facts{.order = VisitOrder::front_to_back,
                                         .needs_ordering = OrderGuarantee::primitives};
    using CameraPolygon = std::vector<glm::dvec3>;
    std::vector<CameraPolygon> polygons;

    void begin_frame(const LocalView& view) {
        polygons.clear();
        set_view(view);
    }
    void set_view(const LocalView& view) {
        eye_ = view.eye;
        right_ = view.right;
        up_ = view.up;
        forward_ = view.forward;
        scale_ = view.scale;
    }
    template <class P>
    void draw(const Source<P>& source, std::span<const Range> ranges) {
        for (const Range& r : ranges) {
            for (std::uint32_t at = r.first; at < r.first + r.count; ++at) {
                source.polygons(at, [&](const Polygon& polygon) {
                    CameraPolygon& out = polygons.emplace_back();
                    for (const glm::vec3& v : polygon.vertices) {
                        const glm::dvec3 d = glm::dvec3(v) - eye_;
                        out.push_back(double(scale_) *
                                      glm::dvec3(glm::dot(d, right_), glm::dot(d, up_), glm::dot(d, forward_)));
                    }
                });
            }
        }
    }
    void end_frame() {}

  private:
    glm::dvec3 eye_{0}, right_{0}, up_{0}, forward_{0};
    float scale_ = 1;
};

/// Along one ray: at which depths polygons are hit, in the order they came in, and by how much those may be off.
struct Hits {
    std::vector<double> depth, tolerance;
};
inline Hits hits_along(std::span<const OrderRecorder::CameraPolygon> polygons, glm::dvec3 from, glm::dvec3 direction,
                       double step) {
    Hits hits;
    for (const auto& polygon : polygons) {
        glm::dvec3 normal(0);
        for (std::size_t i = 2; i < polygon.size(); ++i) {
            normal += glm::cross(polygon[i - 1] - polygon[0], polygon[i] - polygon[0]);
        }
        const double length = glm::length(normal);
        if (!(length > 0)) continue;
        normal /= length;
        const double slope = glm::dot(normal, direction);
        if (std::abs(slope) < 1e-3) continue;  // on edge
        const double depth = glm::dot(normal, polygon[0] - from) / slope;
        if (!(depth > 0)) continue;
        const glm::dvec3 hit = from + depth * direction;
        bool inside = true;
        for (std::size_t i = 0; i < polygon.size() && inside; ++i) {
            const glm::dvec3 a = polygon[i], edge = polygon[i + 1 < polygon.size() ? i + 1 : 0] - a;
            // Beside an edge by more than it may have been moved.
            inside = glm::dot(glm::cross(normal, edge), hit - a) > 4 * step * glm::length(edge);
        }
        if (!inside) continue;
        hits.depth.push_back(depth);
        hits.tolerance.push_back(4 * step / std::abs(slope));
    }
    return hits;
}

struct OrderCheck {
    std::size_t hits = 0, wrong = 0;
};
/// `step` is that of single precision at the scene's largest coordinate. Of a perspective view rays leave the eye, of
/// an orthographic one a square of side 2 * `extent`.
inline OrderCheck check_order(std::span<const OrderRecorder::CameraPolygon> polygons, bool is_perspective,
                              double extent, double step, int rays, std::uint64_t seed) {
    Random random(seed);
    OrderCheck check;
    for (int r = 0; r < rays; ++r) {
        const double x = double(random.between(-1, 1)), y = double(random.between(-1, 1));
        const Hits hits =
            is_perspective ? hits_along(polygons, glm::dvec3(0), glm::normalize(glm::dvec3(0.6 * x, 0.6 * y, 1)), step)
                           : hits_along(polygons, {extent * x, extent * y, 0}, {0, 0, 1}, step);
        check.hits += hits.depth.size();
        double farthest = -1e300, its_tolerance = 0;
        for (std::size_t i = 0; i < hits.depth.size(); ++i) {
            check.wrong += hits.depth[i] < farthest - its_tolerance - hits.tolerance[i];
            if (hits.depth[i] > farthest) {
                farthest = hits.depth[i];
                its_tolerance = hits.tolerance[i];
            }
        }
    }
    return check;
}

}  // namespace farfield::test
