// The far field of a picture: for each sample the color deposited and the transmittance left, by the area law
// (geometry/area_law.hpp).
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
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
#include "farfield/simd.hpp"

namespace farfield::detail {

/// Samples are addressed from the upper left one. Deposits come front to back over a z-buffer of geometry, `depths`
/// (SampleBlocks), which are larger when nearer; a deposit behind them is dropped, as if it had never come. A sample
/// that lets nothing through any more is *closed*: no deposit and nothing behind its first deposit can change it. So
/// what is left out because it is hidden leaves no trace, and tiles, where more is hidden, are parts of the whole
/// picture.
class FarSamples {
    struct Bits {
        std::uint64_t open = ~std::uint64_t(0);
        std::uint64_t touched = 0;  ///< deposited into since the last clear()
        std::uint64_t split = 0;    ///< touched, and its lanes are kept: they may differ
    };

  public:
    using Sample = FarSample;
    using Deposit = native_lanes::Deposit;

    /// Both must be below 2^15.
    void resize(int width, int height) {
        width_ = width;
        height_ = height;
        words_ = std::size_t((width + 63) / 64);
        samples_.clear();
        lanes_.clear();
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

    /// Forgets what was deposited. The first deposit into a sample finds it as it likes, so that samples themselves are
    /// left alone.
    void clear() {
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
            lanes_.resize(count);
            samples_.assign(count, {});  // last: it tells that there is memory
        }
        has_begun_ = true;
    }
    bool has_begun() const { return has_begun_; }
    /// A rectangle that holds all samples deposited into.
    const SampleRect& rect() const { return rect_; }

    /// Deposits into samples [begin, end) of row y, inside the picture, each covered whole; q(x) is the depth, and does
    /// not both rise and fall within eight samples.
    template <class Depths, class Depth>
    void deposit_row(const Depths& depths, int y, int begin, int end, const Depth& q, const Deposit& deposit) {
        if (begin >= end) return;
        rect_.add(begin, y, end, y + 1);
        deposit_whole(depths, y, begin, end, q, deposit, first_of(deposit));
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
                const float left = float(lanes::one - color.a * 257) * (1.0f / float(lanes::one));
                const float part = (1 - left) / float(color.a);
                s = {float(color.r) * part, float(color.g) * part, float(color.b) * part, left};
                return;
            }
            const float part = 1 / float(color.a);
            const glm::vec3 rgb = glm::vec3(float(color.r), float(color.g), float(color.b)) * part;
            const Deposit deposit(loss_of_opacity(float(color.a) * (1 / 255.0f), AreaLaw::independent), rgb);
            if (into_whole(s, lanes_[i], (bits_.split & bit) != 0, deposit)) bits_.open &= ~bit;
        }

      private:
        friend class FarSamples;
        Eight(Bits& bits, Sample* samples, FarLanes* lanes, float* first_deposit, std::uint64_t first_bit)
            : bits_(bits), samples_(samples), lanes_(lanes), first_deposit_(first_deposit), first_bit_(first_bit) {}

        Bits& bits_;
        Sample* samples_;
        FarLanes* lanes_;
        float* first_deposit_;
        std::uint64_t first_bit_;
    };
    Eight eight(int x, int y) {
        const std::size_t at = index(x, y);
        rect_.add(x, y, std::min(x + 8, width_), y + 1);
        return {bits_[std::size_t(y) * words_ + std::size_t(x >> 6)], &samples_[at], &lanes_[at], &first_deposit_[at],
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
        if (at.x1 - at.x0 >= large || at.y1 - at.y0 >= large) {
            return deposit_large(depths, left, top, right, bottom, q, loss, rgb);
        }
        const Deposit deposit(loss, rgb);
        const int x0 = std::max(at.x0 - left_, 0), x1 = std::min(at.x1 - left_, width_ - 1);
        const int y0 = std::max(at.y0 - top_, 0), y1 = std::min(at.y1 - top_, height_ - 1);
        if (x0 > x1 || y0 > y1) return;
        if (x0 < rect_.x0 || y0 < rect_.y0 || x1 >= rect_.x1 || y1 >= rect_.y1) rect_.add(x0, y0, x1 + 1, y1 + 1);
        for (int y = y0 + 1; y <= y1; ++y) {
            __builtin_prefetch(&samples_[index(x0, y)], 1);
            __builtin_prefetch(&lanes_[index(x0, y)], 1);
            __builtin_prefetch(&lanes_[index(x1, y)], 1);
        }
        const int first_column = left_ - at.x0, first_row = top_ - at.y0;
        for (int y = y0; y <= y1; ++y) {
            const Row row = row_of(y);
            const auto rows = at.rows(y + first_row);
            for (int x = x0; x <= x1; ++x) {
                if (!row.is_open(x) || q <= depths.depth(x, y)) continue;
                row.split(x, q);
                if (deposit.into(row.samples[x], row.lanes[x], at.columns(x + first_column), rows)) row.close(x);
            }
        }
    }

    /// Deposits something no larger than a lane: all of it goes into the lane that holds its center. `rgb()` is called
    /// only if that changes anything.
    template <class Depths, class Color>
    void deposit_in_lane(const Depths& depths, float x, float y, float area, float q, Loss loss, Color&& rgb) {
        if (!(x >= 0 && y >= 0 && x < float(whole_width_) && y < float(whole_height_))) return;
        const int i = int(x) - left_, j = int(y) - top_;
        if (i < 0 || j < 0 || i >= width_ || j >= height_) return;
        const Row row = row_of(j);
        if (!row.is_open(i) || q <= depths.depth(i, j)) return;
        if (i < rect_.x0 || j < rect_.y0 || i >= rect_.x1 || j >= rect_.y1) rect_.add(i, j, i + 1, j + 1);
        row.split(i, q);
        const int column = int((x - float(int(x))) * float(lanes::side));
        const int line = int((y - float(int(y))) * float(lanes::side));
        if (one_lane_at_a_time::into_lane(row.samples[i], row.lanes[i], line * lanes::side + column,
                                          area * float(lanes::count), loss, rgb())) {
            row.close(i);
        }
    }

    bool is_open(int x, int y) const { return bits_of(x, y).open >> (x & 63) & 1; }

    /// What lies behind this changes nothing in a sample that has geometry at `depth`.
    float settled_behind(float depth, int x, int y) const {
        return is_open(x, y) ? depth : std::max(depth, first_deposit_[index(x, y)]);
    }

    /// Whether something was deposited into a sample, or into one of a square of `side` x `side`, at most 8, from it
    /// on.
    bool is_touched(int x, int y) const { return (bits_of(x, y).touched >> (x & 63) & 1) != 0; }
    bool is_touched(int x, int y, int side) const {
        const std::size_t first = std::size_t(y) * words_;
        std::uint64_t touched = 0;
        for (int word = x >> 6; word <= (x + side - 1) >> 6; ++word) {
            const int low = std::max(x - word * 64, 0), high = std::min(x + side - word * 64, 64) - 1;
            const std::uint64_t wanted = bits_between(low, high);
            for (int row = 0; row < side; ++row) {
                touched |= bits_[first + std::size_t(row) * words_ + std::size_t(word)].touched & wanted;
            }
        }
        return touched != 0;
    }

    /// The deposits into a sample, or null if there are none or if geometry that was drawn later, at `depth`, lies in
    /// front of the first.
    const Sample* over(float depth, int x, int y) const {
        const Bits& bits = bits_of(x, y);
        if ((bits.touched >> (x & 63) & 1) == 0) return nullptr;
        const std::size_t at = index(x, y);
        return first_deposit_[at] > depth ? &samples_[at] : nullptr;
    }

    /// Brings depths of [begin, end) of row y up to those of first deposits where these are nearer.
    void raise_to_first(int y, int begin, int end, float* depths) const {
        if (begin >= end || y < rect_.y0 || y >= rect_.y1) return;
        for (int word = begin >> 6; word <= (end - 1) >> 6; ++word) {
            const int low = std::max(begin - word * 64, 0), high = std::min(end - word * 64, 64) - 1;
            const std::uint64_t touched = bits_[std::size_t(y) * words_ + std::size_t(word)].touched;
            for (std::uint64_t left = touched & bits_between(low, high); left != 0; left &= left - 1) {
                const int x = word * 64 + std::countr_zero(left);
                depths[x - begin] = std::max(depths[x - begin], first_deposit_[index(x, y)]);
            }
        }
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
    /// Squares that touch this many samples along a side are taken apart: within, samples are covered whole.
    static constexpr int large = 8;

    struct Row {
        Sample* samples;
        FarLanes* lanes;
        float* first_deposit;
        Bits* bits;

        static std::uint64_t bit(int x) { return std::uint64_t(1) << (x & 63); }
        bool is_open(int x) const { return (bits[x >> 6].open & bit(x)) != 0; }
        bool is_split(int x) const { return (bits[x >> 6].split & bit(x)) != 0; }
        void close(int x) const { bits[x >> 6].open &= ~bit(x); }
        /// Keeps the lanes of a sample that a deposit at depth q is to change.
        FARFIELD_INLINE void split(int x, float q) const {
            Bits& b = bits[x >> 6];
            if ((b.split & bit(x)) != 0) return;
            b.split |= bit(x);
            if ((b.touched & bit(x)) != 0) return lanes[x].fill(std::uint16_t(lane_of(samples[x].transmittance)));
            b.touched |= bit(x);
            first_deposit[x] = q;
            samples[x] = {};
            lanes[x].fill(detail::lanes::one);
        }
    };
    Row row_of(int y) {
        const std::size_t first = index(0, y);
        return {samples_.data() + first, lanes_.data() + first, first_deposit_.data() + first,
                bits_.data() + std::size_t(y) * words_};
    }
    /// What a deposit leaves of a sample that nothing was deposited into.
    struct First {
        Sample left;
        bool closes;
    };
    static First first_of(const Deposit& deposit) {
        First f;
        f.closes = deposit.into(f.left);
        return f;
    }

    /// Ends included.
    static std::uint64_t bits_between(int first, int last) {
        return ~std::uint64_t(0) << first & ~std::uint64_t(0) >> (63 - last);
    }

    /// Splits the square into what covers samples whole and a border.
    template <class Depths>
    [[gnu::noinline]] void deposit_large(const Depths& depths, float left, float top, float right, float bottom,
                                         float q, Loss loss, glm::vec3 rgb) {
        const auto inside = [](float at, int size) { return std::min(std::max(0.0f, at), float(size)); };
        left = inside(left, whole_width_), right = inside(right, whole_width_);
        top = inside(top, whole_height_), bottom = inside(bottom, whole_height_);
        const float x0 = std::min(std::ceil(left), right), x1 = std::max(std::floor(right), x0);
        const float y0 = std::min(std::ceil(top), bottom), y1 = std::max(std::floor(bottom), y0);
        const auto deposit_border = [&](float x, float y, float end_x, float end_y) {
            while (x < end_x && y < end_y) {
                const float next_x = std::min(std::floor(x) + (large - 1), end_x);
                const float next_y = std::min(std::floor(y) + (large - 1), end_y);
                deposit_square(depths, x, y, next_x, next_y, q, loss, rgb);
                end_x - x > end_y - y ? x = next_x : y = next_y;
            }
        };
        deposit_border(left, top, right, y0);
        deposit_border(left, y0, x0, y1);
        deposit_border(x1, y0, right, y1);
        deposit_border(left, y1, right, bottom);
        const int begin = std::max(int(x0) - left_, 0), end = std::min(int(x1) - left_, width_);
        const int first = std::max(int(y0) - top_, 0), last = std::min(int(y1) - top_, height_);
        if (begin >= end || first >= last) return;
        rect_.add(begin, first, end, last);
        const Deposit deposit(loss, rgb);
        const First first_here = first_of(deposit);
        for (int y = first; y < last; ++y) {
            deposit_whole(
                depths, y, begin, end, [q](int) { return q; }, deposit, first_here);
        }
    }

    template <class Depths, class Depth>
    void deposit_whole(const Depths& depths, int y, int begin, int end, const Depth& q, const Deposit& deposit,
                       const First& first) {
        const Row row = row_of(y);
        for (int word = begin >> 6; word <= (end - 1) >> 6; ++word) {
            Bits& bits = row.bits[word];
            const int low = std::max(begin - word * 64, 0), high = std::min(end - word * 64, 64) - 1;
            std::uint64_t changed = bits.open & bits_between(low, high);
            if (changed != 0) changed = depths.farther(y, word * 64, changed, q);
            const std::uint64_t fresh = changed & ~bits.touched;
            bits.touched |= fresh;
            if (first.closes) bits.open &= ~fresh;
            for (std::uint64_t left = fresh; left != 0; left &= left - 1) {
                const int x = word * 64 + std::countr_zero(left);
                row.samples[x] = first.left;
                row.first_deposit[x] = q(x);
            }
            for (std::uint64_t left = changed & ~fresh; left != 0; left &= left - 1) {
                const int x = word * 64 + std::countr_zero(left);
                if (into_whole(row.samples[x], row.lanes[x], row.is_split(x), deposit)) row.close(x);
            }
        }
    }
    static bool into_whole(Sample& sample, FarLanes& lanes, bool is_split, const Deposit& deposit) {
        if (!is_split) return deposit.into(sample);
        const native_lanes::Square whole(0, 0, 1, 1, 1, 1);
        return deposit.into(sample, lanes, whole.columns(0), whole.rows(0));
    }

    std::size_t index(int x, int y) const { return std::size_t(y) * std::size_t(width_) + std::size_t(x); }
    const Bits& bits_of(int x, int y) const { return bits_[std::size_t(y) * words_ + std::size_t(x >> 6)]; }

    int width_ = 0, height_ = 0;
    int left_ = 0, top_ = 0, whole_width_ = 0, whole_height_ = 0;
    std::size_t words_ = 0;
    std::vector<Sample> samples_;       ///< those touched
    std::vector<FarLanes> lanes_;       ///< those split
    std::vector<float> first_deposit_;  ///< q of the first and nearest, for samples touched
    std::vector<Bits> bits_;            ///< 64 samples each, rows padded
    SampleRect rect_;
    bool has_begun_ = false;
};

}  // namespace farfield::detail
