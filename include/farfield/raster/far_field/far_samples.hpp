// The far field of a picture: for each sample the color deposited and the transmittance left, by the area law
// (geometry/area_law.hpp), in blocks of 8 x 8 samples that lie together in memory. At 64 samples a pixel a deposit is
// some ten rows high, and rows of a whole picture are pages apart.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <memory>
#include <vector>

#include "farfield/geometry/area_law.hpp"
#include "farfield/geometry/rgba8.hpp"
#include "farfield/raster/far_field/block_bits.hpp"
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
  public:
    using Sample = FarSample;
    using Deposit = native_lanes::Deposit;
    static constexpr int log2_side = block_bits::log2_side, side = block_bits::side, area = block_bits::area;

  private:
    /// A bit a sample, row by row.
    struct Bits {
        std::uint64_t open = ~std::uint64_t(0);
        std::uint64_t touched = 0;  ///< deposited into since the last clear()
        std::uint64_t split = 0;    ///< touched, and its lanes are kept: they may differ
    };

  public:
    /// Both must be below 2^15.
    void resize(int width, int height) {
        width_ = width;
        height_ = height;
        columns_ = (width + side - 1) >> log2_side;
        bits_.assign(std::size_t(columns_) * std::size_t((height + side - 1) >> log2_side), {});
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
        for_blocks(rect_, [&](std::size_t at, int, int) { bits_[at] = {}; });
        rect_ = {};
        has_begun_ = false;
    }

    /// Call this before the first deposit of a frame. The first frame of a size that has one takes the memory, of which
    /// systems give only what is written to. It is kept for smaller ones, and where there is not enough for a larger.
    void begin() {
        const std::size_t count = bits_.size() * area;
        if (count > room_) {
            first_deposit_.reset(new float[count]);
            lanes_.reset(new FarLanes[count]);
            samples_.reset(new Sample[count]);
            room_ = count;  // last: there is as much of each
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
        const First first = first_of(deposit);
        const int shift = (y & (side - 1)) * side;
        for (int column = begin >> log2_side; column <= (end - 1) >> log2_side; ++column) {
            const int left = column << log2_side;
            const Block block = block_of(column, y >> log2_side);
            const std::uint64_t wanted = block.bits.open & block_bits::in_row(begin - left, end - 1 - left) << shift;
            if (wanted == 0) continue;
            const std::uint64_t changed = depths.farther_in_row(left, y, wanted, q);
            into_whole(block, changed, deposit, first, [&](int i) { return q(left + (i & (side - 1))); });
        }
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
            if ((bits_.split & bit) != 0 ? deposit.into(s, lanes_[i]) : deposit.into(s)) bits_.open &= ~bit;
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
        return {bits_[at / area], &samples_[at], &lanes_[at], &first_deposit_[at], block_bits::of(x, y)};
    }
    /// Deposits a square: each lane of a sample gets its share by overlap, `loss` if it is covered whole. Edges are
    /// rounded to about 1/1000 of a sample, equal ones equally, so that adjoining squares cover nothing twice. The
    /// square is cut off at the picture's border.
    template <class Depths>
    void deposit_square(const Depths& depths, float left, float top, float right, float bottom, float q, Loss loss,
                        glm::vec3 rgb) {
        const native_lanes::Square at(left, top, right, bottom, whole_width_, whole_height_);
        if (at.is_empty()) return;
        if (!at.is_small()) return deposit_large(depths, left, top, right, bottom, q, loss, rgb);
        const SampleRect touched = inside(at.x0, at.y0, at.x1 + 1, at.y1 + 1);
        if (touched.is_empty()) return;
        if (at.x1 - at.x0 < few && at.y1 - at.y0 < few) return deposit_few(depths, at, touched, q, {loss, rgb});
        const Deposit deposit(loss, rgb);
        const int first_column = left_ - at.x0, first_row = top_ - at.y0;
        const SampleRect whole = inside(at.x0 + !at.starts_at_column(), at.y0 + !at.starts_at_row(),
                                        at.x1 + at.ends_at_column(), at.y1 + at.ends_at_row());
        const First first = whole.is_empty() ? First{} : first_of(deposit);
        add_to_rect(touched);
        for_blocks(touched, [&](std::size_t number, int x, int y) {
            const Block block = block_at(number);
            std::uint64_t wanted = block.bits.open & block_bits::inside(touched, x, y);
            if (wanted == 0) return;
            wanted = depths.farther(x, y, wanted, q);
            const std::uint64_t inner = whole.is_empty() ? 0 : wanted & block_bits::inside(whole, x, y);
            if (inner != 0) into_whole(block, inner, deposit, first, [q](int) { return q; });
            for (std::uint64_t left_over = wanted & ~inner; left_over != 0;) {
                const int row = std::countr_zero(left_over) >> log2_side;
                const auto rows = at.rows(y + row + first_row);
                std::uint64_t in_row = left_over & std::uint64_t(255) << row * side;
                left_over &= ~in_row;
                for (; in_row != 0; in_row &= in_row - 1) {
                    const int i = std::countr_zero(in_row);
                    block.split(i, q);
                    const auto columns = at.columns(x + (i & (side - 1)) + first_column);
                    if (deposit.into(block.samples[i], block.lanes[i], columns, rows)) block.close(i);
                }
            }
        });
    }

    /// Deposits something no larger than a lane: all of it goes into the lane that holds its center. `rgb()` is called
    /// only if that changes anything.
    template <class Depths, class Color>
    void deposit_in_lane(const Depths& depths, float x, float y, float area_covered, float q, Loss loss, Color&& rgb) {
        if (!(x >= 0 && y >= 0 && x < float(whole_width_) && y < float(whole_height_))) return;
        const int i = int(x) - left_, j = int(y) - top_;
        if (i < 0 || j < 0 || i >= width_ || j >= height_) return;
        const Block block = block_of(i >> log2_side, j >> log2_side);
        if ((block.bits.open & block_bits::of(i, j)) == 0 || q <= depths.depth(i, j)) return;
        add_to_rect({i, j, i + 1, j + 1});
        const int at = block_bits::number_of(i, j);
        block.split(at, q);
        const int column = int((x - float(int(x))) * float(lanes::side));
        const int line = int((y - float(int(y))) * float(lanes::side));
        if (one_lane_at_a_time::into_lane(block.samples[at], block.lanes[at], line * lanes::side + column,
                                          area_covered * float(lanes::count), loss, rgb())) {
            block.close(at);
        }
    }

    bool is_open(int x, int y) const { return (bits_at(x, y).open & block_bits::of(x, y)) != 0; }

    /// What lies behind this changes nothing in a sample that has geometry at `depth`.
    float settled_behind(float depth, int x, int y) const {
        return is_open(x, y) ? depth : std::max(depth, first_deposit_[index(x, y)]);
    }

    /// Whether something was deposited into a sample, or into one of a square of `size` x `size`, at most 8, from it
    /// on.
    bool is_touched(int x, int y) const { return (bits_at(x, y).touched & block_bits::of(x, y)) != 0; }
    bool is_touched(int x, int y, int size) const {
        const SampleRect square{x, y, x + size, y + size};
        std::uint64_t touched = 0;
        for_blocks(square, [&](std::size_t at, int left, int top) {
            touched |= bits_[at].touched & block_bits::inside(square, left, top);
        });
        return touched != 0;
    }

    /// The same of a block's samples, row by row.
    struct InBlock {
        std::uint64_t touched;       ///< a bit each; nothing is known of the others
        const Sample* samples;       ///< where something was deposited, as is the next
        const float* first_deposit;  ///< q of the first and nearest
    };
    InBlock block(std::size_t number) const {
        return {bits_[number].touched, samples_.get() + number * area, first_deposit_.get() + number * area};
    }

    /// The deposits into a sample, or null if there are none or if geometry that was drawn later, at `depth`, lies in
    /// front of the first.
    const Sample* over(float depth, int x, int y) const {
        if (!is_touched(x, y)) return nullptr;
        const std::size_t at = index(x, y);
        return first_deposit_[at] > depth ? &samples_[at] : nullptr;
    }

    /// Brings depths of [begin, end) of row y up to those of first deposits where these are nearer.
    void raise_to_first(int y, int begin, int end, float* depths) const {
        if (begin >= end || y < rect_.y0 || y >= rect_.y1) return;
        const SampleRect row{begin, y, end, y + 1};
        for_blocks(row, [&](std::size_t at, int left, int top) {
            for (std::uint64_t bits = bits_[at].touched & block_bits::inside(row, left, top); bits != 0;
                 bits &= bits - 1) {
                const int i = std::countr_zero(bits), x = left + (i & (side - 1)) - begin;
                depths[x] = std::max(depths[x], first_deposit_[at * area + std::size_t(i)]);
            }
        });
    }

    /// Calls f(x, y) for every sample that was deposited into.
    template <class F>
    void for_touched(F&& f) const {
        for_blocks(rect_, [&](std::size_t at, int left, int top) {
            for (std::uint64_t bits = bits_[at].touched; bits != 0; bits &= bits - 1) {
                const int i = std::countr_zero(bits);
                f(left + (i & (side - 1)), top + (i >> log2_side));
            }
        });
    }

  private:
    struct Block {
        Sample* samples;
        FarLanes* lanes;
        float* first_deposit;
        Bits& bits;

        void close(int i) const { bits.open &= ~(std::uint64_t(1) << i); }
        /// Keeps the lanes of a sample that a deposit at depth q is to change.
        FARFIELD_INLINE void split(int i, float q) const {
            const std::uint64_t bit = std::uint64_t(1) << i;
            if ((bits.split & bit) != 0) return;
            bits.split |= bit;
            if ((bits.touched & bit) != 0) return lanes[i].fill(std::uint16_t(lane_of(samples[i].transmittance)));
            bits.touched |= bit;
            first_deposit[i] = q;
            samples[i] = Sample::fresh();
            lanes[i].fill(detail::lanes::one);
        }
    };
    Block block_at(std::size_t number) {
        const std::size_t first = number * area;
        return {samples_.get() + first, lanes_.get() + first, first_deposit_.get() + first, bits_[number]};
    }
    Block block_of(int column, int row) { return block_at(block_index(column, row)); }

    /// What a deposit leaves of a sample that nothing was deposited into.
    struct First {
        Sample left;
        bool closes;
    };
    static First first_of(const Deposit& deposit) {
        First f{Sample::fresh(), false};
        f.closes = deposit.into(f.left);
        return f;
    }

    /// Deposits into samples of a block that are covered whole; q(i) is the depth at the i-th.
    template <class Depth>
    FARFIELD_INLINE static void into_whole(const Block& block, std::uint64_t changed, const Deposit& deposit,
                                           const First& first, const Depth& q) {
        const std::uint64_t fresh = changed & ~block.bits.touched;
        block.bits.touched |= fresh;
        if (first.closes) block.bits.open &= ~fresh;
        for (std::uint64_t left = fresh; left != 0; left &= left - 1) {
            const int i = std::countr_zero(left);
            block.samples[i] = first.left;
            block.first_deposit[i] = q(i);
        }
        for (std::uint64_t left = changed & ~fresh; left != 0; left &= left - 1) {
            const int i = std::countr_zero(left);
            const bool is_split = (block.bits.split >> i & 1) != 0;
            if (is_split ? deposit.into(block.samples[i], block.lanes[i]) : deposit.into(block.samples[i])) {
                block.close(i);
            }
        }
    }

    /// Squares that touch no more along each side cover few samples whole, and are not worth a look at blocks.
    static constexpr int few = 3;

    template <class Depths>
    FARFIELD_INLINE void deposit_few(const Depths& depths, const native_lanes::Square& at, const SampleRect& touched,
                                     float q, const Deposit& deposit) {
        for (int y = touched.y0 + 1; y < touched.y1; ++y) prefetch(touched.x0, touched.x1 - 1, y);
        add_to_rect(touched);
        for (int y = touched.y0; y < touched.y1; ++y) {
            const auto rows = at.rows(y + top_ - at.y0);
            for (int x = touched.x0; x < touched.x1; ++x) {
                const Block block = block_of(x >> log2_side, y >> log2_side);
                if ((block.bits.open & block_bits::of(x, y)) == 0 || q <= depths.depth(x, y)) continue;
                const int i = block_bits::number_of(x, y);
                block.split(i, q);
                const auto columns = at.columns(x + left_ - at.x0);
                if (deposit.into(block.samples[i], block.lanes[i], columns, rows)) block.close(i);
            }
        }
    }
    void prefetch(int first, int last, int y) {
        const std::size_t at = index(first, y);
        __builtin_prefetch(&samples_[at], 1);
        __builtin_prefetch(&lanes_[at], 1);
        __builtin_prefetch(&lanes_[index(last, y)], 1);
    }

    /// Splits the square into what covers samples whole and a border.
    template <class Depths>
    [[gnu::noinline]] void deposit_large(const Depths& depths, float left, float top, float right, float bottom,
                                         float q, Loss loss, glm::vec3 rgb) {
        const auto within_size = [](float at, int size) { return std::min(std::max(0.0f, at), float(size)); };
        left = within_size(left, whole_width_), right = within_size(right, whole_width_);
        top = within_size(top, whole_height_), bottom = within_size(bottom, whole_height_);
        const float x0 = std::min(std::ceil(left), right), x1 = std::max(std::floor(right), x0);
        const float y0 = std::min(std::ceil(top), bottom), y1 = std::max(std::floor(bottom), y0);
        const auto deposit_border = [&](float x, float y, float end_x, float end_y) {
            constexpr float step = lanes::most_samples - 1;
            while (x < end_x && y < end_y) {
                const float next_x = std::min(std::floor(x) + step, end_x);
                const float next_y = std::min(std::floor(y) + step, end_y);
                deposit_square(depths, x, y, next_x, next_y, q, loss, rgb);
                end_x - x > end_y - y ? x = next_x : y = next_y;
            }
        };
        deposit_border(left, top, right, y0);
        deposit_border(left, y0, x0, y1);
        deposit_border(x1, y0, right, y1);
        deposit_border(left, y1, right, bottom);
        const SampleRect whole = inside(int(x0), int(y0), int(x1), int(y1));
        if (whole.is_empty()) return;
        rect_.add(whole);
        const Deposit deposit(loss, rgb);
        const First first = first_of(deposit);
        for_blocks(whole, [&](std::size_t number, int x, int y) {
            const Block block = block_at(number);
            std::uint64_t changed = block.bits.open & block_bits::inside(whole, x, y);
            if (changed != 0) changed = depths.farther(x, y, changed, q);
            into_whole(block, changed, deposit, first, [q](int) { return q; });
        });
    }

    /// Part of a rectangle of the whole picture, in samples of this one.
    SampleRect inside(int x0, int y0, int x1, int y1) const {
        return {std::max(x0 - left_, 0), std::max(y0 - top_, 0), std::min(x1 - left_, width_),
                std::min(y1 - top_, height_)};
    }
    void add_to_rect(const SampleRect& r) {
        if (r.x0 < rect_.x0 || r.y0 < rect_.y0 || r.x1 > rect_.x1 || r.y1 > rect_.y1) rect_.add(r);
    }

    /// Calls f(number of the block, x, y of its first sample) for each block that a rectangle touches.
    template <class F>
    FARFIELD_INLINE void for_blocks(const SampleRect& r, F&& f) const {
        if (r.is_empty()) return;
        for (int row = r.y0 >> log2_side; row <= (r.y1 - 1) >> log2_side; ++row) {
            for (int column = r.x0 >> log2_side; column <= (r.x1 - 1) >> log2_side; ++column) {
                f(block_index(column, row), column << log2_side, row << log2_side);
            }
        }
    }
    std::size_t block_index(int column, int row) const {
        return std::size_t(row) * std::size_t(columns_) + std::size_t(column);
    }
    std::size_t index(int x, int y) const {
        return block_index(x >> log2_side, y >> log2_side) * area + std::size_t(block_bits::number_of(x, y));
    }
    const Bits& bits_at(int x, int y) const { return bits_[block_index(x >> log2_side, y >> log2_side)]; }

    int width_ = 0, height_ = 0, columns_ = 0;
    int left_ = 0, top_ = 0, whole_width_ = 0, whole_height_ = 0;
    // Block by block, and as `bits_` says:
    std::size_t room_ = 0;                    ///< of each of these, for so many samples
    std::unique_ptr<Sample[]> samples_;       ///< those touched
    std::unique_ptr<FarLanes[]> lanes_;       ///< those split
    std::unique_ptr<float[]> first_deposit_;  ///< q of the first and nearest, for samples touched
    std::vector<Bits> bits_;                  ///< a block each
    SampleRect rect_;
    bool has_begun_ = false;
};

}  // namespace farfield::detail
