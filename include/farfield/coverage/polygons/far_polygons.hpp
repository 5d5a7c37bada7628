// The far field over coverage masks: faces and splats become polygons that cover a part of the samples they lie on or
// are deposited there.
#pragma once

#include "farfield/settings.hpp"

#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "farfield/coverage/polygons/surface.hpp"
#include "farfield/drawables.hpp"
#include "farfield/geometry/area_law.hpp"
#include "farfield/geometry/rgba8.hpp"
#include "farfield/raster/far_field/face_triangles.hpp"
#include "farfield/raster/sample_projection.hpp"
#include "farfield/raster/scan_conversion.hpp"
#include "farfield/raster/shading.hpp"
#include "farfield/raster/snapping.hpp"

namespace farfield {

/// How far-field cells are combined with masks.
enum class FarCoverage : std::uint8_t {
    /// Opacity becomes a part of the 64 samples, chosen anew for every cell and pixel: with cells of a pixel closed
    /// surfaces stay closed, but with larger ones single sheets get holes.
    samples,
    /// Transmittances follow the area law on top of the masks: large cells of sheets leak a quarter as much, but closed
    /// surfaces are torn where far cells adjoin geometry within a pixel. Without a box filter this means `samples`.
    area_law,
};

}  // namespace farfield

namespace farfield::detail {

/// Valid as long as the view stays the same. tile(TilePolygon&) gets `polygon` again and again, with its depth set, and
/// may write to its surface.
template <class Tile>
class FarPolygons {
  public:
    FarPolygons(const SampleProjection& projection, FarCoverage coverage, TilePolygon& polygon, const Tile& tile)
        : projection_(projection), coverage_(coverage), polygon_(polygon), tile_(tile) {}

    void add(const Face& face) {
        if (face.rgba.a == 0) return;
        const float opacity = float(face.rgba.a) * (1 / 255.0f);
        const glm::vec3 rgb =
            glm::vec3(float(face.rgba.r), float(face.rgba.g), float(face.rgba.b)) * (1.0f / float(face.rgba.a));
        shade(rgb, opacity, law_of_opacity(opacity),
              hash_of_triangle(face.lower, face.upper, glm::vec3(face.side)) + projection_.seed);
        for_triangles_of(face, projection_, [&](const SnappedTriangle& t, const DepthPlane& plane) {
            polygon_.set_triangle(t);
            polygon_.surface.depth = plane;
            tile_(polygon_);
        });
    }

    void add(const Splat& splat) {
        const glm::vec3 p = projection_.project(splat.center);
        if (!(p.z > projection_.near_depth)) return;
        const float inverse = projection_.inverse_w(p.z);
        const float x = p.x * inverse + projection_.offset_x, y = p.y * inverse + projection_.offset_y;
        const glm::vec2 half = splat.size * (128.0f * projection_.focal * inverse);
        const float guard = SampleProjection::guard_band * 256;
        if (!(x - half.x > -guard && x + half.x < guard && y - half.y > -guard && y + half.y < guard)) return;
        const glm::vec3 rgb = glm::vec3(float(splat.rgb.r), float(splat.rgb.g), float(splat.rgb.b)) * (1 / 255.0f);
        const auto law = AreaLaw(splat.rgb.a);
        // A rectangle narrower than a sample would fall between samples, so it grows and its opacity shrinks.
        const glm::vec2 grown = glm::max(half, glm::vec2(128));
        const float opacity = splat.opacity * (half.x * half.y) / (grown.x * grown.y);
        const std::int32_t left = snapped_to_256th(x - grown.x), right = snapped_to_256th(x + grown.x);
        const std::int32_t top = snapped_to_256th(y - grown.y), bottom = snapped_to_256th(y + grown.y);
        shade(rgb, opacity, law, hash_of_triangle(splat.center, splat.center, splat.center) + projection_.seed);
        polygon_.set_rectangle(left, top, right, bottom, projection_.q(p.z, inverse));
        tile_(polygon_);
    }

  private:
    /// `rgb` in [0, 1], not premultiplied.
    void shade(glm::vec3 rgb, float opacity, AreaLaw law, std::uint32_t hash) {
        Surface& s = polygon_.surface;
        s = {};
        if (coverage_ == FarCoverage::area_law) {
            s.kind = SurfaceKind::deposit;
            s.colors.fill({0, 0, 0, 0});
            s.loss = loss_of_opacity(opacity, law);
            s.far_rgb = glm::min(rgb, glm::vec3(1));
        } else {
            s.kind = SurfaceKind::fraction;
            s.hash = hash;
            s.colors.fill(to_rgba8(glm::vec4(rgb, opacity)));
        }
    }

    const SampleProjection& projection_;
    FarCoverage coverage_;
    TilePolygon& polygon_;
    Tile tile_;
};

}  // namespace farfield::detail
