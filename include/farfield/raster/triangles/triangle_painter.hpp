// Draws one triangle into a picture: by scan conversion, or as one deposit if it is small.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <utility>

#include "farfield/geometry/area_law.hpp"
#include "farfield/geometry/length.hpp"
#include "farfield/geometry/light.hpp"
#include "farfield/raster/far_field/far_sample.hpp"
#include "farfield/raster/polygon_clip.hpp"
#include "farfield/raster/sample_projection.hpp"
#include "farfield/raster/scan_conversion.hpp"
#include "farfield/raster/shading.hpp"
#include "farfield/raster/triangles/triangle_stream.hpp"
#include "farfield/raster/triangles/triangle_triage.hpp"

namespace farfield::detail {

/// A shade gives a fill the color of a sample; colors are known after prepare().
struct OneColor {
    static constexpr bool is_one_color = true;
    const Rgba8& color;  ///< opaque
    Rgba8 operator()(int, int) const { return color; }
};
struct SeveralColors {
    static constexpr bool is_one_color = false;
    const Rgba8 (&corners)[3];
    bool are_equal;
    std::optional<ColorPlane> plane{};  ///< set by prepare()
    std::uint32_t hash = 0;             ///< of the triangle; set by prepare()

    bool are_opaque() const { return corners[0].a == 255 && corners[1].a == 255 && corners[2].a == 255; }
    Rgba8 operator()(int x, int y) const {
        Rgba8 c = are_equal ? corners[0] : plane->at(x, y, corners);
        if (c.a != 255 && !covered_by_hash(x, y, hash, c.a)) c.a = 0;
        return c;
    }
};

/// Valid as long as view and source stay the same. `light` is in the source's axes; null leaves colors as they are.
///
/// Fill decides what is done with samples: fill.rejects(triangle) is called before anything is set up, then
/// fill(triangle, doubled_area, prepare, shade), as in depth_tested_fill.hpp.
template <class Fill>
class TrianglePainter {
  public:
    TrianglePainter(const TriangleStream& stream, const SampleProjection& projection, const DirectionalLight* light,
                    bool culls_back_faces, const Fill& fill)
        : stream_(stream), projection_(projection), light_(light), culls_back_faces_(culls_back_faces), fill_(fill) {}

    /// Draws a lane of TriageMasks::draw.
    void draw(std::uint32_t triangle, const TriagedBlock& triaged, unsigned lane) {
        SnappedTriangle t = snapped(triaged, lane);
        draw(triangle, t);
    }

    /// Draws a lane of TriageMasks::draw that was deposited too, as far away as its farthest corner, so that it hides
    /// neither its own deposit nor its neighbors'.
    void draw_behind(std::uint32_t triangle, const TriagedBlock& triaged, unsigned lane) {
        SnappedTriangle t = snapped(triaged, lane);
        t.q[0] = t.q[1] = t.q[2] = std::min(std::min(t.q[0], t.q[1]), t.q[2]);
        draw(triangle, t);
    }

    /// Draws a lane of TriageMasks::clip.
    void draw_clipped(std::uint32_t triangle) {
        ClippedPolygon polygon;
        const Rgba8* colors = stream_.colors(triangle);
        for (unsigned c = 0; c < 3; ++c) {
            polygon.add(stream_.vertex(triangle, c), projection_, to_vec4(colors[stream_.several_colors() ? c : 0]));
        }
        polygon.clip(projection_);
        for (std::size_t i = 2; i < polygon.size(); ++i) {
            SnappedTriangle t;
            Rgba8 corners[3];
            const std::size_t from[3] = {0, i - 1, i};
            for (unsigned c = 0; c < 3; ++c) {
                polygon.snap(from[c], projection_, t, c);
                corners[c] = to_rgba8(polygon[from[c]].color);
            }
            draw(triangle, t, corners);
        }
    }

    /// Deposits a lane of TriageMasks::small into fill.buffers(), after SampleBuffers::begin_far(): a square of its
    /// area around its centroid, in the mean of its corners' colors. `opaque` is its law's loss where something opaque
    /// covers all.
    void deposit(std::uint32_t triangle, const TriagedBlock& triaged, unsigned lane, bool front, Loss opaque) {
        const Rgba8* colors = stream_.colors(triangle);
        const bool several = stream_.several_colors();
        const int alpha = several ? (colors[0].a + colors[1].a + colors[2].a) / 3 : colors[0].a;
        if (alpha == 0) return;
        const auto rgb = [&] {
            glm::vec3 sum = channels(colors[0]);
            if (several) sum = (sum + channels(colors[1]) + channels(colors[2])) * (1.0f / 3);
            const float brightness = light_ ? light_->brightness(normal(triangle, front)) : 1.0f;
            return glm::min(sum * (brightness * (1.0f / 255)), glm::vec3(1));
        };
        const float x = triaged.center_x[lane], y = triaged.center_y[lane], q = triaged.center_q[lane];
        const float area = triaged.area[lane], part = float(alpha) * (1.0f / 255);
        const Loss loss{part * opaque.relative, part * opaque.absolute};
        if (area * float(lanes::count) <= 1) return fill_.buffers().deposit_in_lane(x, y, area, q, loss, rgb);
        const float half = 0.5f * std::sqrt(area);
        fill_.buffers().deposit_square(x - half, y - half, x + half, y + half, q, loss, rgb());
    }

  private:
    static glm::vec3 channels(Rgba8 c) { return {float(c.r), float(c.g), float(c.b)}; }

    static SnappedTriangle snapped(const TriagedBlock& triaged, unsigned lane) {
        SnappedTriangle t;
        for (unsigned c = 0; c < 3; ++c) {
            t.x[c] = snapped_to_256th(triaged.x[c][lane]);
            t.y[c] = snapped_to_256th(triaged.y[c][lane]);
            t.q[c] = triaged.q[c][lane];
        }
        return t;
    }

    /// The normal on the visible side, of any length.
    glm::vec3 normal(std::uint32_t triangle, bool front) const {
        const glm::vec3 a = stream_.vertex(triangle, 0);
        const glm::vec3 n = normal_to(stream_.vertex(triangle, 1) - a, stream_.vertex(triangle, 2) - a);
        return front ? n : -n;
    }

    void draw(std::uint32_t triangle, SnappedTriangle& t) {
        const Rgba8* colors = stream_.colors(triangle);
        Rgba8 corners[3] = {colors[0], colors[0], colors[0]};
        if (stream_.several_colors()) {
            corners[1] = colors[1];
            corners[2] = colors[2];
        }
        draw(triangle, t, corners);
    }

    void draw(std::uint32_t triangle, SnappedTriangle& t, Rgba8 (&colors)[3]) {
        if (fill_.rejects(t)) return;
        const std::int64_t signed_area = t.doubled_area();
        if (signed_area == 0) return;
        const bool is_clockwise = signed_area > 0;  // rows run downwards
        const bool front = is_clockwise == projection_.is_mirrored;
        if (!front && culls_back_faces_) return;
        if (!is_clockwise) {
            t.flip();
            std::swap(colors[1], colors[2]);
        }
        const std::int64_t doubled_area = is_clockwise ? signed_area : -signed_area;
        const auto light = [&] {
            if (!light_) return;
            const float brightness = light_->brightness(normal(triangle, front));
            for (Rgba8& c : colors) c = scaled(c, brightness);
        };
        const bool one_color = colors[0] == colors[1] && colors[0] == colors[2];
        if (one_color && colors[0].a == 255) {
            fill_(t, doubled_area, light, OneColor{colors[0]});
            return;
        }
        SeveralColors shade{colors, one_color};
        const auto prepare = [&] {
            light();
            shade.plane.emplace(t, doubled_area, projection_.color_weight);
            shade.hash = hash_of_triangle(stream_.vertex(triangle, 0), stream_.vertex(triangle, 1),
                                          stream_.vertex(triangle, 2)) +
                         projection_.seed;
        };
        fill_(t, doubled_area, prepare, shade);
    }

    const TriangleStream& stream_;
    const SampleProjection& projection_;
    const DirectionalLight* light_;
    bool culls_back_faces_;
    const Fill& fill_;
};

}  // namespace farfield::detail
