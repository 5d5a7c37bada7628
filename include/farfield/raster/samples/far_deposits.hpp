// Deposits faces and splats of the far field into samples.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "farfield/geometry/area_law.hpp"
#include "farfield/raster/polygon_clip.hpp"
#include "farfield/raster/sample_projection.hpp"
#include "farfield/raster/samples/sample_buffers.hpp"
#include "farfield/raster/scan_conversion.hpp"
#include "farfield/renderer.hpp"

namespace farfield {

/// SampleBuffers::begin_far() must come before the first deposit.
class FarDeposits {
  public:
    FarDeposits(const SampleProjection& projection, SampleBuffers& buffers)
        : projection_(projection), buffers_(buffers) {}

    /// Deposits a polygon, sample by sample: adjoining faces leave no gap.
    void add(const Face& face) {
        if (face.rgba.a == 0) return;
        ClippedPolygon polygon;
        const int axis = face.side / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
        for (int corner = 0; corner < 4; ++corner) {
            glm::vec3 p = face.lower;
            if (corner == 1 || corner == 2) p[u] = face.upper[u];
            if (corner >= 2) p[v] = face.upper[v];
            polygon.add(p, projection_);
        }
        polygon.clip(projection_);
        add(polygon, face.rgba);
    }

    /// Deposits a rectangle: each sample gets its share by overlap.
    void add(const Splat& splat) {
        const glm::vec3 p = projection_.project(splat.center);
        if (!(p.z > projection_.near_depth)) return;
        const float inverse = projection_.inverse_w(p.z), q = projection_.q(p.z, inverse);
        const float x = (p.x * inverse + projection_.offset_x) * (1.0f / 256),
                    y = (p.y * inverse + projection_.offset_y) * (1.0f / 256);
        const glm::vec2 half = splat.size * (0.5f * projection_.focal * inverse);
        const Loss loss = loss_of_opacity(splat.opacity, AreaLaw(splat.rgb.a));
        const glm::vec3 rgb = glm::vec3(float(splat.rgb.r), float(splat.rgb.g), float(splat.rgb.b)) * (1 / 255.0f);
        buffers_.deposit_square(x - half.x, y - half.y, x + half.x, y + half.y, q, loss, rgb);
    }

  private:
    void add(const ClippedPolygon& polygon, Rgba8 premultiplied) {
        const float opacity = float(premultiplied.a) * (1 / 255.0f);
        const Loss loss = loss_of_opacity(opacity, law_of_opacity(opacity));
        const glm::vec3 rgb = glm::vec3(float(premultiplied.r), float(premultiplied.g), float(premultiplied.b)) *
                              (1.0f / float(premultiplied.a));
        for (std::size_t i = 2; i < polygon.size(); ++i) {
            SnappedTriangle t;
            const std::size_t from[3] = {0, i - 1, i};
            for (unsigned c = 0; c < 3; ++c) polygon.snap(from[c], projection_, t, c);
            std::int64_t doubled_area = t.doubled_area();
            if (doubled_area == 0) continue;
            if (doubled_area < 0) {
                t.flip();
                doubled_area = -doubled_area;
            }
            const DepthPlane plane(t, doubled_area);
            scan_convert(t, projection_, [&](int y, int begin, int end) {
                const float row = plane.row(y);
                buffers_.deposit_row(
                    y, begin, end, [&](int x) { return plane.at(row, x); }, loss, rgb);
            });
        }
    }

    const SampleProjection& projection_;
    SampleBuffers& buffers_;
};

}  // namespace farfield
