// Fills blocks of samples with a triangle, in vectors, with a depth test.
//
// The same source is compiled for vectors of one, four and eight lanes (simd.hpp); all widths compute the bits that
// DepthPlane and ColorPlane do, sample by sample.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <utility>

#include "farfield/geometry/rgba8.hpp"
#include "farfield/raster/sample_projection.hpp"
#include "farfield/raster/samples/sample_blocks.hpp"
#include "farfield/raster/scan_conversion.hpp"
#include "farfield/raster/shading.hpp"
#include "farfield/raster/triangles/colors_of_row.hpp"
#include "farfield/simd.hpp"

namespace farfield::detail {

/// What a kernel needs to know of a triangle's colors. Kernels are compiled apart from what shades, hence pointers to
/// functions; most triangles that are drawn at all call one of them once.
struct TriangleShade {
    void (*prepare)(TriangleShade&);                  ///< comes before anything below is called or looked at
    Rgba8 (*at)(const TriangleShade&, int x, int y);  ///< relative to the center sample; alpha 0: not covered
    const Rgba8* corners;
    const ColorPlane* plane;  ///< null if is_one_color
    bool is_one_color;        ///< that of the corners, opaque
    bool is_opaque;           ///< all corners are; between those of a sliver colors need not be
};

#define FARFIELD_LANES 1
namespace blocks_by_one {
#include "farfield/raster/samples/block_fill.inl"
}
#undef FARFIELD_LANES
#define FARFIELD_LANES 4
namespace blocks_by_four {
#include "farfield/raster/samples/block_fill.inl"
}
#undef FARFIELD_LANES

#if defined(__x86_64__)
FARFIELD_BEGIN_EIGHT_LANES
#define FARFIELD_LANES 8
namespace blocks_by_eight {
#include "farfield/raster/samples/block_fill.inl"
}
#undef FARFIELD_LANES
FARFIELD_END_LANES
#endif

/// The nearer sample stays; of two at the same depth the larger color stays, in whatever order they come. The triangle
/// must be clockwise on the screen.
using BlockFill = void (*)(SampleBlocks&, const SnappedTriangle&, std::int64_t doubled_area, const SampleProjection&,
                           TriangleShade&);

inline BlockFill block_fill(Simd simd) {
    const int lanes = lanes_for(simd);
#if defined(__x86_64__)
    if (lanes >= 8) return &blocks_by_eight::fill_blocks;
#endif
    return lanes >= 4 ? &blocks_by_four::fill_blocks : &blocks_by_one::fill_blocks;
}

}  // namespace farfield::detail
