// The color that a covered sample gets, and whether a translucent triangle covers it.
#pragma once

#include "farfield/settings.hpp"

#include <bit>
#include <cstdint>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "farfield/geometry/rgba8.hpp"
#include "farfield/raster/sample_projection.hpp"
#include "farfield/raster/scan_conversion.hpp"

namespace farfield::detail {

/// A number that goes with a triangle wherever it lies in memory and whichever corner comes first.
inline std::uint32_t hash_of_triangle(glm::vec3 a, glm::vec3 b, glm::vec3 c) {
    const auto hash = [](glm::vec3 p) {
        std::uint32_t h = std::bit_cast<std::uint32_t>(p.x) * 0x9e3779b1u;
        h = (h ^ h >> 15 ^ std::bit_cast<std::uint32_t>(p.y)) * 0x85ebca77u;
        return (h ^ h >> 13 ^ std::bit_cast<std::uint32_t>(p.z)) * 0xc2b2ae3du;
    };
    return hash(a) + hash(b) + hash(c);
}

/// Turns alpha into coverage: a hash of triangle and sample decides, the same in every frame (after Wyman and McGuire
/// 2017, "Hashed alpha testing"). On average alpha / 256 of the samples are covered.
inline bool covered_by_hash(int x, int y, std::uint32_t triangle_hash, std::uint8_t alpha) {
    std::uint32_t h = std::uint32_t(x) * 0x9e3779b1u ^ std::uint32_t(y) * 0x85ebca77u ^ triangle_hash;
    h = (h ^ h >> 15) * 0x2c1b3c6du;
    h = (h ^ h >> 12) * 0x297a2d39u;
    return (h >> 24) < alpha;
}

/// Colors given at the corners, interpolated with perspective.
struct ColorPlane {
    const SnappedTriangle& t;
    float weights[3];  ///< at the corners
    float inverse_area;

    ColorPlane(const SnappedTriangle& triangle, std::int64_t doubled_area, ColorWeight weight)
        : t(triangle), inverse_area(1.0f / float(doubled_area)) {
        for (int i = 0; i < 3; ++i) weights[i] = weight(t.q[i]);
    }
    Rgba8 at(int x, int y, const Rgba8 (&colors)[3]) const {
        const float px = float(x) * 256 + 128, py = float(y) * 256 + 128;
        const auto part = [&](int a, int b) {
            return (float(t.x[b] - t.x[a]) * (py - float(t.y[a])) - float(t.y[b] - t.y[a]) * (px - float(t.x[a]))) *
                   inverse_area;
        };
        const float w1 = part(2, 0) * weights[1], w2 = part(0, 1) * weights[2], w0 = part(1, 2) * weights[0];
        return to_rgba8((to_vec4(colors[0]) * w0 + to_vec4(colors[1]) * w1 + to_vec4(colors[2]) * w2) *
                        (1 / (w0 + w1 + w2)));
    }
};

}  // namespace farfield::detail
