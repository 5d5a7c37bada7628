// Writes rows of opaque samples, several at a step.
//
// The same source is compiled for vectors of four and eight lanes (simd.hpp); all widths compute the bits that
// DepthPlane and ColorPlane do, sample by sample.
#pragma once

#include "farfield/settings.hpp"

#include <bit>
#include <cstdint>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "farfield/geometry/rgba8.hpp"
#include "farfield/raster/scan_conversion.hpp"
#include "farfield/raster/shading.hpp"
#include "farfield/raster/simd.hpp"

namespace farfield::detail {

/// Evaluates DepthPlane::at along a row.
struct DepthOfRow {
    float row, by_x, base_x, lowest, highest;

    DepthOfRow(const SnappedTriangle& t, const DepthPlane& plane, int y)
        : row(plane.row(y)),
          by_x(plane.by_x),
          base_x((128.0f - float(t.x[0])) * (1.0f / 256)),
          lowest(plane.lowest),
          highest(plane.highest) {}
};

/// Evaluates ColorPlane::at along a row.
struct ColorsOfRow {
    /// A corner's share at px is (across - down (px - x)) inverse_area weight.
    struct Weight {
        float across, down, x, weight;
    };
    Weight weights[3];
    float inverse_area;
    glm::vec3 channels[4];  ///< each at the three corners

    ColorsOfRow(const ColorPlane& plane, const Rgba8 (&colors)[3], int y) : inverse_area(plane.inverse_area) {
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

#define FARFIELD_LANES 4
namespace rows_of_four {
#include "farfield/raster/triangles/sample_rows.inl"
}
#undef FARFIELD_LANES

#if defined(__x86_64__)
FARFIELD_BEGIN_EIGHT_LANES
#define FARFIELD_LANES 8
namespace rows_of_eight {
#include "farfield/raster/triangles/sample_rows.inl"
}
#undef FARFIELD_LANES
FARFIELD_END_LANES
#endif

/// Functions that write samples [begin, end) of a row, indexed with x. They read and write up to 8 samples beyond the
/// end, which keep their values. Null means sample by sample.
///
/// A function that returns false stopped at `begin` because a color there is not opaque: even if all corners of a
/// sliver are, the colors between them need not be.
struct SampleRows {
    /// Writes into a z-buffer: the nearer sample stays, of two at the same depth the larger color.
    void (*one_color)(float* depth, Rgba8* color, int begin, int end, const DepthOfRow& of, Rgba8 rgba) = nullptr;
    bool (*several_colors)(float* depth, Rgba8* color, int& begin, int end, const DepthOfRow& of,
                           const ColorsOfRow& colors) = nullptr;
    /// Overwrites whatever is there.
    bool (*painted_colors)(Rgba8* color, int& begin, int end, const ColorsOfRow& colors) = nullptr;

    explicit SampleRows(Simd simd) {
        const int lanes = lanes_for(simd);
        if (lanes < 4 || std::endian::native != std::endian::little) return;
        one_color = &rows_of_four::fill_one_color;
        several_colors = &rows_of_four::fill_several_colors;
        painted_colors = &rows_of_four::paint_several_colors;
#if defined(__x86_64__)
        if (lanes >= 8) {
            one_color = &rows_of_eight::fill_one_color;
            several_colors = &rows_of_eight::fill_several_colors;
            painted_colors = &rows_of_eight::paint_several_colors;
        }
#endif
    }

    /// Shorter rows are not worth a call.
    static constexpr int shortest = 6;
};

}  // namespace farfield::detail
