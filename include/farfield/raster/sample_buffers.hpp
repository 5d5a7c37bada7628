// What a frame is drawn into: for each sample a z-buffer of geometry and, over it, the far field's color and
// transmittance; and the picture that comes of them.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <vector>

#include "farfield/geometry/area_law.hpp"
#include "farfield/geometry/rgba8.hpp"
#include "farfield/raster/depth_tiles.hpp"
#include "farfield/raster/image.hpp"
#include "farfield/raster/sample_projection.hpp"

namespace farfield {

/// A rectangle of samples, half open; empty where first >= end.
struct SampleRect {
    int x0 = std::numeric_limits<int>::max(), y0 = std::numeric_limits<int>::max();
    int x1 = std::numeric_limits<int>::min(), y1 = std::numeric_limits<int>::min();

    bool is_empty() const { return x0 >= x1 || y0 >= y1; }
    void add(int left, int top, int right, int bottom) {
        x0 = std::min(x0, left);
        y0 = std::min(y0, top);
        x1 = std::max(x1, right);
        y1 = std::max(y1, bottom);
    }
    void add(const SampleRect& r) {
        if (!r.is_empty()) add(r.x0, r.y0, r.x1, r.y1);
    }
};

/// Samples are addressed relative to the projection's center sample. Only what the last frame drew is cleared.
///
/// The far field is front to back over the geometry: a deposit behind the z-buffer is dropped, the picture is what was
/// deposited plus transmittance times the z-buffer's color. A sample that let nothing through, or whose geometry lies
/// in front of a deposit, is *closed*: nothing that comes later in front-to-back order can change it.
class SampleBuffers {
  public:
    struct FarSample {
        float r = 0, g = 0, b = 0;  ///< premultiplied
        float transmittance = 1;
    };

    void begin(const SampleProjection& to, int samples_a_side, Rgba8 background) {
        const int width = to.end_x - to.first_x, height = to.end_y - to.first_y;
        if (width != width_ || height != height_ || samples_a_side != side_ || !(background == background_)) {
            resize(width, height, samples_a_side, background);
        } else {
            clear();
        }
        first_x_ = to.first_x;
        first_y_ = to.first_y;
    }

    int samples_a_side() const { return side_; }
    /// Whether the far field of this frame has begun.
    bool has_far() const { return has_far_; }

    /// z and color of row y, to be indexed with x. Whoever writes says so by near_drawn().
    float* depth_row(int y) { return depth_.data() + row(y) - first_x_; }
    Rgba8* color_row(int y) { return color_.data() + row(y) - first_x_; }
    void near_drawn(int x0, int y0, int x1, int y1) {
        near_.add(x0 - first_x_, y0 - first_y_, x1 - first_x_, y1 - first_y_);
    }

    void begin_far() {
        has_far_ = true;
        if (far_.empty()) far_.assign(depth_.size(), {});
    }

    /// Deposits into samples [begin, end) of row y: `area` in units of a sample's own, `rgb` in [0, 1]; q(x) is the
    /// depth.
    template <AreaLaw law, class Depth>
    void deposit_row(int y, int begin, int end, Depth&& q, float area, glm::vec3 rgb) {
        const std::size_t line = std::size_t(y - first_y_);
        const float* depth = depth_.data() + line * std::size_t(width_);
        FarSample* far = far_.data() + line * std::size_t(width_);
        std::uint64_t* open = open_.data() + line * words_;
        std::uint64_t* touched = touched_.data() + line * words_;
        far_rect_.add(begin - first_x_, y - first_y_, end - first_x_, y - first_y_ + 1);
        bool closed = false;
        for (int x = begin; x < end; ++x) {
            const int i = x - first_x_;
            closed |= deposit<law>(far[i], depth[i], open[i >> 6], touched[i >> 6], std::uint64_t(1) << (i & 63), q(x),
                                   area, rgb);
        }
        any_closed_ |= closed;
    }

    /// A square deposit; each sample gets its share by overlap, `share` if it is covered whole. Outside the image it is
    /// cut off.
    template <AreaLaw law>
    void deposit_square(float left, float top, float right, float bottom, float q, float share, glm::vec3 rgb) {
        left -= float(first_x_);
        right -= float(first_x_);
        top -= float(first_y_);
        bottom -= float(first_y_);
        if (!(left < float(width_) && right > 0 && top < float(height_) && bottom > 0)) return;
        const int x0 = left > 0 ? int(left) : 0, x1 = right < float(width_) ? int(right) : width_ - 1;
        const int y0 = top > 0 ? int(top) : 0, y1 = bottom < float(height_) ? int(bottom) : height_ - 1;
        far_rect_.add(x0, y0, x1 + 1, y1 + 1);
        bool closed = false;
        for (int y = y0; y <= y1; ++y) {
            const std::size_t line = std::size_t(y);
            const float height = share * (std::min(bottom, float(y + 1)) - std::max(top, float(y)));
            const float* depth = depth_.data() + line * std::size_t(width_);
            FarSample* far = far_.data() + line * std::size_t(width_);
            std::uint64_t* open = open_.data() + line * words_;
            std::uint64_t* touched = touched_.data() + line * words_;
            for (int x = x0; x <= x1; ++x) {
                const float width = std::min(right, float(x + 1)) - std::max(left, float(x));
                closed |= deposit<law>(far[x], depth[x], open[x >> 6], touched[x >> 6], std::uint64_t(1) << (x & 63), q,
                                       width * height, rgb);
            }
        }
        any_closed_ |= closed;
    }

    /// Can nothing as far as q or farther change any sample of a rectangle (relative to the center sample, ends
    /// included), because it is closed or its geometry is nearer? May err towards no; true of an empty rectangle.
    bool all_settled(int x0, int y0, int x1, int y1, float q) {
        x0 = std::max(x0 - first_x_, 0);
        y0 = std::max(y0 - first_y_, 0);
        x1 = std::min(x1 - first_x_, width_ - 1);
        y1 = std::min(y1 - first_y_, height_ - 1);
        if (x0 > x1 || y0 > y1) return true;
        return all_closed(x0, y0, x1, y1) ||
               tiles_.all_nearer(x0, y0, x1, y1, q, [&](int left, int top, int right, int bottom) {
                   return farthest(left, top, right, bottom);
               });
    }

    /// Box filter: the mean of a pixel's samples. Writes only what changed since the last resolve into the same image.
    void resolve(Image& image) {
        const int width = width_ / side_, height = height_ / side_;
        if (image.width() != width || image.height() != height) {
            image = Image(width, height, background_);
            drawn_in_image_ = {};
        }
        for_pixels(drawn_in_image_, [&](int x, int y) { image.at(x, y) = background_; });
        SampleRect drawn = near_;
        drawn.add(far_rect_);
        drawn_in_image_ = drawn;
        if (side_ != 1) {
            for_pixels(drawn, [&](int x, int y) { image.at(x, y) = pixel(x, y); });
            return;
        }
        for (int y = drawn.y0; y < drawn.y1; ++y) {
            const Rgba8* from = color_.data() + index(0, y);
            std::copy(from + drawn.x0, from + drawn.x1, &image.at(drawn.x0, y));
        }
        for_touched([&](int x, int y) { image.at(x, y) = pixel(x, y); });
    }

  private:
    bool all_closed(int x0, int y0, int x1, int y1) const {
        if (!any_closed_) return false;
        const std::uint64_t all = ~std::uint64_t(0);
        for (int y = y0; y <= y1; ++y) {
            const std::uint64_t* words = open_.data() + std::size_t(y) * words_;
            for (int w = x0 >> 6; w <= x1 >> 6; ++w) {
                std::uint64_t mask = all;
                if (w == x0 >> 6) mask &= all << (x0 & 63);
                if (w == x1 >> 6) mask &= all >> (63 - (x1 & 63));
                if (words[w] & mask) return false;
            }
        }
        return true;
    }

    /// Least q of the samples of a rectangle that are not closed.
    float farthest(int left, int top, int right, int bottom) const {
        float least = std::numeric_limits<float>::infinity();
        for (int y = top; y < std::min(bottom, height_); ++y) {
            const float* depth = depth_.data() + index(0, y);
            const std::uint64_t open = open_[std::size_t(y) * words_ + std::size_t(left >> 6)] >> (left & 63);
            for (int x = left; x < std::min(right, width_); ++x) {
                if (open >> (x - left) & 1) least = std::min(least, depth[x]);
            }
        }
        return least;
    }

    std::size_t index(int x, int y) const { return std::size_t(y) * std::size_t(width_) + std::size_t(x); }
    std::size_t row(int y) const { return std::size_t(y - first_y_) * std::size_t(width_); }

    template <class F>
    void for_pixels(const SampleRect& r, F&& f) const {
        if (r.is_empty()) return;
        for (int y = r.y0 / side_; y <= (r.y1 - 1) / side_; ++y) {
            for (int x = r.x0 / side_; x <= (r.x1 - 1) / side_; ++x) f(x, y);
        }
    }

    /// True if it closed the sample.
    template <AreaLaw law>
    static bool deposit(FarSample& s, float depth, std::uint64_t& open, std::uint64_t& touched, std::uint64_t bit,
                        float q, float area, glm::vec3 rgb) {
        if ((open & bit) == 0) return false;
        if (q <= depth) {
            open &= ~bit;
            return true;
        }
        touched |= bit;
        float left = transmitted(s.transmittance, area, law);
        const bool closes = left < closed_transmittance;
        if (closes) {
            left = 0;
            open &= ~bit;
        }
        const float taken = s.transmittance - left;
        s.r += taken * rgb.r;
        s.g += taken * rgb.g;
        s.b += taken * rgb.b;
        s.transmittance = left;
        return closes;
    }

    /// f(x, y) for every sample of the far field that was deposited into.
    template <class F>
    void for_touched(F&& f) const {
        for (int y = far_rect_.y0; y < far_rect_.y1; ++y) {
            for (std::size_t w = std::size_t(far_rect_.x0) >> 6; w <= std::size_t(far_rect_.x1 - 1) >> 6; ++w) {
                for (std::uint64_t bits = touched_[std::size_t(y) * words_ + w]; bits != 0; bits &= bits - 1) {
                    f(int(w * 64) + std::countr_zero(bits), y);
                }
            }
        }
    }

    Rgba8 pixel(int px, int py) const {
        glm::vec4 sum(0);
        for (int y = py * side_; y < (py + 1) * side_; ++y) {
            for (int x = px * side_; x < (px + 1) * side_; ++x) {
                const Rgba8 c = color_[index(x, y)];
                const glm::vec4 behind(float(c.r), float(c.g), float(c.b), float(c.a));
                if (touched_[std::size_t(y) * words_ + std::size_t(x >> 6)] >> (x & 63) & 1) {
                    const FarSample& s = far_[index(x, y)];
                    sum += glm::vec4(s.r, s.g, s.b, 1 - s.transmittance) * 255.0f + behind * s.transmittance;
                } else {
                    sum += behind;
                }
            }
        }
        sum *= 1.0f / float(side_ * side_);
        const auto byte = [](float v) { return std::uint8_t(std::min(v + 0.5f, 255.0f)); };
        return {byte(sum.r), byte(sum.g), byte(sum.b), byte(sum.a)};
    }

    void resize(int width, int height, int samples_a_side, Rgba8 background) {
        width_ = width;
        height_ = height;
        side_ = samples_a_side;
        background_ = background;
        words_ = std::size_t((width + 63) / 64);
        const std::size_t count = std::size_t(width) * std::size_t(height);
        depth_.assign(count, -std::numeric_limits<float>::infinity());
        color_.assign(count, background);
        far_.clear();
        open_.assign(words_ * std::size_t(height), ~std::uint64_t(0));
        touched_.assign(open_.size(), 0);
        near_ = far_rect_ = {};
        drawn_in_image_ = {0, 0, width, height};
        any_closed_ = has_far_ = false;
        tiles_.begin(width, height);
    }

    void clear() {
        for (int y = near_.y0; y < near_.y1; ++y) {
            const auto from = std::ptrdiff_t(index(near_.x0, y)), to = std::ptrdiff_t(index(near_.x1, y));
            std::fill(depth_.begin() + from, depth_.begin() + to, -std::numeric_limits<float>::infinity());
            std::fill(color_.begin() + from, color_.begin() + to, background_);
        }
        for_touched([&](int x, int y) { far_[index(x, y)] = {}; });
        for (int y = far_rect_.y0; y < far_rect_.y1; ++y) {
            const auto words = touched_.begin() + std::ptrdiff_t(std::size_t(y) * words_);
            std::fill(words + (far_rect_.x0 >> 6), words + ((far_rect_.x1 - 1) >> 6) + 1, std::uint64_t(0));
        }
        if (any_closed_) std::fill(open_.begin(), open_.end(), ~std::uint64_t(0));
        if (has_far_) tiles_.begin(width_, height_);
        near_ = far_rect_ = {};
        any_closed_ = has_far_ = false;
    }

    int width_ = 0, height_ = 0, side_ = 1;
    int first_x_ = 0, first_y_ = 0;
    Rgba8 background_{0, 0, 0, 0};
    std::size_t words_ = 0;
    std::vector<float> depth_;
    std::vector<Rgba8> color_;  ///< opaque, or the background
    std::vector<FarSample> far_;
    std::vector<std::uint64_t> open_;     ///< one bit a sample, rows padded to words
    std::vector<std::uint64_t> touched_;  ///< likewise: deposited into since begin()
    bool any_closed_ = false, has_far_ = false;
    DepthTiles tiles_;
    SampleRect near_, far_rect_, drawn_in_image_;  ///< relative to the upper left sample
};

}  // namespace farfield
