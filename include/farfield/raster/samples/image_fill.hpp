// Draws an image that was kept as a rectangle in space (Shade et al. 1996, section 2).
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>

#include "farfield/drawables.hpp"
#include "farfield/raster/sample_projection.hpp"
#include "farfield/raster/samples/image_block_fill.hpp"
#include "farfield/raster/samples/kept_image.hpp"
#include "farfield/raster/samples/sample_blocks.hpp"
#include "farfield/raster/samples/sample_buffers.hpp"

namespace farfield::detail {

/// Draws images into samples: opaque texels into the z-buffer, the others as deposits over it.
/// SampleBuffers::begin_far() must come before.
class ImageFill {
  public:
    ImageFill(const SampleProjection& projection, SampleBuffers& buffers, ImageBlockFill fill)
        : projection_(projection), buffers_(buffers), fill_(fill) {}

    void add(const ImageQuad& quad, const KeptImage& image) {
        if (image.width == 0 || !place(quad, image)) return;
        bias_ = depth_bias_of(projection_);
        first_part_ = int(std::lround(quad.first_part * 64));
        end_part_ = int(std::lround(quad.end_part * 64));
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

    /// Where a block's first samples lie, and those of its neighbors to the right and below: between them all of it is
    /// as good as linear.
    struct Corners {
        std::array<ImageCorner, 2> left, right;  ///< upper, lower

        bool are_inside_of(std::int32_t most) const {
            for (const ImageCorner& c : {left[0], left[1], right[0], right[1]}) {
                if (std::max(std::abs(c.u), std::abs(c.v)) > most) return false;
            }
            return true;
        }
    };
    ImageCorner corner_at(int x, int y) const {
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
        constexpr std::int32_t most_apart = 4096 << 16;
        if (most_u - least_u > most_apart || most_v - least_v > most_apart) return;
        SampleBlocks& blocks = buffers_.blocks();
        const std::size_t at = blocks.index(x >> SampleBlocks::log2_side, y >> SampleBlocks::log2_side);
        const float nearest = std::max(std::max(a.q, b.q), std::max(c.q, d.q));
        if (blocks.farthest(at) > at_relative(nearest, image.least_depth + 65535 * image.depth_step)) return;
        if (!holds_something(image, least_u >> 16, least_v >> 16, most_u >> 16, most_v >> 16)) return;
        const bool is_inside =
            least_u >= 0 && least_v >= 0 && (most_u + 128) >> 16 <= image.width && (most_v + 128) >> 16 <= image.height;
        constexpr int side = SampleBlocks::side;
        const ImageInBlock in{.left = {a, c},
                              .right = {b, d},
                              .x = x,
                              .y = y,
                              .first = std::max(x0_ - x, 0),
                              .end = std::min(x1_ - x, side),
                              .first_row = std::max(y0_ - y, 0),
                              .last_row = std::min(y1_ - y, side) - 1,
                              .is_inside = is_inside,
                              .is_quotient = projection_.is_perspective,
                              .bias = bias_,
                              .first_part = first_part_,
                              .end_part = end_part_,
                              .whole_x = x + projection_.first_x - projection_.left,
                              .whole_y = y + projection_.first_y - projection_.top};
        has_drawn_ = fill_(buffers_, image, in) || has_drawn_;
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

    const SampleProjection& projection_;
    SampleBuffers& buffers_;
    ImageBlockFill fill_;
    Linear u_, v_, inverse_w_;
    double depth_at_corner_ = 0, depth_across_ = 0, depth_down_ = 0;
    float bias_ = 0, first_u_ = 0, first_v_ = 0;
    static constexpr float most_texels = 16000;
    int x0_ = 0, y0_ = 0, x1_ = 0, y1_ = 0;  ///< relative to the upper left sample
    int first_part_ = 0, end_part_ = 64;
    bool has_drawn_ = false;
};

}  // namespace farfield::detail
