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
#include <cstddef>
#include <cstdint>
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
#include "farfield/simd.hpp"

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

/// Where keep_image() works, kept from call to call.
struct KeepingScratch {
    std::vector<float> relative, samples;
};

/// Four texels at once, on any machine.
struct FourTexels {
    typedef float Floats __attribute__((vector_size(16)));
    typedef std::int32_t Ints __attribute__((vector_size(16)));
    typedef std::uint32_t Words __attribute__((vector_size(16)));
    static constexpr std::size_t count = 4;

    template <class V, class T>
    FARFIELD_INLINE static V load(const T* from) {
        V v;
        __builtin_memcpy(&v, from, sizeof v);
        return v;
    }
    template <class T, class V>
    FARFIELD_INLINE static void store(T* to, const V& v) {
        __builtin_memcpy(static_cast<void*>(to), &v, sizeof v);
    }
    FARFIELD_INLINE static bool any(Ints where) {
        std::uint64_t halves[2];
        __builtin_memcpy(halves, &where, sizeof halves);
        return (halves[0] | halves[1]) != 0;
    }
    /// Of numbers, infinities and NaN left out.
    FARFIELD_INLINE static Ints are_finite(Floats v) { return v - v == Floats{}; }
};

/// Fills texels and tiles of a rectangle whose place and size are known, and gives each texel's depth in
/// `relative`, NaN where there is none: row by row, as texels are, and nothing before and behind them.
class TexelReader : FourTexels {
  public:
    TexelReader(const SampleProjection& projection, float quad_depth, const DepthRange& range)
        : range_(range),
          bias_(depth_bias_of(projection)),
          quad_(projection.q(quad_depth, projection.inverse_w(quad_depth))),
          by_quotient_(projection.is_perspective) {}

    float neutral() const { return by_quotient_ ? 1.0f : 0.0f; }

    /// The least and the largest of depths, with what has none at the rectangle's.
    DepthRange read(KeptImage& kept, const SampleBuffers& buffers, const Image& colors, KeepingScratch& scratch) {
        const std::size_t stride = kept.stride(), before = before_first(kept);
        scratch.relative.assign(before + kept.color.size() + before, std::numeric_limits<float>::quiet_NaN());
        Floats least = Floats{} + neutral(), most = least;
        Ints translucent{};
        for (int y = 0; y < kept.height; ++y) {
            // Vectors may reach into the next row's border, where nothing is yet.
            const std::size_t row = std::size_t(y + 1) * stride;
            Rgba8* const color = kept.color.data() + row;
            float* const depth = scratch.relative.data() + before + row;
            std::copy_n(
                &colors.pixels()[std::size_t(kept.top + y) * std::size_t(colors.width()) + std::size_t(kept.left)],
                kept.width, color + 1);
            buffers.mean_depths(kept.top + y, kept.left, kept.left + kept.width, depth + 1, scratch.samples);
            std::uint8_t* const tiles = kept.tiles.data() + std::size_t(y + 1) / KeptImage::tile * kept.tile_columns();
            for (std::size_t x = 0; x < stride; x += count) {
                const Words c = load<Words>(color + x);
                const Floats q = load<Floats>(depth + x);
                const Ints within = (q >= range_.farthest) & (q <= range_.nearest);
                const Ints shown = (c >= 1u << 24) & (within | ~are_finite(q));
                const Floats relative = by_quotient_ ? (q + bias_) / (quad_ + bias_) : q - quad_;
                const Ints known = shown & are_finite(relative);
                store(color + x, c & reinterpret_cast<Words>(shown));
                store(depth + x, known ? relative : Floats{} + std::numeric_limits<float>::quiet_NaN());
                const Floats low = known ? relative : least, high = known ? relative : most;
                least = low < least ? low : least;
                most = high > most ? high : most;
                translucent |= shown & (c < 255u << 24);
                if (any(shown)) tiles[x / KeptImage::tile] = 1;
            }
        }
        kept.is_solid = !any(translucent);
        DepthRange all{least[0], most[0]};
        for (std::size_t i = 1; i < count; ++i) {
            all.farthest = std::min(all.farthest, least[i]);
            all.nearest = std::max(all.nearest, most[i]);
        }
        return all;
    }

    /// Depths in steps from the least to the most. Between texels the nearest one's depth is taken, so those at a
    /// silhouette's edge have their neighbor's.
    void quantize(KeptImage& kept, const DepthRange& all, const KeepingScratch& scratch) const {
        const float least = all.farthest, steps = all.nearest > least ? 65535 / (all.nearest - least) : 0;
        const std::size_t stride = kept.stride(), texels = kept.depth.size();
        const float* const first = scratch.relative.data() + before_first(kept);
        for (std::size_t i = 0; i < texels; i += count) {
            const float* const at = first + i;
            Floats depth = Floats{} + neutral();
            const auto take = [&](const float* neighbor) {
                const Floats d = load<Floats>(neighbor);
                depth = d == d ? d : depth;
            };
            take(at + 1);
            take(at - 1);
            take(at + stride);
            take(at - stride);
            take(at);
            const Ints step = __builtin_convertvector((depth - least) * steps + 0.5f, Ints);
            std::uint16_t out[count];
            for (std::size_t k = 0; k < count; ++k) out[k] = std::uint16_t(step[k]);
            std::copy_n(out, std::min(count, texels - i), kept.depth.data() + i);
        }
    }

  private:
    static std::size_t before_first(const KeptImage& kept) { return kept.stride() + count; }

    DepthRange range_;
    float bias_, quad_;
    bool by_quotient_;
};

/// Takes an image of the size that `projection` has from what was drawn. `colors` is its picture, at least as large;
/// the rectangle lies at `quad_depth` from the projection's anchor, and holds nothing outside of a range of depths.
inline void keep_image(KeptImage& kept, const SampleBuffers& buffers, const Image& colors,
                       const SampleProjection& projection, float quad_depth, const DepthRange& range,
                       KeepingScratch& scratch) {
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
    const std::size_t texels = kept.stride() * (std::size_t(kept.height) + 2);
    kept.color.assign(texels, {0, 0, 0, 0});
    kept.depth.resize(texels);
    kept.tiles.assign(kept.tile_columns() * ((std::size_t(kept.height) + 1 + KeptImage::tile) / KeptImage::tile), 0);
    TexelReader reader(projection, quad_depth, range);
    const DepthRange depths = reader.read(kept, buffers, colors, scratch);
    kept.least_depth = depths.farthest;
    kept.depth_step = (depths.nearest - depths.farthest) / 65535;
    reader.quantize(kept, depths, scratch);
}

}  // namespace farfield::detail
