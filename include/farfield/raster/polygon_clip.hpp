// Convex polygons across the near plane or far off the screen.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "farfield/raster/scan_conversion.hpp"
#include "farfield/raster/triangle_triage.hpp"

namespace farfield {

/// Sutherland and Hodgman 1974, in coordinates before division, so that nothing behind the eye is ever divided. A cut
/// point is computed from the inner to the outer end whichever way the edge runs: polygons that share an edge get the
/// same point and stay watertight.
class ClippedPolygon {
  public:
    struct Vertex {
        glm::vec3 p{0};      ///< SampleProjection::project
        glm::vec4 color{0};  ///< whatever varies linearly over the polygon
    };
    static constexpr std::size_t largest_input = 64;

    void add(glm::vec3 projected, glm::vec4 color = glm::vec4(0)) {
        if (count_ < largest_input) vertices_[count_++] = {projected, color};
    }

    /// Afterwards all that is left lies in front of the near plane and inside the guard band.
    void clip(const SampleProjection& to) {
        if (std::isfinite(to.near_depth)) cut([&](glm::vec3 p) { return p.z - to.near_depth; });
        const float guard = SampleProjection::guard_band * 256;
        const auto w = [&](glm::vec3 p) { return guard * (p.z * to.depth_weight + to.depth_bias); };
        cut([&](glm::vec3 p) { return w(p) - p.x; });
        cut([&](glm::vec3 p) { return w(p) + p.x; });
        cut([&](glm::vec3 p) { return w(p) - p.y; });
        cut([&](glm::vec3 p) { return w(p) + p.y; });
    }

    std::size_t size() const { return count_; }
    const Vertex& operator[](std::size_t i) const { return vertices_[i]; }

    /// Corner `corner` of a triangle, snapped as TriagedBlock is.
    void snap(std::size_t vertex, const SampleProjection& to, SnappedTriangle& t, unsigned corner) const {
        const glm::vec3 p = vertices_[vertex].p;
        const float inverse = to.inverse_w(p.z);
        t.x[corner] = snapped_to_256th(p.x * inverse + to.offset_x);
        t.y[corner] = snapped_to_256th(p.y * inverse + to.offset_y);
        t.q[corner] = to.q(p.z, inverse);
    }

  private:
    template <class Distance>
    void cut(Distance&& inside) {
        std::array<Vertex, largest_input + 8> out;
        std::size_t n = 0;
        for (std::size_t i = 0; i < count_; ++i) {
            const Vertex& a = vertices_[i];
            const Vertex& b = vertices_[i + 1 < count_ ? i + 1 : 0];
            const float da = inside(a.p), db = inside(b.p);
            if (da >= 0) out[n++] = a;
            if ((da >= 0) == (db >= 0)) continue;
            const Vertex& in = da >= 0 ? a : b;
            const Vertex& beyond = da >= 0 ? b : a;
            const float d_in = da >= 0 ? da : db, d_beyond = da >= 0 ? db : da;
            const float t = d_in / (d_in - d_beyond);
            out[n++] = {in.p + (beyond.p - in.p) * t, in.color + (beyond.color - in.color) * t};
        }
        count_ = n;
        for (std::size_t i = 0; i < n; ++i) vertices_[i] = out[i];
    }

    std::array<Vertex, largest_input + 8> vertices_;
    std::size_t count_ = 0;
};

}  // namespace farfield
