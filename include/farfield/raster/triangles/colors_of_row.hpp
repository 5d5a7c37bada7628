// ColorPlane::at along a row, set up for vectors.
#pragma once

#include "farfield/settings.hpp"

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "farfield/geometry/rgba8.hpp"
#include "farfield/raster/scan_conversion.hpp"
#include "farfield/raster/shading.hpp"

namespace farfield::detail {

/// Evaluates ColorPlane::at along a row.
struct ColorsOfRow {
    /// A corner's share at px is (across - down (px - x)) inverse_area weight.
    struct Weight {
        float across, down, x, weight;
    };
    Weight weights[3];
    float inverse_area;
    glm::vec3 channels[4];  ///< each at the three corners

    ColorsOfRow(const ColorPlane& plane, const Rgba8* colors, int y) : inverse_area(plane.inverse_area) {
        const SnappedTriangle& t = plane.t;
        const float py = float(y) * 256 + 128;
        for (int corner = 0; corner < 3; ++corner) {
            const int a = (corner + 1) % 3, b = (corner + 2) % 3;
            weights[corner] = {float(t.x[b] - t.x[a]) * (py - float(t.y[a])), float(t.y[b] - t.y[a]), float(t.x[a]),
                               plane.weights[corner]};
        }
        const glm::vec4 c[3] = {to_vec4(colors[0]), to_vec4(colors[1]), to_vec4(colors[2])};
        for (int channel = 0; channel < 4; ++channel) {
            channels[channel] = {c[0][channel], c[1][channel], c[2][channel]};
        }
    }
};

}  // namespace farfield::detail
