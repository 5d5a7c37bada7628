// The box filter of coverage masks: a pixel is the mean of its 64 samples, each color weighted by the number of bits in
// its mask (L. Carpenter, "The A-buffer, an Antialiased Hidden Surface Method", SIGGRAPH 1984; N. Greene, "Hierarchical
// Polygon Tiling with Coverage Masks", SIGGRAPH 1996, sections 4.1 and 4.4).
#pragma once

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

namespace farfield {

/// Number of bits set. Without an instruction for it, std::popcount is a call.
inline int bit_count(std::uint64_t bits) {
#if defined(__x86_64__) && !defined(__POPCNT__)
    bits -= bits >> 1 & 0x5555555555555555u;
    bits = (bits & 0x3333333333333333u) + (bits >> 2 & 0x3333333333333333u);
    return int(((bits + (bits >> 4)) & 0x0f0f0f0f0f0f0f0fu) * 0x0101010101010101u >> 56);
#else
    return std::popcount(bits);
#endif
}

/// Sums of 16 bits a channel. In a frame, every sample of every pixel comes exactly once, in any order: then the
/// picture does not depend on the order, and its channels are (sum + 32) >> 6. What no sample comes for keeps what an
/// earlier frame left there.
///
/// Blocks are aligned ones of 8 x 8 pixels, row by row, those of the right and the lower border being whole. A block of
/// one color is a tag, and its sums are not written; drawing into a block pixel by pixel wants open_block() before. The
/// functions that take coordinates see to it themselves.
class BoxFilter {
  public:
    static constexpr int block_side_px = detail::PixelBlocks::side_px;
    /// Whether there are functions that take indices.
    static constexpr bool has_blocks = true;

    /// A new frame. Clears nothing.
    void begin(int width_px, int height_px) {
        if (blocks_.resize(width_px, height_px)) sums_.assign(blocks_.count() * 64, 0);
    }

    /// Some samples of a pixel of the image; bit 8 * row + column. `first`: none came before in this frame.
    void add(int x, int y, std::uint64_t samples, Rgba8 premultiplied, bool first) {
        blocks_.open(block_of(x, y));
        add_at(index_of(x, y), bit_count(samples), premultiplied, first);
    }
    /// All samples of a rectangle of whole blocks. It may reach beyond the right and the lower border, and ends there.
    void fill(int x, int y, int width_px, int height_px, Rgba8 premultiplied) {
        blocks_.fill(x, y, width_px, height_px, premultiplied);
    }
    /// All samples of some pixels of the block that has (x, y) at its upper left; bit 8 * row + column.
    void fill_pixels(int x, int y, std::uint64_t pixels, Rgba8 premultiplied) {
        blocks_.open(block_of(x, y));
        fill_pixels(block_of(x, y), pixels, premultiplied);
    }

    std::size_t block_of(int x, int y) const { return blocks_.block_of(x, y); }
    /// 64 * block + 8 * row + column.
    std::size_t index_of(int x, int y) const { return blocks_.index_of(x, y); }

    /// Before the first pixel of a block in a frame; any number of times, but not after fill_block().
    FARFIELD_INLINE void open_block(std::size_t block) { blocks_.open(block); }
    FARFIELD_INLINE void fill_block(std::size_t block, Rgba8 premultiplied) { blocks_.fill(block, premultiplied); }
    /// `count` samples of a pixel of an open block.
    FARFIELD_INLINE void add_at(std::size_t index, int count, Rgba8 premultiplied, bool first) {
        sums_[index] = (first ? 0 : sums_[index]) + spread(premultiplied) * std::uint64_t(count);
    }
    /// Adds to a pixel of an open block what is no sample: channels are of 0 to 255 * 64, and rounded down; all sums
    /// must stay below that.
    void add_sum(std::size_t index, glm::vec4 sum) {
        sums_[index] +=
            std::uint64_t(sum.r) | std::uint64_t(sum.g) << 16 | std::uint64_t(sum.b) << 32 | std::uint64_t(sum.a) << 48;
    }
    /// All samples of some pixels of an open block.
    FARFIELD_INLINE void fill_pixels(std::size_t block, std::uint64_t pixels, Rgba8 premultiplied) {
        detail::store_selected(&sums_[block * 64], pixels, spread(premultiplied) << 6);
    }

    /// All samples of some pixels of a row of an open block, the first of which is `index`.
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

    /// Writes every pixel. Any number of times a frame.
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
    /// Each channel in 16 bits, in the order that they have in memory.
    static std::uint64_t spread(Rgba8 c) {
        std::uint64_t bits = std::bit_cast<std::uint32_t>(c);
        bits = (bits | bits << 16) & 0x0000ffff0000ffffu;
        return (bits | bits << 8) & 0x00ff00ff00ff00ffu;
    }

    detail::PixelBlocks blocks_;
    std::vector<std::uint64_t> sums_;  ///< of the pixels of open blocks; channels are below 2^14
};

}  // namespace farfield
