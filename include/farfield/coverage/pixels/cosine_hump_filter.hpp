// Convolves coverage masks with a cosine hump of one pixel radius, by tables: "kernel coefficients are precomputed
// for all byte patterns and accessed by table lookup for each non-zero byte within a polygon's coverage mask at a
// pixel" (Greene 1996, sections 4.4 and 9; G. Abram, L. Westover, T. Whitted, "Efficient Alias-Free Rendering Using
// Bit-masks and Look-up Tables", SIGGRAPH 1985).
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "farfield/coverage/pixels/cosine_hump.hpp"
#include "farfield/geometry/rgba8.hpp"
#include "farfield/image.hpp"

namespace farfield {

/// In a frame, every sample of every pixel must come exactly once, in any order. At the border, weights are normalized
/// to the samples inside the image, so an image of one color is that color everywhere. Jittered samples weigh as if
/// they were at their regular places.
class CosineHumpFilter {
  public:
    static constexpr int block_side_px = 8;
    static constexpr int reach_px = 1;
    static constexpr bool has_blocks = false;

    /// Begins a frame; clears 16 bytes a pixel.
    void begin(int width_px, int height_px) {
        width_ = width_px;
        height_ = height_px;
        stride_ = std::size_t(width_px) + 2;
        sums_.assign(stride_ * (std::size_t(height_px) + 2), {});
    }

    /// Adds some samples of a pixel, as bits 8 * row + column.
    void add(int x, int y, std::uint64_t samples, Rgba8 premultiplied, bool /*first*/) {
        convolve(x, y, samples, sum_of(premultiplied));
    }
    /// Adds all samples of a rectangle of pixels, which is cut off at the right and the lower border.
    void fill(int x, int y, int width_px, int height_px, Rgba8 premultiplied) {
        const int columns = std::min(width_px, width_ - x), rows = std::min(height_px, height_ - y);
        if (columns <= 0 || rows <= 0) return;
        const auto& weight = detail::cosine_hump.of_pixels;
        const Sum color = sum_of(premultiplied);
        for (int j = -1; j <= rows; ++j) {
            const unsigned r = around(j, rows);
            Sum* sums = sum_at(x, y + j);
            for (const int i : {-1, 0}) accumulate(sums[i], color, weight[around(i, columns)][r]);
            Sum inner{};
            accumulate(inner, color, weight[7][r]);
            if (r == 7) {
                std::fill(sums + 1, sums + std::max(columns - 1, 1), inner);  // nothing else reaches these
            } else {
                for (int i = 1; i < columns - 1; ++i) accumulate(sums[i], inner, 1);
            }
            for (int i = std::max(columns - 1, 1); i <= columns; ++i) {
                accumulate(sums[i], color, weight[around(i, columns)][r]);
            }
        }
    }
    /// Adds all samples of some pixels, as bits 8 * row + column, of the block that has (x, y) at its upper left. Those
    /// beyond the image are ignored.
    void fill_pixels(int x, int y, std::uint64_t pixels, Rgba8 premultiplied) {
        if (pixels == ~std::uint64_t(0)) return fill(x, y, block_side_px, block_side_px, premultiplied);
        const int columns = std::min(block_side_px, width_ - x), rows = std::min(block_side_px, height_ - y);
        pixels &= ((1u << columns) - 1) * 0x0101010101010101u & ~std::uint64_t(0) >> (64 - 8 * rows);
        const auto& weight = detail::cosine_hump.of_pixels;
        const Sum color = sum_of(premultiplied);
        unsigned above = 0, own = 0;  // bit 2 is the first pixel of the row
        for (int j = -1; j <= rows; ++j) {
            const unsigned below = j < 7 ? unsigned(pixels >> 8 * (j + 1) & 255) << 2 : 0;
            if ((above | own | below) != 0) {
                Sum* sums = sum_at(x, y + j);
                for (int i = -1; i <= columns; ++i) {
                    const auto at = [&](unsigned row) { return row >> (i + 1) & 7; };
                    accumulate(sums[i], color, weight[at(above)][1] + weight[at(own)][2] + weight[at(below)][4]);
                }
            }
            above = own;
            own = below;
        }
    }

    /// Writes every pixel, rounded to nearest; may be repeated in a frame.
    void resolve(Image& image) const {
        if (image.width() != width_ || image.height() != height_) image = Image(width_, height_);
        Rgba8* out = image.pixels().data();
        for (int y = 0; y < height_; ++y, out += width_) {
            const unsigned r = around(y, height_);
            const Sum* sums = &sums_[(std::size_t(y) + 1) * stride_ + 1];
            const auto scale = [&](int x) { return 1 / detail::cosine_hump.of_pixels[around(x, width_)][r]; };
            const float inner = scale(1);
            int x = 0;
            for (; x < std::min(width_, 1); ++x) resolve_pixels<1>(sums + x, scale(x), out + x);
            for (; x + 5 <= width_; x += 4) resolve_pixels<4>(sums + x, inner, out + x);
            for (; x < width_; ++x) resolve_pixels<1>(sums + x, scale(x), out + x);
        }
    }

  private:
    using Sum = std::array<float, 4>;

    void convolve(int x, int y, std::uint64_t samples, const Sum& color) {
        detail::CosineHump::Weights upper, lower;
        for (unsigned j = 0; j < 4; ++j) {
            const auto& row = detail::cosine_hump.rows[j];
            const auto &from_top = row[samples >> 8 * j & 255], &from_bottom = row[samples >> (56 - 8 * j) & 255];
            for (int k = 0; k < 8; ++k) {
                upper.of[k] = std::uint16_t(upper.of[k] + from_top.of[k]);
                lower.of[k] = std::uint16_t(lower.of[k] + from_bottom.of[k]);
            }
        }
        Sum *own = sum_at(x, y), *above = own - stride_, *below = own + stride_;
        for (int k = 0; k < 3; ++k) {
            accumulate(above[k - 1], color, float(upper.of[k + 3]));
            accumulate(own[k - 1], color, float(upper.of[k] + lower.of[k]));
            accumulate(below[k - 1], color, float(lower.of[k + 3]));
        }
    }
    static Sum sum_of(Rgba8 c) { return {float(c.r), float(c.g), float(c.b), float(c.a)}; }
    static void accumulate(Sum& sum, const Sum& color, float weight) {
        for (unsigned i = 0; i < 4; ++i) sum[i] += color[i] * weight;
    }
    /// Which of i - 1, i and i + 1 are among 0 ... n - 1, as bits 0, 1 and 2.
    static unsigned around(int i, int n) {
        return unsigned(i > 0 && i <= n) | unsigned(i >= 0 && i < n) << 1 | unsigned(i + 1 < n) << 2;
    }
    Sum* sum_at(int x, int y) { return sums_.data() + std::size_t(y + 1) * stride_ + std::size_t(x + 1); }

    template <std::size_t n>
    static void resolve_pixels(const Sum* sums, float scale, Rgba8* out) {
        float sum[n * 4];
        std::uint8_t bytes[n * 4];
        std::memcpy(sum, sums, sizeof sum);
        for (std::size_t i = 0; i < n * 4; ++i) bytes[i] = std::uint8_t(int(sum[i] * scale + 0.5f));
        std::memcpy(static_cast<void*>(out), bytes, sizeof bytes);
    }

    int width_ = 0, height_ = 0;
    std::size_t stride_ = 0;
    std::vector<Sum> sums_;  ///< with one more pixel on each side, outside the image, which is not read
};

}  // namespace farfield
