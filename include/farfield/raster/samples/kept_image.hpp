// An image of a part of the scene that a renderer keeps (Shade et al. 1996, section 2); image_fill.hpp draws it as a
// rectangle in space.
//
// Beyond the paper each texel remembers its depth, as G. Schaufler's nailboards do ("Nailboards: A Rendering Primitive
// for Image Caching in Dynamic Scenes", Eurographics Workshop on Rendering 1997). A rectangle at one depth cannot be
// tested against its neighbors: it reaches out of its cell, and what lies in another cell would be drawn before it or
// behind it at once. With depths, images go into the z-buffer as what they show would, in any order.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <vector>

#include "farfield/drawables.hpp"
#include "farfield/geometry/rgba8.hpp"
#include "farfield/image.hpp"
#include "farfield/raster/sample_projection.hpp"
#include "farfield/raster/sample_rect.hpp"
#include "farfield/raster/samples/sample_blocks.hpp"
#include "farfield/raster/samples/sample_buffers.hpp"
#include "farfield/raster/samples/sliced_buffers.hpp"

namespace farfield::detail {

/// Texels, row by row, inside a border of one transparent texel. Only the rectangle that holds something is kept.
///
/// A texel's depth is told relative to the rectangle's: in perspective as the quotient of inverse depths, which hardly
/// changes while the viewer moves as little as an image allows; in a parallel view as a difference.
struct KeptImage {
    int whole_width = 0, whole_height = 0;  ///< what ImageQuad lays out; 0: no image
    int left = 0, top = 0;                  ///< of the whole that is not kept
    int width = 0, height = 0;              ///< of what is kept, without the border
    std::vector<Rgba8> color;               ///< premultiplied
    std::vector<std::uint16_t> depth;
    float least_depth = 1, depth_step = 0;
    /// Texels are covered or not, none in part: then so is what lies between them, as a sample of geometry is. It is
    /// decided by half; blending all edges would cost more than the rest of the image.
    bool is_solid = true;
    std::vector<std::uint8_t> tiles;  ///< of 8 x 8 texels, the border counted: 0 where nothing is

    static constexpr int log2_tile = 3, tile = 1 << log2_tile;
    std::size_t tile_columns() const { return (stride() + tile - 1) / tile; }
    static constexpr std::size_t bytes_of(int width, int height) {
        const std::size_t columns = std::size_t(width) + 2, rows = std::size_t(height) + 2;
        return columns * rows * (sizeof(Rgba8) + sizeof(std::uint16_t)) +
               ((columns + tile - 1) / tile) * ((rows + tile - 1) / tile);
    }
    std::size_t stride() const { return std::size_t(width) + 2; }
};

/// What has to be added to q before it is proportional to the inverse depth from the eye.
inline float depth_bias_of(const SampleProjection& projection) {
    return projection.is_perspective ? -projection.q_of_depth : 0.0f;
}

/// The part of a rectangle of a picture that holds all of its pixels that are not transparent.
inline SampleRect tight(const Image& colors, const SampleRect& in) {
    SampleRect r;
    for (int y = in.y0; y < in.y1; ++y) {
        int x = in.x0, end = in.x1;
        while (x < end && colors.at(x, y).a == 0) ++x;
        while (end > x && colors.at(end - 1, y).a == 0) --end;
        if (x < end) r.add(x, y, end, y + 1);
    }
    return r;
}

/// Takes an image of the size that `projection` has from what was drawn. `colors` is its picture, at least as large;
/// the rectangle lies at `quad_depth` from the projection's anchor, and holds nothing outside of a range of depths.
/// `scratch` is kept from call to call.
inline void keep_image(KeptImage& kept, const SampleBuffers& buffers, const Image& colors,
                       const SampleProjection& projection, float quad_depth, const DepthRange& range,
                       std::vector<float>& scratch) {
    const int side = buffers.samples_a_side();
    kept.whole_width = projection.whole_width / side;
    kept.whole_height = projection.whole_height / side;
    SampleRect drawn = buffers.drawn_pixels();
    drawn.x1 = std::min(drawn.x1, kept.whole_width);
    drawn.y1 = std::min(drawn.y1, kept.whole_height);
    drawn = tight(colors, drawn);
    kept.left = drawn.x0;
    kept.top = drawn.y0;
    kept.width = drawn.is_empty() ? 0 : drawn.x1 - drawn.x0;
    kept.height = drawn.is_empty() ? 0 : drawn.y1 - drawn.y0;
    const std::size_t stride = kept.stride(), count = stride * (std::size_t(kept.height) + 2);
    kept.color.assign(count, {0, 0, 0, 0});
    kept.depth.resize(count);
    kept.tiles.assign(kept.tile_columns() * ((std::size_t(kept.height) + 1 + KeptImage::tile) / KeptImage::tile), 0);
    const float bias = depth_bias_of(projection), quad = projection.q(quad_depth, projection.inverse_w(quad_depth));
    const bool by_quotient = projection.is_perspective;
    const float neutral = by_quotient ? 1.0f : 0.0f;
    // NaN stands for a texel without depth.
    scratch.assign(count, std::numeric_limits<float>::quiet_NaN());
    float least = neutral, most = neutral;
    kept.is_solid = true;
    for (int y = 0; y < kept.height; ++y) {
        const std::size_t row = std::size_t(y + 1) * stride + 1;
        for (int x = 0; x < kept.width; ++x) {
            const Rgba8 c = colors.at(kept.left + x, kept.top + y);
            if (c.a == 0) continue;
            const float q = buffers.mean_depth(kept.left + x, kept.top + y);
            if (std::isfinite(q) && !range.contains(q)) continue;
            kept.color[row + std::size_t(x)] = c;
            kept.is_solid = kept.is_solid && c.a == 255;
            kept.tiles[std::size_t(y + 1) / KeptImage::tile * kept.tile_columns() +
                       std::size_t(x + 1) / KeptImage::tile] = 1;
            const float relative = by_quotient ? (q + bias) / (quad + bias) : q - quad;
            if (!std::isfinite(relative)) continue;
            scratch[row + std::size_t(x)] = relative;
            least = std::min(least, relative);
            most = std::max(most, relative);
        }
    }
    kept.least_depth = least;
    kept.depth_step = (most - least) / 65535;
    const float steps = most > least ? 65535 / (most - least) : 0;
    const auto at = [&](std::size_t i) { return std::uint16_t((scratch[i] - least) * steps + 0.5f); };
    const auto middle = std::uint16_t((neutral - least) * steps + 0.5f);
    for (std::size_t i = 0; i < count; ++i) {
        kept.depth[i] = middle;
        if (!std::isnan(scratch[i])) {
            kept.depth[i] = at(i);
            continue;
        }
        // Between texels the nearest one's depth is taken, so those at a silhouette's edge have their neighbor's.
        for (const std::size_t step : {std::size_t(1), stride}) {
            if (i + step < count && !std::isnan(scratch[i + step])) kept.depth[i] = at(i + step);
            if (i >= step && !std::isnan(scratch[i - step])) kept.depth[i] = at(i - step);
        }
    }
}

}  // namespace farfield::detail
