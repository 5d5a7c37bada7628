// Which triangles hold a sample at all? Far away almost none does, and a triangle must then cost next to nothing:
// several are transformed, snapped and rejected at a step, before any setup. Where small ones are deposited instead,
// the same step computes what a deposit needs.
//
// The same source is compiled for vectors of one, four and eight lanes (simd.hpp); all widths compute the same bits.
#pragma once

#include "farfield/settings.hpp"

#include <cstdint>

#include "farfield/raster/sample_projection.hpp"
#include "farfield/raster/snapping.hpp"
#include "farfield/raster/triangles/triangle_stream.hpp"
#include "farfield/simd.hpp"

namespace farfield::detail {

/// A triangle is small, and may be deposited, if its bounding box is smaller than this many samples on both axes.
inline constexpr float deposited_below = 2.0f;

/// Corners are valid for lanes in TriageMasks::draw: in 1/256 sample relative to the center sample, not yet snapped.
/// Centroid and area are valid for lanes in TriageMasks::small: in samples relative to the center sample, and in
/// squared samples, above 0.
struct TriagedBlock {
    float x[3][TriangleBlock::lanes];
    float y[3][TriangleBlock::lanes];
    float q[3][TriangleBlock::lanes];
    float center_x[TriangleBlock::lanes];
    float center_y[TriangleBlock::lanes];
    float center_q[TriangleBlock::lanes];
    float area[TriangleBlock::lanes];
};

/// Each mask has one bit a lane.
struct TriageMasks {
    unsigned draw;        ///< may hold a sample of the image
    unsigned clip;        ///< crosses the near plane or the far one, or leaves the guard band: see polygon_clip.hpp
    unsigned small_ones;  ///< to be deposited: has an area and touches the image. 0 where nothing is deposited
    unsigned front;       ///< for small ones: seen from their front
};

/// How a view measures depth: see SampleProjection.
enum class Depths : std::uint8_t { from_eye, from_anchor, parallel };

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

}  // namespace farfield::detail
