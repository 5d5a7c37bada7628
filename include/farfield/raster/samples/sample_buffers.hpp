// The buffers that a frame is drawn into: a z-buffer of geometry and, over it, the far field, sample by sample; and the
// picture made from them.
#pragma once

#include "farfield/settings.hpp"

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <utility>
#include <vector>

#include "farfield/geometry/rgba8.hpp"
#include "farfield/image.hpp"
#include "farfield/raster/far_field/far_samples.hpp"
#include "farfield/raster/made_for.hpp"
#include "farfield/raster/sample_projection.hpp"
#include "farfield/raster/sample_rect.hpp"
#include "farfield/raster/samples/box_mean.hpp"
#include "farfield/raster/samples/depth_tiles.hpp"
#include "farfield/raster/samples/sample_blocks.hpp"
#include "farfield/simd.hpp"

namespace farfield::detail {

/// Samples are addressed relative to the projection's center sample. Only what the last frame drew is cleared.
///
/// The picture is the deposited color plus transmittance times the z-buffer's color; where geometry drawn later lies in
/// front of the first deposit, it is the geometry's color alone.
class SampleBuffers {
  public:
    void begin(const SampleProjection& projection, int samples_a_side, Rgba8 background) {
        const int width = projection.end_x - projection.first_x, height = projection.end_y - projection.first_y;
        if (!made_for_({{width, height}, samples_a_side, background},
                       [&] { resize(width, height, samples_a_side, background); })) {
            clear();
        }
        first_x_ = projection.first_x;
        first_y_ = projection.first_y;
        blocks_.place(first_x_, first_y_);
        whole_x_ = float(first_x_ - projection.left);
        whole_y_ = float(first_y_ - projection.top);
        far_.place(projection.left, projection.top, projection.whole_width, projection.whole_height);
    }

    int samples_a_side() const { return side_; }
    /// The z-buffer and its colors, from the upper left sample.
    SampleBlocks& blocks() { return blocks_; }

    /// Call this before the first deposit of a frame.
    void begin_far() { far_.begin(); }
    bool has_far() const { return far_.has_begun(); }

    /// See FarSamples::deposit_row.
    template <class Depth>
    void deposit_row(int y, int begin, int end, Depth&& q, const FarSamples::Deposit& deposit) {
        far_.deposit_row(
            blocks_, y - first_y_, begin - first_x_, end - first_x_, [&](int x) { return q(x + first_x_); }, deposit);
    }
    /// See FarSamples::deposit_square.
    void deposit_square(float left, float top, float right, float bottom, float q, Loss loss, glm::vec3 rgb) {
        far_.deposit_square(blocks_, left - whole_x_, top - whole_y_, right - whole_x_, bottom - whole_y_, q, loss,
                            rgb);
    }

    /// See FarSamples::deposit_in_lane.
    template <class Color>
    void deposit_in_lane(float x, float y, float area, float q, Loss loss, Color&& rgb) {
        far_.deposit_in_lane(blocks_, x - whole_x_, y - whole_y_, area, q, loss, rgb);
    }

    /// A rectangle that holds all pixels drawn to, from the upper left one.
    SampleRect drawn_pixels() const {
        SampleRect r = blocks_.drawn();
        r.add(far_.rect());
        if (r.is_empty()) return {};
        return {r.x0 / side_, r.y0 / side_, (r.x1 - 1) / side_ + 1, (r.y1 - 1) / side_ + 1};
    }

    /// See FarSamples::Eight; coordinates from the upper left sample.
    FarSamples::Eight eight_deposits(int x, int y) { return far_.eight(x, y); }

    /// Gives, for pixels [begin, end) of a row, the mean depth, as q, of the samples that something covers: for each
    /// that of the nearest. -infinity: none is. `scratch` is kept from call to call.
    void mean_depths(int py, int begin, int end, float* out, std::vector<float>& scratch) const {
        const auto row_of_samples = [&](int y, int first, int last, float* to) {
            blocks_.depths(y, first, last, to);
            if (far_.has_begun()) far_.raise_to_first(y, first, last, to);
        };
        if (side_ == 1) return row_of_samples(py, begin, end, out);
        constexpr float nothing = -std::numeric_limits<float>::infinity();
        const int first = begin * side_, last = end * side_;
        const auto count = std::size_t(last - first);
        scratch.assign(3 * count, 0);
        float *const depths = scratch.data(), *const sums = depths + count, *const covered = sums + count;
        for (int y = py * side_; y < (py + 1) * side_; ++y) {
            row_of_samples(y, first, last, depths);
            for (std::size_t i = 0; i < count; ++i) {
                sums[i] += depths[i] > nothing ? depths[i] : 0.0f;
                covered[i] += depths[i] > nothing ? 1.0f : 0.0f;
            }
        }
        const auto side = std::size_t(side_);
        for (std::size_t i = 0; i < count; i += side) {
            float sum = 0, samples = 0;
            for (std::size_t x = i; x < i + side; ++x) {
                sum += sums[x];
                samples += covered[x];
            }
            *out++ = samples > 0 ? sum / samples : nothing;
        }
    }

    /// Whether nothing as far as q or farther can change any sample of a rectangle (ends included), because each has
    /// nearer geometry or is closed, by deposits of which the first is nearer. May err towards no; a rectangle without
    /// samples gives yes.
    bool all_settled(int x0, int y0, int x1, int y1, float q) {
        if (!clip(x0, y0, x1, y1)) return true;
        return tiles_.all_nearer(x0, y0, x1, y1, q, [&](int left, int top, int right, int bottom) {
            return farthest_settled(left, top, std::min(right, width_), std::min(bottom, height_), q);
        });
    }

    /// The same, looking at each sample: dearer, and does not ask for more than the rectangle.
    bool each_settled(int x0, int y0, int x1, int y1, float q) const {
        return !clip(x0, y0, x1, y1) || farthest_settled(x0, y0, x1 + 1, y1 + 1, q) > q;
    }

    /// Writes the mean of each pixel's samples, but only where they changed since the last resolve into the same image.
    void resolve(Image& image) {
        const int width = width_ / side_, height = height_ / side_;
        if (image.width() != width || image.height() != height) {
            image = Image(width, height, background_);
            drawn_in_image_ = {};
        }
        if (const SampleRect& was = drawn_in_image_; !was.is_empty()) {
            for (int y = was.y0 / side_; y <= (was.y1 - 1) / side_; ++y) {
                std::fill(&image.at(was.x0 / side_, y), &image.at((was.x1 - 1) / side_, y) + 1, background_);
            }
        }
        SampleRect drawn = blocks_.drawn();
        drawn.add(far_.rect());
        drawn_in_image_ = drawn;
        if (side_ == 1) {
            for (int y = drawn.y0; y < drawn.y1; ++y) blocks_.colors(y, drawn.x0, drawn.x1, &image.at(drawn.x0, y));
            far_.for_touched([&](int x, int y) { image.at(x, y) = rounded(color_at(x, y, image.at(x, y))); });
        } else if (SampleBlocks::side % side_ == 0) {
            for_pixels(drawn, [&](int x, int y) { image.at(x, y) = pixel_in_block(x, y); });
        } else if (!drawn.is_empty()) {
            const int first = drawn.x0 / side_, last = (drawn.x1 - 1) / side_;
            const auto stride = std::size_t((last - first + 1) * side_);
            for (int y = drawn.y0 / side_; y <= (drawn.y1 - 1) / side_; ++y) {
                for (int row = 0; row < side_; ++row) {
                    blocks_.colors(y * side_ + row, first * side_, (last + 1) * side_,
                                   rows_.data() + std::size_t(row) * stride);
                }
                for (int x = first; x <= last; ++x) {
                    const Rgba8* behind = rows_.data() + (x - first) * side_;
                    image.at(x, y) = far_.has_begun() && far_.is_touched(x * side_, y * side_, side_)
                                         ? pixel(behind, stride, x, y)
                                         : mean_of_samples(behind, stride, side_);
                }
            }
        }
    }

  private:
    typedef float Floats __attribute__((vector_size(16)));
    typedef std::uint8_t Bytes __attribute__((vector_size(4)));

    struct Kind {
        BufferSize size;
        int samples_a_side;
        Rgba8 background;
        friend bool operator==(const Kind&, const Kind&) = default;
    };

    template <class F>
    void for_pixels(const SampleRect& r, F&& f) const {
        if (r.is_empty()) return;
        for (int y = r.y0 / side_; y <= (r.y1 - 1) / side_; ++y) {
            for (int x = r.x0 / side_; x <= (r.x1 - 1) / side_; ++x) f(x, y);
        }
    }

    /// From the upper left sample; false where nothing of the rectangle is left.
    bool clip(int& x0, int& y0, int& x1, int& y1) const {
        x0 = std::max(x0 - first_x_, 0);
        y0 = std::max(y0 - first_y_, 0);
        x1 = std::min(x1 - first_x_, width_ - 1);
        y1 = std::min(y1 - first_y_, height_ - 1);
        return x0 <= x1 && y0 <= y1;
    }

    /// The least q in a rectangle, half open, behind which nothing changes a sample, or the first not larger than q.
    float farthest_settled(int left, int top, int right, int bottom, float q) const {
        float least = std::numeric_limits<float>::infinity();
        for (int y = top; y < bottom; ++y) {
            for (int x = left; x < right; ++x) {
                const float depth = far_.settled_behind(blocks_.depth(x, y), x, y);
                if (depth < least) {
                    least = depth;
                    if (!(least > q)) return least;
                }
            }
        }
        return least;
    }

    /// For pixels that lie in one block each.
    Rgba8 pixel_in_block(int px, int py) const {
        constexpr int side = SampleBlocks::side;
        static_assert(side == FarSamples::side);
        const int left = px * side_, top = py * side_;
        const std::size_t at = blocks_.index(left / side, top / side);
        const auto first = std::size_t(top % side * side + left % side);
        const SampleBlocks::Block& b = blocks_.block(at);
        const bool is_drawn = blocks_.is_drawn(b), is_flat = !is_drawn || b.is_surface;
        const Rgba8 flat = is_drawn ? b.color : background_;
        const SampleBlocks::Samples& samples = blocks_.samples(at);
        if (!far_.is_touched(left, top, side_)) {
            return is_flat ? flat : mean_of_samples(samples.color + first, side, side_);
        }
        const FarSamples::InBlock deposits = far_.block(at);
        const float nearest = is_drawn ? b.nearest : -std::numeric_limits<float>::infinity();
        Floats sum{};
        for (int y = 0; y < side_; ++y) {
            for (int x = 0; x < side_; ++x) {
                const std::size_t i = first + std::size_t(y * side + x);
                const Rgba8 behind = is_flat ? flat : samples.color[i];
                // Geometry may have come later, in front. None is nearer than the nearest.
                const bool is_over =
                    (deposits.touched >> i & 1) != 0 && (deposits.first_deposit[i] > nearest ||
                                                         deposits.first_deposit[i] > blocks_.depth(left + x, top + y));
                sum += is_over ? over(deposits.samples[i], behind) : in_255ths(behind);
            }
        }
        return rounded(sum * (1.0f / float(side_ * side_)));
    }

    /// With deposits over what lies behind, which comes in rows `stride` apart.
    Rgba8 pixel(const Rgba8* behind, std::size_t stride, int px, int py) const {
        Floats sum{};
        for (int y = 0; y < side_; ++y, behind += stride) {
            for (int x = 0; x < side_; ++x) sum += color_at(px * side_ + x, py * side_ + y, behind[x]);
        }
        return rounded(sum * (1.0f / float(side_ * side_)));
    }

    /// What a sample shows, in 255ths.
    FARFIELD_INLINE Floats color_at(int x, int y, Rgba8 behind) const {
        if (!far_.is_touched(x, y)) return in_255ths(behind);
        const FarSamples::Sample* s = far_.over(blocks_.depth(x, y), x, y);
        return s == nullptr ? in_255ths(behind) : over(*s, behind);
    }
    FARFIELD_INLINE static Floats in_255ths(Rgba8 color) {
        return __builtin_convertvector(std::bit_cast<Bytes>(color), Floats);
    }
    FARFIELD_INLINE static Floats over(const FarSamples::Sample& s, Rgba8 behind) {
        Floats deposited = std::bit_cast<Floats>(s);
        const Floats transmittance = Floats{} + deposited[3];
        deposited[3] = 1 - deposited[3];
        return deposited * 255.0f + in_255ths(behind) * transmittance;
    }
    static Rgba8 rounded(Floats v) {
        v += 0.5f;
#if defined(__SSE2__)
        const __m128i words = _mm_cvttps_epi32(_mm_min_ps(_mm_set1_ps(255), v)), pairs = _mm_packs_epi32(words, words);
        return std::bit_cast<Rgba8>(_mm_cvtsi128_si32(_mm_packus_epi16(pairs, pairs)));
#else
        const auto byte = [](float c) { return std::uint8_t(std::min(c, 255.0f)); };
        return {byte(v[0]), byte(v[1]), byte(v[2]), byte(v[3])};
#endif
    }

    void resize(int width, int height, int samples_a_side, Rgba8 background) {
        width_ = width;
        height_ = height;
        side_ = samples_a_side;
        background_ = background;
        blocks_.resize(width, height, background);
        rows_.resize(std::size_t(width) * std::size_t(samples_a_side));
        far_.resize(width, height);
        tiles_.begin(width, height);
        drawn_in_image_ = {0, 0, width, height};
    }

    void clear() {
        if (far_.has_begun()) {
            SampleRect drawn = blocks_.drawn();
            drawn.add(far_.rect());
            tiles_.clear(drawn);
        }
        blocks_.clear();
        far_.clear();
    }

    MadeFor<Kind> made_for_;
    int width_ = 0, height_ = 0, side_ = 1;
    int first_x_ = 0, first_y_ = 0;
    float whole_x_ = 0, whole_y_ = 0;  ///< the whole picture's first sample
    Rgba8 background_{0, 0, 0, 0};
    SampleBlocks blocks_;      ///< opaque, or the background
    std::vector<Rgba8> rows_;  ///< of one row of pixels
    FarSamples far_;
    DepthTiles tiles_;           ///< used only where there is a far field
    SampleRect drawn_in_image_;  ///< relative to the upper left sample
};

}  // namespace farfield::detail
