// The far field of a picture: for each sample the color deposited and the transmittance left, by the area law
// (geometry/area_law.hpp).
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "farfield/geometry/area_law.hpp"
#include "farfield/raster/sample_rect.hpp"

namespace farfield {

/// Samples are addressed from the upper left one. Deposits come front to back over a z-buffer of geometry, `depth`, row
/// by row, larger when nearer: a deposit behind it is dropped. A sample that lets nothing through any more, or whose
/// geometry lies in front of a deposit, is *closed*: nothing that comes later in that order can change it.
class FarSamples {
  public:
    struct Sample {
        float r = 0, g = 0, b = 0;  ///< premultiplied
        float transmittance = 1;
    };

    void resize(int width, int height) {
        width_ = width;
        height_ = height;
        words_ = std::size_t((width + 63) / 64);
        samples_.clear();
        first_deposit_.clear();
        open_.assign(words_ * std::size_t(height), ~std::uint64_t(0));
        touched_.assign(open_.size(), 0);
        rect_ = {};
        has_begun_ = any_closed_ = false;
    }

    /// Only what was deposited since the last time.
    void clear() {
        for_touched([&](int x, int y) { samples_[index(x, y)] = {}; });
        for (int y = rect_.y0; y < rect_.y1; ++y) {
            const auto words = touched_.begin() + std::ptrdiff_t(std::size_t(y) * words_);
            std::fill(words + (rect_.x0 >> 6), words + ((rect_.x1 - 1) >> 6) + 1, std::uint64_t(0));
        }
        if (any_closed_) std::fill(open_.begin(), open_.end(), ~std::uint64_t(0));
        rect_ = {};
        has_begun_ = any_closed_ = false;
    }

    /// Before the first deposit of a frame: memory is taken by the first frame that has one.
    void begin() {
        has_begun_ = true;
        if (!samples_.empty()) return;
        samples_.assign(std::size_t(width_) * std::size_t(height_), {});
        first_deposit_.resize(samples_.size());
    }
    bool has_begun() const { return has_begun_; }
    /// Holds all samples deposited into.
    const SampleRect& rect() const { return rect_; }

    /// Into samples [begin, end) of row y, inside the picture: `area` in units of a sample's own, `rgb` in [0, 1]; q(x)
    /// is the depth.
    template <AreaLaw law, class Depth>
    void deposit_row(const float* depth, int y, int begin, int end, Depth&& q, float area, glm::vec3 rgb) {
        const Row row = row_of(depth, y);
        rect_.add(begin, y, end, y + 1);
        bool closed = false;
        for (int x = begin; x < end; ++x) closed |= deposit<law>(row, x, q(x), area, rgb);
        any_closed_ |= closed;
    }

    /// A square deposit; each sample gets its share by overlap, `share` if it is covered whole. Outside of the picture
    /// it is cut off.
    template <AreaLaw law>
    void deposit_square(const float* depth, float left, float top, float right, float bottom, float q, float share,
                        glm::vec3 rgb) {
        if (!(left < float(width_) && right > 0 && top < float(height_) && bottom > 0)) return;
        const int x0 = left > 0 ? int(left) : 0, x1 = right < float(width_) ? int(right) : width_ - 1;
        const int y0 = top > 0 ? int(top) : 0, y1 = bottom < float(height_) ? int(bottom) : height_ - 1;
        rect_.add(x0, y0, x1 + 1, y1 + 1);
        bool closed = false;
        for (int y = y0; y <= y1; ++y) {
            const Row row = row_of(depth, y);
            const float height = share * (std::min(bottom, float(y + 1)) - std::max(top, float(y)));
            for (int x = x0; x <= x1; ++x) {
                const float width = std::min(right, float(x + 1)) - std::max(left, float(x));
                closed |= deposit<law>(row, x, q, width * height, rgb);
            }
        }
        any_closed_ |= closed;
    }

    /// Of a rectangle inside the picture, ends included.
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
    bool is_open(int x, int y) const { return bit_of(open_, x, y); }

    /// What was deposited into a sample, or null: also where geometry that was drawn later, at `depth`, lies in front
    /// of the first deposit.
    const Sample* over(float depth, int x, int y) const {
        if (!bit_of(touched_, x, y)) return nullptr;
        const std::size_t at = index(x, y);
        return first_deposit_[at] > depth ? &samples_[at] : nullptr;
    }

    /// f(x, y) for every sample that was deposited into.
    template <class F>
    void for_touched(F&& f) const {
        for (int y = rect_.y0; y < rect_.y1; ++y) {
            for (std::size_t w = std::size_t(rect_.x0) >> 6; w <= std::size_t(rect_.x1 - 1) >> 6; ++w) {
                for (std::uint64_t bits = touched_[std::size_t(y) * words_ + w]; bits != 0; bits &= bits - 1) {
                    f(int(w * 64) + std::countr_zero(bits), y);
                }
            }
        }
    }

  private:
    struct Row {
        const float* depth;
        Sample* samples;
        float* first_deposit;
        std::uint64_t *open, *touched;
    };
    Row row_of(const float* depth, int y) {
        const std::size_t at = index(0, y), word = std::size_t(y) * words_;
        return {depth + at, samples_.data() + at, first_deposit_.data() + at, open_.data() + word,
                touched_.data() + word};
    }

    /// True if it closed the sample.
    template <AreaLaw law>
    static bool deposit(const Row& row, int x, float q, float area, glm::vec3 rgb) {
        const std::uint64_t bit = std::uint64_t(1) << (x & 63);
        std::uint64_t &open = row.open[x >> 6], &touched = row.touched[x >> 6];
        if ((open & bit) == 0) return false;
        if (q <= row.depth[x]) {
            open &= ~bit;
            return true;
        }
        if ((touched & bit) == 0) {
            touched |= bit;
            row.first_deposit[x] = q;
        }
        Sample& s = row.samples[x];
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

    std::size_t index(int x, int y) const { return std::size_t(y) * std::size_t(width_) + std::size_t(x); }
    bool bit_of(const std::vector<std::uint64_t>& bits, int x, int y) const {
        return bits[std::size_t(y) * words_ + std::size_t(x >> 6)] >> (x & 63) & 1;
    }

    int width_ = 0, height_ = 0;
    std::size_t words_ = 0;
    std::vector<Sample> samples_;
    std::vector<float> first_deposit_;    ///< q of the first, which is the nearest; of samples touched
    std::vector<std::uint64_t> open_;     ///< one bit a sample, rows padded to words
    std::vector<std::uint64_t> touched_;  ///< likewise: deposited into since the last clear()
    SampleRect rect_;
    bool has_begun_ = false, any_closed_ = false;
};

}  // namespace farfield
