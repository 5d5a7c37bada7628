// Depth and color of samples, in blocks of 8 x 8 that lie together in memory.
//
// A block that one surface covers keeps that surface instead of its samples, as graphics processors compress depth: J.
// Hasselgren, T. Akenine-Moller, "Efficient Depth Buffer Compression", Graphics Hardware 2006, section 3. The samples
// are made from it, bit for bit, once something covers a part of the block. A large triangle thus writes one record
// where a plain z-buffer writes 64 depths and 64 colors, and a hidden one reads a single number: at 64 samples a pixel,
// memory is what a z-buffer waits for.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "farfield/geometry/rgba8.hpp"
#include "farfield/raster/sample_rect.hpp"
#include "farfield/raster/scan_conversion.hpp"
#include "farfield/simd.hpp"

namespace farfield::detail {

/// Samples are addressed from the upper left one. Depth is q, larger when nearer; where nothing was drawn it is
/// -infinity. The last blocks of a row or a column may reach beyond the picture.
class SampleBlocks {
  public:
    static constexpr int log2_side = 3, side = 1 << log2_side, area = side * side;

    /// What is known of a block, if it was drawn to in this frame.
    struct alignas(64) Block {
        std::uint32_t frame = 0;  ///< the one in which it was drawn to last
        bool is_surface = false;  ///< else its samples count
        std::uint8_t fills = 0;   ///< since farthest() was exact
        float nearest = 0;        ///< no sample of it has a larger q
        Rgba8 color{0, 0, 0, 0};  ///< of the surface
        DepthPlane plane{};       ///< of the surface, relative to the center sample
    };
    /// Row by row.
    struct alignas(64) Samples {
        float depth[area];
        Rgba8 color[area];
    };

    void resize(int width, int height, Rgba8 background) {
        width_ = width;
        height_ = height;
        columns_ = (width + side - 1) >> log2_side;
        background_ = background;
        const std::size_t count = std::size_t(columns_) * std::size_t((height + side - 1) >> log2_side);
        farthest_.assign(count, nothing);
        blocks_.assign(count, {});
        samples_.resize(count);
        drawn_ = {};
        frame_ = 1;
    }
    /// Forgets what was drawn.
    void clear() {
        if (!drawn_.is_empty()) {
            for (int row = drawn_.y0 >> log2_side; row <= (drawn_.y1 - 1) >> log2_side; ++row) {
                std::fill(farthest_.begin() + std::ptrdiff_t(index(drawn_.x0 >> log2_side, row)),
                          farthest_.begin() + std::ptrdiff_t(index((drawn_.x1 - 1) >> log2_side, row)) + 1, nothing);
            }
        }
        drawn_ = {};
        if (++frame_ != 0) return;
        for (Block& b : blocks_) b.frame = 0;
        frame_ = 1;
    }
    /// Says where the upper left sample lies, relative to the center sample.
    void place(int first_x, int first_y) {
        first_x_ = first_x;
        first_y_ = first_y;
    }

    int width() const { return width_; }
    int height() const { return height_; }
    int columns() const { return columns_; }
    /// A rectangle that holds all samples drawn.
    const SampleRect& drawn() const { return drawn_; }
    void add_drawn(int x0, int y0, int x1, int y1) { drawn_.add(x0, y0, x1, y1); }

    std::size_t index(int column, int row) const {
        return std::size_t(row) * std::size_t(columns_) + std::size_t(column);
    }
    Block& block(std::size_t at) { return blocks_[at]; }
    const Block& block(std::size_t at) const { return blocks_[at]; }
    bool is_drawn(const Block& b) const { return b.frame == frame_; }
    const Samples& samples(std::size_t at) const { return samples_[at]; }

    /// A bound: no sample of the block inside the picture has a smaller q.
    float farthest(std::size_t at) const { return farthest_[at]; }
    /// The same, exact.
    float exact_farthest(std::size_t at) {
        if (blocks_[at].frame == frame_ && blocks_[at].fills != 0) refresh(at);
        return farthest_[at];
    }

    /// The block is now covered by one surface, whose q lies in [farthest, nearest].
    void set_surface(std::size_t at, const DepthPlane& plane, Rgba8 color, float farthest, float nearest) {
        blocks_[at] = {frame_, true, 0, nearest, color, plane};
        farthest_[at] = farthest;
    }

    /// The block's samples, which from now on count. Whoever writes them calls filled() then.
    FARFIELD_INLINE Samples& opened(std::size_t at, int column, int row) {
        if (blocks_[at].frame != frame_ || blocks_[at].is_surface) open(at, column, row);
        return samples_[at];
    }
    /// Samples of the block have come nearer, up to `nearest`.
    FARFIELD_INLINE void filled(std::size_t at, float nearest) {
        Block& b = blocks_[at];
        b.nearest = std::max(b.nearest, nearest);
        // Looking at all samples costs as much as a few small triangles.
        if (++b.fills >= 8) refresh(at);
    }

    /// The same, where many have: a bound is worth what it takes.
    FARFIELD_INLINE void filled_much(std::size_t at, float nearest) {
        blocks_[at].nearest = std::max(blocks_[at].nearest, nearest);
        refresh(at);
    }

    struct Sample {
        float depth;
        Rgba8 color;
    };
    Sample sample(int x, int y) const {
        const std::size_t at = index(x >> log2_side, y >> log2_side);
        const Block& b = blocks_[at];
        if (b.frame != frame_) return {nothing, background_};
        if (b.is_surface) return {b.plane.at(b.plane.row(y + first_y_), x + first_x_), b.color};
        return {samples_[at].depth[within(x, y)], samples_[at].color[within(x, y)]};
    }
    float depth(int x, int y) const {
        const std::size_t at = index(x >> log2_side, y >> log2_side);
        const Block& b = blocks_[at];
        if (b.frame != frame_) return nothing;
        if (b.is_surface) return b.plane.at(b.plane.row(y + first_y_), x + first_x_);
        return samples_[at].depth[within(x, y)];
    }
    Rgba8 color(int x, int y) const {
        const std::size_t at = index(x >> log2_side, y >> log2_side);
        const Block& b = blocks_[at];
        if (b.frame != frame_) return background_;
        return b.is_surface ? b.color : samples_[at].color[within(x, y)];
    }
    /// Gives the depths of [begin, end) of a row.
    void depths(int y, int begin, int end, float* out) const {
        for (int x = begin; x < end;) {
            const int next = std::min((x | (side - 1)) + 1, end);
            const std::size_t at = index(x >> log2_side, y >> log2_side);
            const Block& b = blocks_[at];
            if (b.frame != frame_) {
                std::fill(out, out + (next - x), nothing);
            } else if (b.is_surface) {
                const float along = b.plane.row(y + first_y_);
                for (int i = x; i < next; ++i) out[i - x] = b.plane.at(along, i + first_x_);
            } else {
                std::copy_n(samples_[at].depth + within(x, y), next - x, out);
            }
            out += next - x;
            x = next;
        }
    }
    /// Gives the colors of [begin, end) of a row.
    void colors(int y, int begin, int end, Rgba8* out) const {
        for (int x = begin; x < end;) {
            const int next = std::min((x | (side - 1)) + 1, end);
            const std::size_t at = index(x >> log2_side, y >> log2_side);
            const Block& b = blocks_[at];
            if (b.frame != frame_ || b.is_surface) {
                std::fill(out, out + (next - x), b.frame != frame_ ? background_ : b.color);
            } else {
                std::copy_n(samples_[at].color + within(x, y), next - x, out);
            }
            out += next - x;
            x = next;
        }
    }

    /// Which samples of the block whose first sample is (x, y) are farther than q: a bit each, row by row. Only those
    /// `wanted` are looked at, which lie in the picture.
    FARFIELD_INLINE std::uint64_t farther(int x, int y, std::uint64_t wanted, float q) const {
        const std::size_t at = index(x >> log2_side, y >> log2_side);
        const Block& b = blocks_[at];
        if (b.frame != frame_ || q > b.nearest) return wanted;
        if (q <= farthest_[at]) return 0;
        return each_farther(x, y, wanted, [q](int) { return q; });
    }
    /// The same for samples of row y alone, where q(x) does not both rise and fall within them.
    template <class Depth>
    std::uint64_t farther_in_row(int x, int y, std::uint64_t wanted, const Depth& q) const {
        const std::size_t at = index(x >> log2_side, y >> log2_side);
        const Block& b = blocks_[at];
        if (b.frame != frame_) return wanted;
        const auto [least, most] = std::minmax({q(x), q(x + side - 1)});
        if (least > b.nearest) return wanted;
        if (most <= farthest_[at]) return 0;
        return each_farther(x, y & -side, wanted, q);
    }

  private:
    typedef float Floats __attribute__((vector_size(16)));
    static constexpr float nothing = -std::numeric_limits<float>::infinity();

    static std::size_t within(int x, int y) { return std::size_t(y & (side - 1)) * side + std::size_t(x & (side - 1)); }

    /// Of a block that was drawn to.
    template <class Depth>
    std::uint64_t each_farther(int x, int y, std::uint64_t wanted, const Depth& q) const {
        const std::size_t at = index(x >> log2_side, y >> log2_side);
        const Block& b = blocks_[at];
        std::uint64_t farther = wanted;
        for (std::uint64_t left = wanted; left != 0; left &= left - 1) {
            const int i = std::countr_zero(left), in_row = x + (i & (side - 1));
            const float depth = b.is_surface
                                    ? b.plane.at(b.plane.row(y + (i >> log2_side) + first_y_), in_row + first_x_)
                                    : samples_[at].depth[i];
            if (q(in_row) <= depth) farther &= ~(left & -left);
        }
        return farther;
    }

    [[gnu::noinline]] void open(std::size_t at, int column, int row) {
        Block& b = blocks_[at];
        Samples& s = samples_[at];
        const bool is_surface = b.frame == frame_;
        if (is_surface) {
            for (int y = 0; y < side; ++y) {
                const float along = b.plane.row(row * side + y + first_y_);
                for (int x = 0; x < side; ++x) {
                    s.depth[y * side + x] = b.plane.at(along, column * side + x + first_x_);
                }
            }
        } else {
            std::fill(s.depth, s.depth + area, nothing);
            b = {frame_, false, 0, nothing, background_, {}};
        }
        std::fill(s.color, s.color + area, b.color);
        b.is_surface = false;
        // Nothing lies beyond the picture, and nothing there keeps a block from hiding what is behind it.
        const int columns_inside = width_ - column * side, rows_inside = height_ - row * side;
        if (columns_inside >= side && rows_inside >= side) return;
        for (int y = 0; y < side; ++y) {
            for (int x = 0; x < side; ++x) {
                if (x >= columns_inside || y >= rows_inside) {
                    s.depth[y * side + x] = std::numeric_limits<float>::infinity();
                }
            }
        }
    }

    FARFIELD_INLINE void refresh(std::size_t at) {
        const float* depth = samples_[at].depth;
        Floats least[2];
        __builtin_memcpy(least, depth, sizeof least);
        for (int i = side; i < area; i += side) {
            Floats next[2];
            __builtin_memcpy(next, depth + i, sizeof next);
            least[0] = next[0] < least[0] ? next[0] : least[0];
            least[1] = next[1] < least[1] ? next[1] : least[1];
        }
        least[0] = least[1] < least[0] ? least[1] : least[0];
        farthest_[at] = std::min(std::min(least[0][0], least[0][1]), std::min(least[0][2], least[0][3]));
        blocks_[at].fills = 0;
    }

    int width_ = 0, height_ = 0, columns_ = 0;
    int first_x_ = 0, first_y_ = 0;
    Rgba8 background_{0, 0, 0, 0};
    std::uint32_t frame_ = 1;
    std::vector<float> farthest_;  ///< apart from the blocks, as a hidden triangle needs no more
    std::vector<Block> blocks_;
    std::vector<Samples> samples_;
    SampleRect drawn_;
};

}  // namespace farfield::detail
