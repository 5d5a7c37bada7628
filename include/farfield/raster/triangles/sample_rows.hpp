// Paints rows of opaque samples, several at a step.
//
// The same source is compiled for vectors of four and eight lanes (simd.hpp); all widths compute the bits that
// ColorPlane does, sample by sample.
#pragma once

#include "farfield/settings.hpp"

#include <bit>
#include <cstdint>
#include <glm/vec3.hpp>

#include "farfield/geometry/rgba8.hpp"
#include "farfield/raster/triangles/colors_of_row.hpp"
#include "farfield/simd.hpp"

namespace farfield::detail {

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
    /// Overwrites whatever is there.
    bool (*painted_colors)(Rgba8* color, int& begin, int end, const ColorsOfRow& colors) = nullptr;

    explicit SampleRows(Simd simd) {
        const int lanes = lanes_for(simd);
        if (lanes < 4 || std::endian::native != std::endian::little) return;
        painted_colors = &rows_of_four::paint_several_colors;
#if defined(__x86_64__)
        if (lanes >= 8) {
            painted_colors = &rows_of_eight::paint_several_colors;
        }
#endif
    }

    /// Shorter rows are not worth a call.
    static constexpr int shortest = 6;
};

}  // namespace farfield::detail
