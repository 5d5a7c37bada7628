// What a sample on a polygon sees of it: depth, color, and whether it is there at all.
#pragma once

#include "farfield/settings.hpp"

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>

#include "farfield/coverage/polygons/color_gradient.hpp"
#include "farfield/coverage/polygons/scattered_samples.hpp"
#include "farfield/geometry/area_law.hpp"
#include "farfield/geometry/rgba8.hpp"
#include "farfield/raster/scan_conversion.hpp"
#include "farfield/raster/shading.hpp"
#include "farfield/simd.hpp"

namespace farfield::detail {

/// A z-buffer takes a quadrilateral for two triangles, whose planes differ by rounding, or more where it is bent. It is
/// tiled at once, which takes half as long, with bounds of both planes; samples whose depth decides find their
/// triangle.
struct FoldedDepth {
    float thickness = 0;  ///< between the bounds of q; 0: there is one plane and no fold
    DepthPlane planes[2]{};
    std::int32_t from[2]{}, to[2]{};  ///< the fold, as an edge of the first plane's triangle

    /// 0 or more at samples that belong to the first plane, counted from (first_x, first_y).
    Edge<std::int64_t> edge(int first_x, int first_y) const {
        return Edge<std::int64_t>(from[0], from[1], to[0], to[1], first_x, first_y);
    }
};

}  // namespace farfield::detail

namespace farfield {

/// How a surface covers the samples that it lies on. Surface::covers_all() and covers_some() rely on the order.
enum class SurfaceKind : std::uint8_t {
    opaque,       ///< covers all; alpha is 255 everywhere
    background,   ///< covers all and keeps its alpha, whatever that is
    deposit,      ///< far field: covers none, but takes `loss` of what comes from behind
    fraction,     ///< far field: covers the part of a pixel's samples that alpha of colors[0] says
    translucent,  ///< covers the samples that a hash of sample and polygon chooses by alpha
};

/// Samples are addressed relative to the image's center sample, as everywhere in raster/.
struct Surface {
    detail::DepthPlane depth;            ///< no sample is nearer than it
    detail::FoldedDepth fold{};          ///< a quadrilateral's
    std::array<Rgba8, 4> colors;         ///< at corners; all the same where it is flat
    detail::SnappedTriangle triangle{};  ///< three corners where it is not flat, clockwise
    detail::ColorGradient gradient{};    ///< where it is not flat, once need_gradient() was called
    std::uint32_t hash = 0;              ///< chooses samples of a fraction and of a translucent surface
    SurfaceKind kind = SurfaceKind::opaque;
    bool is_flat = true;  ///< has one color
    bool has_gradient = false;
    detail::ColorWeight color_weight{};
    Loss loss{};           ///< a deposit's
    glm::vec3 far_rgb{0};  ///< a deposit's, in [0, 1], not premultiplied

    /// No sample is farther than this.
    FARFIELD_INLINE detail::DepthPlane farthest_depth() const {
        detail::DepthPlane plane = depth;
        plane.at_corner -= fold.thickness;
        return plane;
    }

    FARFIELD_INLINE bool covers_all() const { return kind <= SurfaceKind::background; }
    FARFIELD_INLINE bool covers_some() const { return kind >= SurfaceKind::fraction; }
    FARFIELD_INLINE bool is_deposit() const { return kind == SurfaceKind::deposit; }

    /// Call this before colors of a surface that is not flat are asked for.
    FARFIELD_INLINE void need_gradient() {
        if (is_flat || has_gradient) return;
        gradient = detail::ColorGradient(triangle, colors, color_weight);
        has_gradient = true;
    }

    /// The color of a sample that shows the surface: opaque, because alpha has already chosen the samples.
    FARFIELD_INLINE Rgba8 seen_color() const { return seen(colors[0]); }  ///< where it is flat
    Rgba8 seen_color_at(int x, int y) const { return seen(color_at(x, y)); }
    /// One color for the 8 x 8 samples of a pixel, the first of which is (x, y), as if the surface went on beyond its
    /// corners: "for each visible fragment, a single shading value is computed" (Greene 1996, section 2.2).
    FARFIELD_INLINE Rgba8 seen_color_of_pixel(int x, int y) const { return seen(color_of_pixel(x, y)); }

    /// The same for eight pixels in a row.
    FARFIELD_INLINE std::array<Rgba8, 8> seen_colors_of_pixels(int x, int y) const {
        auto eight = gradient.eight_pixels(float(x) + 4, float(y) + 4);
        for (Rgba8& c : eight) c = seen(c);
        return eight;
    }

    /// Those of 8 x 8 samples that a fraction or a translucent surface covers: see covered_by_hash.
    std::uint64_t hashed_samples(int x, int y, bool shades_samples) const {
        if (kind == SurfaceKind::fraction) return detail::scattered_samples(colors[0].a, hash, x, y);
        std::uint64_t mask = 0;
        const Rgba8 one = color_of_pixel(x, y);
        for (unsigned k = 0; k < 64; ++k) {
            const int i = x + int(k % 8), j = y + int(k / 8);
            const Rgba8 c = shades_samples ? color_at(i, j) : one;
            if (c.a == 255 || detail::covered_by_hash(i, j, hash, c.a)) mask |= std::uint64_t(1) << k;
        }
        return mask;
    }

  private:
    FARFIELD_INLINE Rgba8 color_of_pixel(int x, int y) const {
        return is_flat ? colors[0] : gradient.pixel(float(x) + 4, float(y) + 4);
    }
    Rgba8 color_at(int x, int y) const {
        if (is_flat) return colors[0];
        const Rgba8 corners[3] = {colors[0], colors[1], colors[2]};
        return detail::ColorPlane(triangle, triangle.doubled_area(), color_weight).at(x, y, corners);
    }
    FARFIELD_INLINE Rgba8 seen(Rgba8 c) const {
        if (kind != SurfaceKind::background && kind != SurfaceKind::deposit) c.a = 255;
        return c;
    }
};

}  // namespace farfield

namespace farfield::detail {

/// A convex polygon on the screen, ready to be tiled: clockwise, rows running downwards.
struct TilePolygon {
    /// A box's silhouette has six; a quadrilateral cut by the near plane and the guard band has nine and is split.
    static constexpr int most_corners = 6;

    int corners = 0;
    std::array<std::int32_t, most_corners> x, y;  ///< 1/256 sample, relative to the center sample, below 2^22
    Surface surface{};

    /// Takes a clockwise triangle. Depth is left to the caller, who may not need it.
    void set_triangle(const SnappedTriangle& t) {
        corners = 3;
        for (unsigned c = 0; c < 3; ++c) {
            x[c] = t.x[c];
            y[c] = t.y[c];
        }
    }
    /// Makes an upright rectangle that faces the view.
    void set_rectangle(std::int32_t left, std::int32_t top, std::int32_t right, std::int32_t bottom, float q) {
        corners = 4;
        x = {left, right, right, left};
        y = {top, top, bottom, bottom};
        surface.depth = DepthPlane(q, 0, 0, q, q);
    }
};

}  // namespace farfield::detail
