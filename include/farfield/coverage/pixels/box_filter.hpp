// The box filter of coverage masks: a pixel is the mean of its 64 samples, each color weighted by the number of bits in
// its mask (L. Carpenter, "The A-buffer, an Antialiased Hidden Surface Method", SIGGRAPH 1984; N. Greene, "Hierarchical
// Polygon Tiling with Coverage Masks", SIGGRAPH 1996, sections 4.1 and 4.4).
#pragma once

#include "farfield/settings.hpp"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/vec4.hpp>
#include <vector>

#include "farfield/coverage/pixels/pixel_blocks.hpp"
#include "farfield/geometry/rgba8.hpp"
#include "farfield/image.hpp"
#include "farfield/simd.hpp"

namespace farfield {

/// The number of bits set. Without an instruction for it, std::popcount is a call.
inline int bit_count(std::uint64_t bits) {
#if defined(__x86_64__) && !defined(__POPCNT__)
    bits -= bits >> 1 & 0x5555555555555555u;
    bits = (bits & 0x3333333333333333u) + (bits >> 2 & 0x3333333333333333u);
    return int(((bits + (bits >> 4)) & 0x0f0f0f0f0f0f0f0fu) * 0x0101010101010101u >> 56);
#else
    return std::popcount(bits);
#endif
}

/// Sums have 16 bits a channel. In a frame, every sample of every pixel must come exactly once, in any order: then the
/// picture does not depend on the order, and its channels are (sum + 32) >> 6. Pixels without samples keep what an
/// earlier frame left there.
///
/// Blocks are aligned 8 x 8 pixels, row by row; those at the right and the lower border are whole. A block of one color
/// is a tag, and its sums are not written; call open_block() before drawing into one pixel by pixel. Functions that
/// take coordinates do so themselves.
class BoxFilter {
  public:
    static constexpr int block_side_px = detail::PixelBlocks::side_px;
    /// Says that there are functions that take indices.
    static constexpr bool has_blocks = true;

    /// Begins a frame; clears nothing.
    void begin(int width_px, int height_px) { blocks_.resize(width_px, height_px, sums_); }

    /// Adds some samples of a pixel, as bits 8 * row + column. `first`: none came before in this frame.
    void add(int x, int y, std::uint64_t samples, Rgba8 premultiplied, bool first) {
        blocks_.open(block_of(x, y));
        add_at(index_of(x, y), bit_count(samples), premultiplied, first);
    }
    /// Adds all samples of a rectangle of whole blocks, which is cut off at the right and the lower border.
    void fill(int x, int y, int width_px, int height_px, Rgba8 premultiplied) {
        blocks_.fill(x, y, width_px, height_px, premultiplied);
    }
    /// Adds all samples of some pixels, as bits 8 * row + column, of the block that has (x, y) at its upper left.
    void fill_pixels(int x, int y, std::uint64_t pixels, Rgba8 premultiplied) {
        blocks_.open(block_of(x, y));
        fill_pixels(block_of(x, y), pixels, premultiplied);
    }

    std::size_t block_of(int x, int y) const { return blocks_.block_of(x, y); }
    /// The index of a pixel: 64 * block + 8 * row + column.
    std::size_t index_of(int x, int y) const { return blocks_.index_of(x, y); }

    /// Call this before the first pixel of a block in a frame; repeating it is harmless, but not after fill_block().
    FARFIELD_INLINE void open_block(std::size_t block) { blocks_.open(block); }
    FARFIELD_INLINE void fill_block(std::size_t block, Rgba8 premultiplied) { blocks_.fill(block, premultiplied); }
    /// Adds `count` samples of a pixel of an open block.
    FARFIELD_INLINE void add_at(std::size_t index, int count, Rgba8 premultiplied, bool first) {
        sums_[index] = (first ? 0 : sums_[index]) + spread(premultiplied) * std::uint64_t(count);
    }
    /// Sets the sum of all samples of a pixel of an open block: of spread() times how many have that color.
    FARFIELD_INLINE void set_sum(std::size_t index, std::uint64_t sum) { sums_[index] = sum; }
    /// Adds a color other than samples' to a pixel of an open block: channels from 0 to 255 * 64, rounded down. Sums
    /// must not exceed that.
    void add_sum(std::size_t index, glm::vec4 sum) {
        sums_[index] +=
            std::uint64_t(sum.x) | std::uint64_t(sum.y) << 16 | std::uint64_t(sum.z) << 32 | std::uint64_t(sum.w) << 48;
    }
    /// Adds all samples of some pixels of an open block.
    template <class Stores = detail::PortableStores>
    FARFIELD_INLINE void fill_pixels(std::size_t block, std::uint64_t pixels, Rgba8 premultiplied) {
        Stores::store_selected(&sums_[block * 64], pixels, spread(premultiplied) << 6);
    }

    /// Adds all samples of some pixels of a row of an open block that begins at `index`.
    FARFIELD_INLINE void fill_row(std::size_t index, unsigned pixels, const std::array<Rgba8, 8>& premultiplied) {
        std::uint8_t channels[32];
        std::uint16_t sums[32];
        std::memcpy(channels, premultiplied.data(), sizeof channels);
        for (int i = 0; i < 32; ++i) sums[i] = std::uint16_t(channels[i] << 6);
        if (pixels == 255) {
            std::memcpy(&sums_[index], sums, sizeof sums);
            return;
        }
        for (std::size_t i = 0; i < 8; ++i) {
            if ((pixels >> i & 1) != 0) std::memcpy(&sums_[index + i], sums + 4 * i, sizeof sums_[index]);
        }
    }

    /// Spreads the channels to 16 bits each, in their order in memory.
    FARFIELD_INLINE static std::uint64_t spread(Rgba8 c) {
        std::uint64_t bits = std::bit_cast<std::uint32_t>(c);
        bits = (bits | bits << 16) & 0x0000ffff0000ffffu;
        return (bits | bits << 8) & 0x00ff00ff00ff00ffu;
    }

    /// Writes every pixel; may be repeated in a frame.
    void resolve(Image& image) const {
        blocks_.resolve(image, [sums = sums_.data()](std::size_t index, Rgba8* out) {
            detail::PixelBlocks::prefetch_beyond(sums + index, 4 * 64 * sizeof *sums);
            std::uint16_t sum[32];
            std::uint8_t mean[32];
            std::memcpy(sum, sums + index, sizeof sum);
            for (int i = 0; i < 32; ++i) mean[i] = std::uint8_t(std::uint16_t(sum[i] + 32) >> 6);
            std::memcpy(static_cast<void*>(out), mean, sizeof mean);
        });
    }

  private:
    detail::PixelBlocks blocks_;
    std::vector<std::uint64_t> sums_;  ///< for pixels of open blocks; channels are below 2^14
};

}  // namespace farfield
