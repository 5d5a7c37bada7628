// The far field of a picture: for each sample the color deposited and the transmittance left, by the area law
// (geometry/area_law.hpp).
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <vector>

#include "farfield/geometry/area_law.hpp"
#include "farfield/geometry/rgba8.hpp"
#include "farfield/raster/far_field/far_sample.hpp"
#include "farfield/raster/far_field/transmittance_lanes.hpp"
#include "farfield/raster/sample_rect.hpp"

namespace farfield::detail {

/// Samples are addressed from the upper left one. Deposits come front to back over a z-buffer of geometry: depths(y)[x]
/// is larger when nearer, and a deposit behind it is dropped, as if it had never come. A sample that lets nothing
/// through any more is *closed*: no deposit and nothing behind its first deposit can change it. So what is left out
/// because it is hidden leaves no trace, and tiles, where more is hidden, are parts of the whole picture.
class FarSamples {
    struct Bits {
        std::uint64_t open = ~std::uint64_t(0);
        std::uint64_t touched = 0;  ///< deposited into since the last clear()
    };

  public:
    using Sample = FarSample;

    /// Both must be below 2^15.
    void resize(int width, int height) {
        width_ = width;
        height_ = height;
        words_ = std::size_t((width + 63) / 64);
        samples_.clear();
        first_deposit_.clear();
        bits_.assign(words_ * std::size_t(height), {});
        rect_ = {};
        has_begun_ = false;
        place(0, 0, width, height);
    }
    /// Says that the picture is a tile: where its upper left sample lies in the whole. Squares and points come in the
    /// whole's coordinates and are rounded there, so that every tile rounds them alike.
    void place(int left, int top, int whole_width, int whole_height) {
        left_ = left;
        top_ = top;
        whole_width_ = whole_width;
        whole_height_ = whole_height;
    }

    /// Clears only what was deposited since the last time.
    void clear() {
        for_touched([&](int x, int y) { samples_[index(x, y)] = {}; });
        // A sample can be closed only where something was deposited.
        for (int y = rect_.y0; y < rect_.y1; ++y) {
            const auto words = bits_.begin() + std::ptrdiff_t(std::size_t(y) * words_);
            std::fill(words + (rect_.x0 >> 6), words + ((rect_.x1 - 1) >> 6) + 1, Bits{});
        }
        rect_ = {};
        has_begun_ = false;
    }

    /// Call this before the first deposit of a frame. The first frame that has one takes the memory.
    void begin() {
        if (samples_.empty()) {
            const std::size_t count = std::size_t(width_) * std::size_t(height_);
            first_deposit_.resize(count);
            samples_.assign(count, {});  // last: it tells that there is memory
        }
        has_begun_ = true;
    }
    bool has_begun() const { return has_begun_; }
    /// A rectangle that holds all samples deposited into.
    const SampleRect& rect() const { return rect_; }

    /// Deposits into samples [begin, end) of row y, inside the picture, each covered whole; `rgb` in [0, 1], q(x)
    /// the depth.
    template <class Depths, class Depth>
    void deposit_row(const Depths& depths, int y, int begin, int end, Depth&& q, Loss loss, glm::vec3 rgb) {
        const auto row = row_of(depths, y);
        const native_lanes::Deposit deposit(loss, rgb);
        const native_lanes::Square whole(0, 0, 1, 1, 1, 1);
        const auto columns = whole.columns(0);
        const auto rows = whole.rows(0);
        rect_.add(begin, y, end, y + 1);
        for (int x = begin; x < end; ++x) into(row, x, q(x), deposit, columns, rows);
    }

    /// Eight samples of a row, the first one's x a multiple of eight; those beyond the picture must not be used.
    class Eight {
      public:
        /// Deposits something that covers a sample whole and is nearer than geometry there. The color is premultiplied,
        /// alpha neither 0 nor 255.
        void deposit(unsigned i, float q, Rgba8 color) {
            const std::uint64_t bit = first_bit_ << i;
            if ((bits_.open & bit) == 0) return;
            Sample& s = samples_[i];
            if ((bits_.touched & bit) == 0) {
                bits_.touched |= bit;
                first_deposit_[i] = q;
                // What the first one finds is known: most are, and memory is slow.
                const auto lane = std::uint16_t(lanes::one - color.a * 257);
                const float left = float(lane) * (1.0f / float(lanes::one)), part = (1 - left) / float(color.a);
                s = {float(color.r) * part, float(color.g) * part, float(color.b) * part, left};
                std::fill_n(s.lane, lanes::count, lane);
                return;
            }
            const float part = 1 / float(color.a);
            const glm::vec3 rgb = glm::vec3(float(color.r), float(color.g), float(color.b)) * part;
            const native_lanes::Square whole(0, 0, 1, 1, 1, 1);
            const native_lanes::Deposit deposit(loss_of_opacity(float(color.a) * (1 / 255.0f), AreaLaw::independent),
                                                rgb);
            if (deposit.into(s, whole.columns(0), whole.rows(0))) bits_.open &= ~bit;
        }

      private:
        friend class FarSamples;
        Eight(Bits& bits, Sample* samples, float* first_deposit, std::uint64_t first_bit)
            : bits_(bits), samples_(samples), first_deposit_(first_deposit), first_bit_(first_bit) {}

        Bits& bits_;
        Sample* samples_;
        float* first_deposit_;
        std::uint64_t first_bit_;
    };
    Eight eight(int x, int y) {
        const std::size_t at = index(x, y);
        rect_.add(x, y, std::min(x + 8, width_), y + 1);
        return {bits_[std::size_t(y) * words_ + std::size_t(x >> 6)], &samples_[at], &first_deposit_[at],
                std::uint64_t(1) << (x & 63)};
    }
    /// Deposits a square: each lane of a sample gets its share by overlap, `loss` if it is covered whole. Edges are
    /// rounded to about 1/1000 of a sample, equal ones equally, so that adjoining squares cover nothing twice. The
    /// square is cut off at the picture's border.
    template <class Depths>
    void deposit_square(const Depths& depths, float left, float top, float right, float bottom, float q, Loss loss,
                        glm::vec3 rgb) {
        const native_lanes::Square at(left, top, right, bottom, whole_width_, whole_height_);
        if (at.is_empty()) return;
        if (!at.is_small()) return deposit_large(depths, at.x0, at.y0, left, top, right, bottom, q, loss, rgb);
        const int x0 = std::max(at.x0 - left_, 0), x1 = std::min(at.x1 - left_, width_ - 1);
        const int y0 = std::max(at.y0 - top_, 0), y1 = std::min(at.y1 - top_, height_ - 1);
        if (x0 > x1 || y0 > y1) return;
        if (x0 < rect_.x0 || y0 < rect_.y0 || x1 >= rect_.x1 || y1 >= rect_.y1) rect_.add(x0, y0, x1 + 1, y1 + 1);
        const native_lanes::Deposit deposit(loss, rgb);
        for (int y = y0 + 1; y <= y1; ++y) {
            __builtin_prefetch(&samples_[index(x0, y)], 1);
            __builtin_prefetch(&samples_[index(x1, y)], 1);
        }
        const int first_column = left_ - at.x0, first_row = top_ - at.y0;
        for (int y = y0; y <= y1; ++y) {
            const auto row = row_of(depths, y);
            const auto rows = at.rows(y + first_row);
            for (int x = x0; x <= x1; ++x) into(row, x, q, deposit, at.columns(x + first_column), rows);
        }
    }

    /// Deposits something no larger than a lane: all of it goes into the lane that holds its center. `rgb()` is called
    /// only if that changes anything.
    template <class Depths, class Color>
    void deposit_in_lane(const Depths& depths, float x, float y, float area, float q, Loss loss, Color&& rgb) {
        if (!(x >= 0 && y >= 0 && x < float(whole_width_) && y < float(whole_height_))) return;
        const int i = int(x) - left_, j = int(y) - top_;
        if (i < 0 || j < 0 || i >= width_ || j >= height_) return;
        const auto row = row_of(depths, j);
        if (!is_touched_by(row, i, q)) return;
        if (i < rect_.x0 || j < rect_.y0 || i >= rect_.x1 || j >= rect_.y1) rect_.add(i, j, i + 1, j + 1);
        const int column = int((x - float(int(x))) * float(lanes::side));
        const int line = int((y - float(int(y))) * float(lanes::side));
        if (!one_lane_at_a_time::into_lane(row.samples[i], line * lanes::side + column, area * float(lanes::count),
                                           loss, rgb()))
            return;
        row.bits[i >> 6].open &= ~(std::uint64_t(1) << (i & 63));
    }

    bool is_open(int x, int y) const { return bits_of(x, y).open >> (x & 63) & 1; }

    /// What lies behind this changes nothing in a sample that has geometry at `depth`.
    float settled_behind(float depth, int x, int y) const {
        return is_open(x, y) ? depth : std::max(depth, first_deposit_[index(x, y)]);
    }

    /// The deposits into a sample, or null if there are none or if geometry that was drawn later, at `depth`, lies in
    /// front of the first.
    const Sample* over(float depth, int x, int y) const {
        const Bits& bits = bits_of(x, y);
        if ((bits.touched >> (x & 63) & 1) == 0) return nullptr;
        const std::size_t at = index(x, y);
        return first_deposit_[at] > depth ? &samples_[at] : nullptr;
    }

    /// The depth of the first and nearest deposit into a sample; -infinity: none counts.
    float first_over(float depth, int x, int y) const {
        return over(depth, x, y) != nullptr ? first_deposit_[index(x, y)] : -std::numeric_limits<float>::infinity();
    }

    /// Calls f(x, y) for every sample that was deposited into.
    template <class F>
    void for_touched(F&& f) const {
        for (int y = rect_.y0; y < rect_.y1; ++y) {
            for (std::size_t w = std::size_t(rect_.x0) >> 6; w <= std::size_t(rect_.x1 - 1) >> 6; ++w) {
                for (std::uint64_t bits = bits_[std::size_t(y) * words_ + w].touched; bits != 0; bits &= bits - 1) {
                    f(int(w * 64) + std::countr_zero(bits), y);
                }
            }
        }
    }

  private:
    template <class DepthsOfRow>
    struct Row {
        std::size_t first;
        DepthsOfRow depth;
        Sample* samples;
        Bits* bits;
    };
    template <class Depths>
    auto row_of(const Depths& depths, int y) {
        const std::size_t first = index(0, y);
        return Row<decltype(depths(y))>{first, depths(y), samples_.data() + first,
                                        bits_.data() + std::size_t(y) * words_};
    }

    /// Splits the square along borders of samples.
    template <class Depths>
    void deposit_large(const Depths& depths, int x0, int y0, float left, float top, float right, float bottom, float q,
                       Loss loss, glm::vec3 rgb) {
        const auto x = float(x0 + lanes::most_samples / 2), y = float(y0 + lanes::most_samples / 2);
        if (x < right) {
            deposit_square(depths, left, top, x, bottom, q, loss, rgb);
            deposit_square(depths, x, top, right, bottom, q, loss, rgb);
        } else {
            deposit_square(depths, left, top, right, y, q, loss, rgb);
            deposit_square(depths, left, y, right, bottom, q, loss, rgb);
        }
    }

    template <class Row>
    void into(const Row& row, int x, float q, const native_lanes::Deposit& deposit,
              const native_lanes::Columns& columns, const native_lanes::Rows& rows) {
        if (!is_touched_by(row, x, q)) return;
        if (deposit.into(row.samples[x], columns, rows)) row.bits[x >> 6].open &= ~(std::uint64_t(1) << (x & 63));
    }

    /// Whether a deposit changes a sample, which is then marked as touched.
    template <class Row>
    bool is_touched_by(const Row& row, int x, float q) {
        const std::uint64_t bit = std::uint64_t(1) << (x & 63);
        Bits& bits = row.bits[x >> 6];
        if ((bits.open & bit) == 0) return false;
        if (q <= row.depth[x]) return false;
        if ((bits.touched & bit) == 0) {
            bits.touched |= bit;
            first_deposit_[row.first + std::size_t(x)] = q;
        }
        return true;
    }

    std::size_t index(int x, int y) const { return std::size_t(y) * std::size_t(width_) + std::size_t(x); }
    const Bits& bits_of(int x, int y) const { return bits_[std::size_t(y) * words_ + std::size_t(x >> 6)]; }

    int width_ = 0, height_ = 0;
    int left_ = 0, top_ = 0, whole_width_ = 0, whole_height_ = 0;
    std::size_t words_ = 0;
    std::vector<Sample> samples_;
    std::vector<float> first_deposit_;  ///< q of the first and nearest, for samples touched
    std::vector<Bits> bits_;            ///< 64 samples each, rows padded
    SampleRect rect_;
    bool has_begun_ = false;
};

}  // namespace farfield::detail
