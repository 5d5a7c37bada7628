// Which triangles hold a sample at all? Far away nearly none does, and a triangle must then cost next to nothing: it is
// transformed, snapped and rejected many at a step, before any set-up. Where small ones are deposited instead, what a
// deposit takes is made in the same step.
//
// The same source is compiled for vectors of one, four and eight lanes (simd.hpp); all widths compute the same bits.
#pragma once

#include <cstdint>

#include "farfield/raster/sample_projection.hpp"
#include "farfield/raster/simd.hpp"
#include "farfield/raster/snapping.hpp"
#include "farfield/raster/triangles/triangle_stream.hpp"

namespace farfield {

/// A triangle whose bounding box is smaller than this many samples on both axes is small: it may be deposited.
inline constexpr float deposited_below = 2.0f;

/// Valid for lanes in TriageMasks::draw: corners in 1/256 sample, relative to the center sample, to be snapped. For
/// lanes in TriageMasks::small: centroid in samples, relative likewise, and area in squared samples, above 0.
struct TriagedBlock {
    float x[3][TriangleBlock::lanes];
    float y[3][TriangleBlock::lanes];
    float q[3][TriangleBlock::lanes];
    float center_x[TriangleBlock::lanes];
    float center_y[TriangleBlock::lanes];
    float center_q[TriangleBlock::lanes];
    float area[TriangleBlock::lanes];
};

/// One bit a lane.
struct TriageMasks {
    unsigned draw;   ///< may hold a sample of the image
    unsigned clip;   ///< crosses the near plane or leaves the guard band: see polygon_clip.hpp
    unsigned small;  ///< to be deposited: has an area and touches the image. None where that is not asked for
    unsigned front;  ///< of the small: counter-clockwise on the screen
};

#define FARFIELD_LANES 1
namespace one_lane {
#include "farfield/raster/triangles/triangle_triage.inl"
}
#undef FARFIELD_LANES
#define FARFIELD_LANES 4
namespace four_lanes {
#include "farfield/raster/triangles/triangle_triage.inl"
}
#undef FARFIELD_LANES

#if defined(__x86_64__)
FARFIELD_BEGIN_EIGHT_LANES
#define FARFIELD_LANES 8
namespace eight_lanes {
#include "farfield/raster/triangles/triangle_triage.inl"
}
#undef FARFIELD_LANES
FARFIELD_END_LANES
#endif

using TriageFunction = TriageMasks (*)(const TriangleBlock&, const SampleProjection&, TriagedBlock&);

template <bool deposits>
TriageFunction triage_function(Simd simd) {
    const int lanes = lanes_for(simd);
#if defined(__x86_64__)
    if (lanes >= 8) return &eight_lanes::triage_any<deposits>;
#endif
    return lanes >= 4 ? &four_lanes::triage_any<deposits> : &one_lane::triage_any<deposits>;
}

}  // namespace farfield
