// Draws an image that was kept as a rectangle in space (Shade et al. 1996, section 2).
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>

#include "farfield/drawables.hpp"
#include "farfield/geometry/rgba8.hpp"
#include "farfield/raster/far_field/far_samples.hpp"
#include "farfield/raster/sample_projection.hpp"
#include "farfield/raster/samples/kept_image.hpp"
#include "farfield/raster/samples/sample_blocks.hpp"
#include "farfield/raster/samples/sample_buffers.hpp"

namespace farfield::detail {

/// Four bytes mixed at once: (256 - part) of a and `part` of b.
inline std::uint32_t mixed_bytes(std::uint32_t a, std::uint32_t b, std::uint32_t part) {
    constexpr std::uint32_t even = 0x00ff00ff;
    const std::uint32_t rest = 256 - part;
    const std::uint32_t low = ((a & even) * rest + (b & even) * part + 0x00800080) >> 8 & even;
    const std::uint32_t high = ((a >> 8 & even) * rest + (b >> 8 & even) * part + 0x00800080) & ~even;
    return low | high;
}

/// Something premultiplied that is to be opaque; alpha above 0.
inline Rgba8 made_opaque(Rgba8 c) {
    static constexpr std::array<std::uint32_t, 256> factors = [] {
        std::array<std::uint32_t, 256> f{};
        for (std::uint32_t a = 1; a < 256; ++a) f[a] = ((255u << 16) + a / 2) / a;
        return f;
    }();
    const std::uint32_t factor = factors[c.a];
    const auto channel = [&](std::uint8_t v) {
        return std::uint8_t(std::min<std::uint32_t>((v * factor + 0x8000) >> 16, 255));
    };
    return {channel(c.r), channel(c.g), channel(c.b), 255};
}

/// Draws images into samples: opaque texels into the z-buffer, the others as deposits over it.
/// SampleBuffers::begin_far() must come before.
class ImageFill {
  public:
    ImageFill(const SampleProjection& projection, SampleBuffers& buffers)
        : projection_(projection), buffers_(buffers) {}

    void add(const ImageQuad& quad, const KeptImage& image) {
        if (image.width == 0 || !place(quad, image)) return;
        bias_ = depth_bias_of(projection_);
        constexpr int side = SampleBlocks::side;
        for (int y = y0_ & -side; y < y1_; y += side) {
            Corners corners;
            corners.left[0] = corner_at(x0_ & -side, y);
            corners.left[1] = corner_at(x0_ & -side, y + side);
            for (int x = x0_ & -side; x < x1_; x += side) {
                corners.right[0] = corner_at(x + side, y);
                corners.right[1] = corner_at(x + side, y + side);
                fill_block(image, corners, x, y);
                corners.left = corners.right;
            }
        }
        if (has_drawn_) buffers_.blocks().add_drawn(x0_, y0_, x1_, y1_);
        has_drawn_ = false;
    }

  private:
    /// A linear function of sample positions, relative to the upper left sample.
    struct Linear {
        double x = 0, y = 0, at_zero = 0;
    };

    /// Finds where the rectangle lies in the picture, and texels from samples. With X, Y before division and w, all
    /// linear in texels (u, v), M (u, v, 1) = w (x, y, 1); so M^-1 (x, y, 1) = (u, v, 1) / w, linear in samples.
    bool place(const ImageQuad& quad, const KeptImage& image) {
        const auto projected = [&](glm::vec3 p) { return glm::dvec3(projection_.project(p)); };
        const glm::dvec3 corner = projected(quad.corner);
        const glm::dvec3 across = (projected(quad.corner + quad.across) - corner) / double(image.whole_width);
        const glm::dvec3 down = (projected(quad.corner + quad.down) - corner) / double(image.whole_height);
        const double weight = double(projection_.depth_weight), bias = double(projection_.depth_bias);
        const auto column = [&](const glm::dvec3& d, double w) { return glm::dvec3(d.x, d.y, w); };
        const glm::dmat3 to_samples(column(across, across.z * weight), column(down, down.z * weight),
                                    column(corner, corner.z * weight + bias));
        const double determinant = glm::determinant(to_samples);
        if (!std::isfinite(determinant) || determinant == 0) return false;
        glm::dvec2 low(std::numeric_limits<double>::infinity()), high = -low;
        for (unsigned i = 0; i < 4; ++i) {
            const glm::dvec3 p = to_samples * glm::dvec3(image.left + ((i & 1) ? image.width : 0),
                                                         image.top + ((i & 2) ? image.height : 0), 1);
            if (!(p.z > 0)) return false;
            const glm::dvec2 at =
                (glm::dvec2(p) / p.z + glm::dvec2(projection_.offset_x, projection_.offset_y)) / 256.0;
            low = glm::min(low, at);
            high = glm::max(high, at);
        }
        const glm::dvec2 first(projection_.first_x, projection_.first_y);
        const glm::dvec2 end(projection_.end_x, projection_.end_y);
        low = glm::clamp(low - 1.0, first, end) - first;
        high = glm::clamp(high + 1.0, first, end) - first;
        x0_ = int(std::floor(low.x));
        y0_ = int(std::floor(low.y));
        x1_ = int(std::ceil(high.x));
        y1_ = int(std::ceil(high.y));
        if (x0_ >= x1_ || y0_ >= y1_) return false;
        const glm::dmat3 to_texels = glm::inverse(to_samples);
        const glm::dvec2 origin((first.x + 0.5) * 256 - double(projection_.offset_x),
                                (first.y + 0.5) * 256 - double(projection_.offset_y));
        const auto linear = [&](int row) {
            const double x = to_texels[0][row], y = to_texels[1][row];
            return Linear{x * 256, y * 256, x * origin.x + y * origin.y + to_texels[2][row]};
        };
        u_ = linear(0);
        v_ = linear(1);
        inverse_w_ = linear(2);
        // Texels count from the border's first, relative to their centers.
        first_u_ = 0.5f - float(image.left);
        first_v_ = 0.5f - float(image.top);
        depth_at_corner_ = corner.z;
        depth_across_ = across.z;
        depth_down_ = down.z;
        return true;
    }

    /// Where a sample lies in the image, in 1/65536 texels from the border's first, and the rectangle's depth there.
    struct Corner {
        std::int32_t u = 0, v = 0;
        float q = 0;
    };
    /// Where a block's first samples lie, and those of its neighbors to the right and below: between them all of it is
    /// as good as linear.
    struct Corners {
        std::array<Corner, 2> left, right;  ///< upper, lower

        bool are_inside_of(std::int32_t most) const {
            for (const Corner& c : {left[0], left[1], right[0], right[1]}) {
                if (std::max(std::abs(c.u), std::abs(c.v)) > most) return false;
            }
            return true;
        }
    };
    /// Part of a row of samples.
    struct Run {
        std::int32_t u, v, u_step, v_step;
        float q, q_step;
    };

    Corner corner_at(int x, int y) const {
        const auto linear = [&](const Linear& l) { return float(l.x * x + (l.y * y + l.at_zero)); };
        const float inverse_w = linear(inverse_w_), w = 1 / inverse_w;
        const float u = linear(u_) * w, v = linear(v_) * w;
        const float depth = float(depth_at_corner_) + float(depth_across_) * u + float(depth_down_) * v;
        const auto whole = [](float t) { return std::int32_t(std::floor(t * 65536 + 0.5f)); };
        constexpr float most = 2 * most_texels;
        return {whole(glm::clamp(u + first_u_, -most, most)), whole(glm::clamp(v + first_v_, -most, most)),
                projection_.q(depth, inverse_w)};
    }

    /// (x, y) is the block's first sample; not all of it lies in the picture.
    void fill_block(const KeptImage& image, const Corners& corners, int x, int y) {
        const auto [a, c] = corners.left;
        const auto [b, d] = corners.right;
        const auto [least_u, most_u] = std::minmax({a.u, b.u, c.u, d.u});
        const auto [least_v, most_v] = std::minmax({a.v, b.v, c.v, d.v});
        if (most_u < 0 || most_v < 0 || least_u >> 16 > image.width || least_v >> 16 > image.height) return;
        // Nothing is magnified or made smaller so much that a block spans more.
        if (!corners.are_inside_of(std::int32_t(most_texels) << 16)) return;
        SampleBlocks& blocks = buffers_.blocks();
        const std::size_t at = blocks.index(x >> SampleBlocks::log2_side, y >> SampleBlocks::log2_side);
        const float nearest = std::max(std::max(a.q, b.q), std::max(c.q, d.q));
        if (blocks.farthest(at) > at_relative(nearest, image.least_depth + 65535 * image.depth_step)) return;
        if (!holds_something(image, least_u >> 16, least_v >> 16, most_u >> 16, most_v >> 16)) return;
        const bool is_inside =
            least_u >= 0 && least_v >= 0 && (most_u + 128) >> 16 <= image.width && (most_v + 128) >> 16 <= image.height;
        constexpr int side = SampleBlocks::side;
        const int first = std::max(x, x0_), end = std::min(x + side, x1_), last_row = std::min(y + side, y1_);
        for (int row = std::max(y, y0_); row < last_row; ++row) {
            const int down = row - y;
            const std::int32_t u = a.u + (c.u - a.u) * down / side, v = a.v + (c.v - a.v) * down / side;
            const float q = a.q + (c.q - a.q) * (float(down) / side);
            Run run{u,
                    v,
                    (b.u + (d.u - b.u) * down / side - u) / side,
                    (b.v + (d.v - b.v) * down / side - v) / side,
                    q,
                    (b.q + (d.q - b.q) * (float(down) / side) - q) * (1.0f / side)};
            run.u += run.u_step * (first - x);
            run.v += run.v_step * (first - x);
            run.q += run.q_step * float(first - x);
            if (is_inside) {
                image.is_solid ? fill_run<true, true>(image, run, at, first, end, row)
                               : fill_run<true, false>(image, run, at, first, end, row);
            } else {
                image.is_solid ? fill_run<false, true>(image, run, at, first, end, row)
                               : fill_run<false, false>(image, run, at, first, end, row);
            }
        }
    }

    float at_relative(float quad_q, float relative) const {
        return projection_.is_perspective ? (quad_q + bias_) * relative - bias_ : quad_q + relative;
    }

    /// Whether texels of a rectangle, ends and their neighbors to the right and below included, may hold something.
    static bool holds_something(const KeptImage& image, int left, int top, int right, int bottom) {
        const int last_column = std::min(right + 1, image.width + 1) >> KeptImage::log2_tile;
        const int last_row = std::min(bottom + 1, image.height + 1) >> KeptImage::log2_tile;
        for (int row = std::max(top, 0) >> KeptImage::log2_tile; row <= last_row; ++row) {
            for (int column = std::max(left, 0) >> KeptImage::log2_tile; column <= last_column; ++column) {
                if (image.tiles[std::size_t(row) * image.tile_columns() + std::size_t(column)] != 0) return true;
            }
        }
        return false;
    }

    /// Samples [first, end) of a row of a block.
    template <bool is_inside, bool is_solid>
    void fill_run(const KeptImage& image, const Run& run, std::size_t at, int first, int end, int y) {
        constexpr int side = SampleBlocks::side;
        constexpr float nothing = -std::numeric_limits<float>::infinity();
        static constexpr float undrawn[side] = {nothing, nothing, nothing, nothing, nothing, nothing, nothing, nothing};
        SampleBlocks& blocks = buffers_.blocks();
        const int block_x = first & -side;
        const std::size_t row_in_block = std::size_t(y & (side - 1)) * side;
        SampleBlocks::Samples* samples = nullptr;
        const auto open = [&] {
            samples = &blocks.opened(at, first >> SampleBlocks::log2_side, y >> SampleBlocks::log2_side);
            return samples->depth + row_in_block;
        };
        // Depths of the row; a block that nothing has been drawn into is opened only for something opaque.
        const float* depths = blocks.is_drawn(blocks.block(at)) ? open() : undrawn;
        std::optional<FarSamples::Eight> deposits;
        float nearest = nothing;
        const std::size_t stride = image.stride();
        std::int32_t u = run.u + 128, v = run.v + 128;  // rounded to 1/256
        float quad_q = run.q;
        for (int x = first; x < end; ++x, u += run.u_step, v += run.v_step, quad_q += run.q_step) {
            const int column = u >> 16, row = v >> 16;
            if (!is_inside && (column < 0 || row < 0 || column > image.width || row > image.height)) continue;
            const std::size_t texel = std::size_t(row) * stride + std::size_t(column);
            std::uint32_t upper[2], lower[2];
            __builtin_memcpy(upper, image.color.data() + texel, sizeof upper);
            __builtin_memcpy(lower, image.color.data() + texel + stride, sizeof lower);
            if ((upper[0] | upper[1] | lower[0] | lower[1]) == 0) continue;
            const auto u_part = std::uint32_t(u >> 8 & 255), v_part = std::uint32_t(v >> 8 & 255);
            const std::size_t nearest_texel = texel + (u_part >= 128 ? 1 : 0) + (v_part >= 128 ? stride : 0);
            const float q =
                at_relative(quad_q, image.least_depth + image.depth_step * float(image.depth[nearest_texel]));
            const auto i = unsigned(x - block_x);
            if (!(q > depths[i])) continue;
            auto color = std::bit_cast<Rgba8>(
                mixed_bytes(mixed_bytes(upper[0], upper[1], u_part), mixed_bytes(lower[0], lower[1], u_part), v_part));
            if (is_solid) {
                if (color.a < 128) continue;
                if (color.a < 255) color = made_opaque(color);
            } else if (color.a == 0) {
                continue;
            } else if (color.a < 255) {
                if (!deposits) deposits.emplace(buffers_.eight_deposits(block_x, y));
                deposits->deposit(i, q, color);
                continue;
            }
            if (samples == nullptr) depths = open();
            samples->depth[row_in_block + i] = q;
            samples->color[row_in_block + i] = color;
            nearest = std::max(nearest, q);
        }
        if (nearest == nothing) return;
        blocks.filled(at, nearest);
        has_drawn_ = true;
    }

    const SampleProjection& projection_;
    SampleBuffers& buffers_;
    Linear u_, v_, inverse_w_;
    double depth_at_corner_ = 0, depth_across_ = 0, depth_down_ = 0;
    float bias_ = 0, first_u_ = 0, first_v_ = 0;
    static constexpr float most_texels = 16000;
    int x0_ = 0, y0_ = 0, x1_ = 0, y1_ = 0;  ///< relative to the upper left sample
    bool has_drawn_ = false;
};

}  // namespace farfield::detail
