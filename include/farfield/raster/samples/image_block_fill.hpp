// Fills a block of samples from an image that is kept, in vectors, with a depth test.
//
// The same source is compiled for vectors of one, four and eight lanes (simd.hpp); all widths compute the same bits.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>

#include "farfield/drawables.hpp"
#include "farfield/geometry/rgba8.hpp"
#include "farfield/raster/far_field/far_samples.hpp"
#include "farfield/raster/samples/kept_image.hpp"
#include "farfield/raster/samples/sample_blocks.hpp"
#include "farfield/raster/samples/sample_buffers.hpp"
#include "farfield/raster/triangles/colors_of_row.hpp"
#include "farfield/simd.hpp"

namespace farfield::detail {

/// Where a sample lies in an image, in 1/65536 texels from the border's first, and the rectangle's depth there.
struct ImageCorner {
    std::int32_t u = 0, v = 0;
    float q = 0;
};

/// A block of samples that an image is drawn into. Between where its first sample lies and where those of its neighbors
/// to the right and below do, all of it is as good as linear; no texel lies more than 4,096 from another.
struct ImageInBlock {
    ImageCorner left[2], right[2];      ///< upper, lower
    int x = 0, y = 0;                   ///< of the first sample
    int first = 0, end = 0;             ///< columns of the block that are filled
    int first_row = 0, last_row = 0;    ///< and rows, ends included
    bool is_inside = false;             ///< no sample lies beyond the border
    bool is_quotient = true;            ///< depths are: see KeptImage
    float bias = 0;                     ///< of q: see depth_bias_of()
    int first_part = 0, end_part = 64;  ///< samples whose fade_order() lies in between are filled
    int whole_x = 0, whole_y = 0;       ///< of the first sample in the whole picture
};

/// Of eight samples in a row from any first one on.
struct FadeOrders {
    static constexpr int side = SampleBlocks::side;
    std::int32_t row[side][2 * side];

    constexpr FadeOrders() : row() {
        for (int y = 0; y < side; ++y) {
            for (int x = 0; x < 2 * side; ++x) row[y][x] = fade_order(x, y);
        }
    }
};
inline constexpr FadeOrders fade_orders;

#define FARFIELD_LANES 1
namespace images_by_one {
#include "farfield/raster/samples/image_block_fill.inl"
}
#undef FARFIELD_LANES
#define FARFIELD_LANES 4
namespace images_by_four {
#include "farfield/raster/samples/image_block_fill.inl"
}
#undef FARFIELD_LANES

#if defined(__x86_64__)
FARFIELD_BEGIN_EIGHT_LANES
#define FARFIELD_LANES 8
namespace images_by_eight {
#include "farfield/raster/samples/image_block_fill.inl"
}
#undef FARFIELD_LANES
FARFIELD_END_LANES
#endif

/// Opaque texels go into the z-buffer where they are nearer, the others are deposited over it; begin_far() must come
/// before. Returns whether anything went into the z-buffer.
using ImageBlockFill = bool (*)(SampleBuffers&, const KeptImage&, const ImageInBlock&);

inline ImageBlockFill image_block_fill(Simd simd) {
    const int lanes = lanes_for(simd);
#if defined(__x86_64__)
    if (lanes >= 8) return &images_by_eight::fill_block;
#endif
    return lanes >= 4 ? &images_by_four::fill_block : &images_by_one::fill_block;
}

}  // namespace farfield::detail
