// The pixels of an image block by block, where a block of one color is only a tag: the common part of BoxFilter and
// PointSamples.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "farfield/geometry/rgba8.hpp"
#include "farfield/image.hpp"
#include "farfield/raster/made_for.hpp"
#include "farfield/simd.hpp"

namespace farfield::detail {

/// The pixels of an aligned block of 8 x 8 have indices from 64 * block on, row by row; blocks are row by row too, and
/// those at the right and the lower border are whole. A tag is a block's color or says that the block is open: its
/// pixels are then kept elsewhere.
class PixelBlocks {
  public:
    static constexpr int side_px = 8;

    /// If the size changed, every block is transparent black, and so are `open_pixels`: the caller's, for open blocks.
    template <class Pixel>
    void resize(int width_px, int height_px, std::vector<Pixel>& open_pixels) {
        made_for_({width_px, height_px}, [&] {
            width_ = width_px;
            height_ = height_px;
            columns_ = blocks_of(width_px);
            tags_.assign(columns_ * blocks_of(height_px), 0);
            open_pixels.assign(tags_.size() * 64, 0);
        });
    }

    std::size_t block_of(int x, int y) const { return std::size_t(y >> 3) * columns_ + std::size_t(x >> 3); }
    std::size_t index_of(int x, int y) const { return block_of(x, y) * 64 + std::size_t((y & 7) * 8 + (x & 7)); }

    void open(std::size_t block) { tags_[block] = is_open; }
    void fill(std::size_t block, Rgba8 color) { tags_[block] = std::bit_cast<std::uint32_t>(color); }
    /// Fills a rectangle of whole blocks, which is cut off at the right and the lower border.
    void fill(int x, int y, int width_px, int height_px, Rgba8 color) {
        if (x >= width_) return;
        const std::size_t columns = blocks_of(std::min(x + width_px, width_)) - std::size_t(x >> 3);
        for (int row = y; row < std::min(y + height_px, height_); row += side_px) {
            std::fill_n(tags_.begin() + std::ptrdiff_t(block_of(x, row)), columns, std::bit_cast<std::uint32_t>(color));
        }
    }

    /// Writes every pixel; write_row(index, out) makes eight of an open block, from `index` on.
    template <class WriteRow>
    void resolve(Image& image, WriteRow&& write_row) const {
        if (image.width() != width_ || image.height() != height_) image = Image(width_, height_);
        const auto stride = std::size_t(width_);
        for (int y = 0; y < height_; y += side_px) {
            const auto rows = std::size_t(std::min(height_ - y, side_px));
            Rgba8* out = image.pixels().data() + std::size_t(y) * stride;
            std::size_t block = block_of(0, y);
            for (int x = 0; x + side_px <= width_; x += side_px, ++block, out += side_px) {
                resolve_block(block, rows, out, stride, write_row);
            }
            if (const auto rest = std::size_t(width_ % side_px); rest != 0) {
                Rgba8 pixels[64];
                resolve_block(block, rows, pixels, side_px, write_row);
                for (std::size_t row = 0; row < rows; ++row) std::copy_n(pixels + row * 8, rest, out + row * stride);
            }
        }
    }

    /// Prefetches the line `bytes` after `p`. Hardware does not foresee eight rows at a time; without this it takes
    /// twice as long.
    static void prefetch_beyond(const void* p, std::size_t bytes) {
        __builtin_prefetch(reinterpret_cast<const void*>(reinterpret_cast<std::uintptr_t>(p) + bytes));
    }

  private:
    static constexpr std::uint64_t is_open = ~std::uint64_t(0);

    static std::size_t blocks_of(int pixels) { return std::size_t((pixels + side_px - 1) / side_px); }

    template <class WriteRow>
    void resolve_block(std::size_t block, std::size_t rows, Rgba8* out, std::size_t stride,
                       WriteRow&& write_row) const {
        const std::uint64_t tag = tags_[block];
        if (tag == is_open) {
            for (std::size_t row = 0; row < rows; ++row, out += stride) {
                prefetch_beyond(out, 128);
                write_row(block * 64 + row * 8, out);
            }
        } else {
            const std::uint64_t two = tag | tag << 32;
            for (std::size_t row = 0; row < rows; ++row, out += stride) {
                prefetch_beyond(out, 128);
                for (unsigned i = 0; i < 8; i += 2) std::memcpy(static_cast<void*>(out + i), &two, sizeof two);
            }
        }
    }

    MadeFor<BufferSize> made_for_;
    int width_ = 0, height_ = 0;
    std::size_t columns_ = 0;
    std::vector<std::uint64_t> tags_;  ///< the color as it lies in memory, or is_open
};

/// select_of_four[bits] is four words; the i-th has all bits set where bit i is.
template <class Word>
inline constexpr auto select_of_four = [] {
    std::array<std::array<Word, 4>, 16> table{};
    for (unsigned bits = 0; bits < 16; ++bits) {
        for (unsigned i = 0; i < 4; ++i) table[bits][i] = (bits >> i & 1) != 0 ? Word(~Word(0)) : Word(0);
    }
    return table;
}();

/// Writes to the words of a block; the tiler has the same for processors that can store selected words.
struct PortableStores {
    /// Sets the words whose bits are set to `value`. Loading and storing all four is faster than choosing.
    template <class Word>
    FARFIELD_INLINE static void store_selected(Word* words, std::uint64_t bits, Word value) {
        for (; bits != 0; bits >>= 4, words += 4) {
            const auto& select = select_of_four<Word>[bits & 15];
            Word four[4];
            std::memcpy(four, words, sizeof four);
            for (unsigned i = 0; i < 4; ++i) four[i] ^= (four[i] ^ value) & select[i];
            std::memcpy(words, four, sizeof four);
        }
    }
};

}  // namespace farfield::detail
