// Clips convex polygons that cross the near plane or lie far off the screen.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "farfield/raster/sample_projection.hpp"
#include "farfield/raster/scan_conversion.hpp"
#include "farfield/raster/snapping.hpp"

namespace farfield::detail {

/// Clips as Sutherland and Hodgman 1974 do, in coordinates before division, so that nothing behind the eye is ever
/// divided. A cut point is computed from the inner to the outer end whichever way the edge runs: polygons that share an
/// edge get the same point and stay watertight.
///
/// A corner may be 10^17 times as far away as the near plane, where double precision cancels too. A cut point is
/// therefore a sum of positive parts of both ends, which keeps it inside all planes that both ends lie inside of, and
/// then put onto the plane that cuts.
class ClippedPolygon {
  public:
    /// Cut points are computed in double: a ground of kilometers under an eye a hand above it is tilted by more than
    /// that in single precision. Corners that stay are snapped as everywhere else, or they would part from their
    /// neighbors.
    struct Vertex {
        glm::dvec3 p;       ///< as SampleProjection::project gives it
        glm::vec3 rounded;  ///< the same in float, for corners that were not cut
        glm::vec4 color;    ///< whatever varies linearly over the polygon
        bool is_cut;
    };
    /// Enough for triangles and far-field faces; each of the six planes adds at most one corner.
    static constexpr std::size_t largest_input = 8;

    /// Takes local coordinates.
    void add(glm::vec3 corner, const SampleProjection& projection, glm::vec4 color = glm::vec4(0)) {
        if (count_ == largest_input) return;
        const glm::dvec3 d = glm::dvec3(corner) - glm::dvec3(projection.anchor);
        const glm::dvec3 p(glm::dot(glm::dvec3(projection.right), d), glm::dot(glm::dvec3(projection.down), d),
                           glm::dot(glm::dvec3(projection.forward), d));
        vertices_[count_++] = {p, projection.project(corner), color, false};
    }

    /// Leaves the part between the near plane and the far one and inside the guard band.
    void clip(const SampleProjection& projection) {
        if (std::isfinite(projection.near_depth)) {
            const auto near_depth = double(projection.near_depth);
            cut([&](const glm::dvec3& p) { return p.z - near_depth; }, [&](glm::dvec3& p) { p.z = near_depth; });
        }
        if (std::isfinite(projection.far_depth)) {
            const auto far_depth = double(projection.far_depth);
            cut([&](const glm::dvec3& p) { return far_depth - p.z; }, [&](glm::dvec3& p) { p.z = far_depth; });
        }
        const auto edge = [&](const glm::dvec3& p) { return guard * w(p, projection); };
        cut([&](const glm::dvec3& p) { return edge(p) - p.x; }, [&](glm::dvec3& p) { p.x = edge(p); });
        cut([&](const glm::dvec3& p) { return edge(p) + p.x; }, [&](glm::dvec3& p) { p.x = -edge(p); });
        cut([&](const glm::dvec3& p) { return edge(p) - p.y; }, [&](glm::dvec3& p) { p.y = edge(p); });
        cut([&](const glm::dvec3& p) { return edge(p) + p.y; }, [&](glm::dvec3& p) { p.y = -edge(p); });
    }

    std::size_t size() const { return count_; }
    const Vertex& operator[](std::size_t i) const { return vertices_[i]; }

    /// Sets corner `corner` of a triangle to the position that triage() and snapping would give it.
    void snap(std::size_t vertex, const SampleProjection& projection, SnappedTriangle& t, unsigned corner) const {
        const Vertex& v = vertices_[vertex];
        const float inverse = projection.inverse_w(v.rounded.z);
        const float x = v.rounded.x * inverse + projection.offset_x, y = v.rounded.y * inverse + projection.offset_y;
        // What overflows in single precision is in no polygon that was not clipped.
        const bool is_rounded = !v.is_cut && v.rounded.z >= projection.near_depth && std::abs(x) < float(guard) &&
                                std::abs(y) < float(guard);
        if (is_rounded) {
            t.x[corner] = snapped_to_256th(x);
            t.y[corner] = snapped_to_256th(y);
            t.q[corner] = projection.q(v.rounded.z, inverse);
        } else {
            const double exact = 1.0 / w(v.p, projection);
            const auto within = [](double s) { return std::clamp(s, -guard, guard); };
            t.x[corner] = snapped_to_256th(float(within(v.p.x * exact) + double(projection.offset_x)));
            t.y[corner] = snapped_to_256th(float(within(v.p.y * exact) + double(projection.offset_y)));
            t.q[corner] = float(exact * (double(projection.q_of_inverse) + v.p.z * double(projection.q_of_depth)));
        }
    }

  private:
    static constexpr double guard = double(SampleProjection::guard_band) * 256;

    static double w(const glm::dvec3& p, const SampleProjection& projection) {
        return p.z * double(projection.depth_weight) + double(projection.depth_bias);
    }

    /// Keeps what lies at inside(p) >= 0; put(p) moves a cut point to where that is 0.
    template <class Distance, class Put>
    void cut(Distance&& inside, Put&& put) {
        const auto begin = vertices_.begin(), end = begin + std::ptrdiff_t(count_);
        if (std::all_of(begin, end, [&](const Vertex& v) { return inside(v.p) >= 0; })) return;
        std::array<Vertex, largest_input + 8> out;
        std::size_t n = 0;
        for (std::size_t i = 0; i < count_; ++i) {
            const Vertex& a = vertices_[i];
            const Vertex& b = vertices_[i + 1 < count_ ? i + 1 : 0];
            const double da = inside(a.p), db = inside(b.p);
            if (da >= 0) out[n++] = a;
            if ((da >= 0) == (db >= 0)) continue;
            const Vertex& in = da >= 0 ? a : b;
            const Vertex& beyond = da >= 0 ? b : a;
            const double apart = std::abs(da - db), t = std::abs(da >= 0 ? da : db) / apart,
                         rest = std::abs(da >= 0 ? db : da) / apart;
            Vertex& v =
                out[n++] = {in.p * rest + beyond.p * t, {}, in.color + (beyond.color - in.color) * float(t), true};
            put(v.p);
        }
        count_ = n;
        for (std::size_t i = 0; i < n; ++i) vertices_[i] = out[i];
    }

    std::array<Vertex, largest_input + 8> vertices_;
    std::size_t count_ = 0;
};

}  // namespace farfield::detail
