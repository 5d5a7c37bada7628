// What is seen of a polygon at a sample that lies on it: depth, color, and whether it is there at all.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <glm/vec3.hpp>
#include <utility>

#include "farfield/geometry/area_law.hpp"
#include "farfield/geometry/rgba8.hpp"
#include "farfield/raster/scan_conversion.hpp"
#include "farfield/raster/shading.hpp"

namespace farfield {

/// The first n samples of a random permutation of 64, for n of 0 to 64.
inline constexpr auto scattered_samples = [] {
    std::array<std::uint64_t, 65> masks{};
    std::array<unsigned, 64> order{};
    for (unsigned k = 0; k < 64; ++k) order[k] = k;
    std::uint32_t state = 1;
    for (unsigned k = 64; k > 1; --k) {
        state = state * 1664525u + 1013904223u;
        std::swap(order[k - 1], order[(state >> 16) % k]);
    }
    for (unsigned k = 0; k < 64; ++k) masks[k + 1] = masks[k] | std::uint64_t(1) << order[k];
    return masks;
}();

/// Samples are addressed relative to the image's center sample, as everywhere in raster/. Of several colors only
/// triangles come; of one, any convex polygon.
struct Surface {
    DepthPlane depth;
    SnappedTriangle triangle{};   ///< clockwise; what colors vary over
    std::array<Rgba8, 3> colors;  ///< all the same where it is flat
    std::uint32_t hash = 0;       ///< chooses samples where alpha is below 255
    bool is_flat = true;          ///< of one color
    bool is_solid = true;         ///< alpha is 255 everywhere: covers every sample that it lies on
    bool is_perspective = true;
    /// Part of the far field: alpha of colors[0] is the part of a pixel's samples to cover, their number is exact.
    bool is_fraction = false;
    /// Part of the far field that is deposited instead: covers nothing, takes this part of what comes from behind.
    bool is_deposit = false;
    Loss loss{};
    glm::vec3 far_rgb{0};        ///< in [0, 1], not premultiplied
    bool is_background = false;  ///< keeps its alpha, and covers whatever that is

    /// What a sample that shows the surface shows: alpha has chosen the samples, and is spent.
    Rgba8 seen_color() const { return seen(colors[0]); }  ///< where it is flat
    Rgba8 seen_color_at(int x, int y) const { return seen(color_at(x, y)); }
    /// One for the 8 x 8 samples of a pixel, the first of which is (x, y), as if the surface went on beyond its
    /// corners: "for each visible fragment, a single shading value is computed" (Greene 1996, section 2.2).
    Rgba8 seen_color_of_pixel(int x, int y) const { return seen(color_at(x + 4, y + 4)); }

    /// Of 8 x 8 samples those that a translucent surface covers: see covered_by_hash.
    std::uint64_t hashed_samples(int x, int y, bool shades_samples) const {
        if (is_fraction) return fraction_of_samples(x, y);
        std::uint64_t mask = 0;
        const Rgba8 one = color_at(x + 4, y + 4);
        for (unsigned k = 0; k < 64; ++k) {
            const int i = x + int(k % 8), j = y + int(k / 8);
            const Rgba8 c = shades_samples ? color_at(i, j) : one;
            if (c.a == 255 || covered_by_hash(i, j, hash, c.a)) mask |= std::uint64_t(1) << k;
        }
        return mask;
    }

  private:
    /// Of two cells over one another each covers its part of what the other leaves, on average: masks are turned by a
    /// hash of cell and pixel. The same in every frame.
    std::uint64_t fraction_of_samples(int x, int y) const {
        std::uint32_t h = std::uint32_t(x) * 0x9e3779b1u ^ std::uint32_t(y) * 0x85ebca77u ^ hash;
        h = (h ^ h >> 15) * 0x2c1b3c6du;
        h = (h ^ h >> 12) * 0x297a2d39u;
        h ^= h >> 15;
        const unsigned count = (unsigned(colors[0].a) * 64 + (h & 255)) / 255;
        const std::uint64_t mask = std::rotl(scattered_samples[std::min(count, 64u)], int(h >> 8 & 7) * 8);
        const unsigned turn = h >> 11 & 7;
        const std::uint64_t low = 0x0101010101010101u * ((1u << turn) - 1);
        return (mask << turn & ~low) | (mask >> ((8 - turn) & 7) & (turn == 0 ? 0 : low));
    }

    Rgba8 color_at(int x, int y) const {
        if (is_flat) return colors[0];
        const Rgba8 corners[3] = {colors[0], colors[1], colors[2]};
        return ColorPlane(triangle, triangle.doubled_area(), is_perspective).at(x, y, corners);
    }
    Rgba8 seen(Rgba8 c) const {
        if (!is_background) c.a = 255;
        return c;
    }
};

/// A convex polygon ready to be tiled, on the screen: clockwise, rows running downwards.
struct TilePolygon {
    /// A silhouette of a box has six, a quadrilateral cut by the near plane and the guard band nine and comes in parts.
    static constexpr int most_corners = 6;

    int corners = 0;
    std::array<std::int32_t, most_corners> x, y;  ///< 1/256 sample, relative to the center sample, below 2^22
    Surface surface{};
};

}  // namespace farfield
