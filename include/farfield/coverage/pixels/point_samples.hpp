// The image of coverage masks where one sample is one pixel: each mask at the finest level is a block of 8 x 8 pixels,
// and colors do not accumulate (Greene 1996, section 4.5).
#pragma once

#include "farfield/settings.hpp"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "farfield/coverage/pixels/pixel_blocks.hpp"
#include "farfield/geometry/rgba8.hpp"
#include "farfield/image.hpp"
#include "farfield/simd.hpp"

namespace farfield {

/// In a frame every pixel comes exactly once, those of the background last; others keep an earlier frame's color.
/// Blocks are those of BoxFilter; bit 8 * row + column of a mask is a pixel, and those beyond the image are ignored.
/// Rows are put together at the end: writing them at once doubled the time of filled blocks.
class PointSamples {
  public:
    static constexpr int block_side_px = detail::PixelBlocks::side_px;
    static constexpr bool has_blocks = true;

    /// Begins a frame; clears nothing.
    void begin(int width_px, int height_px) { blocks_.resize(width_px, height_px, pixels_); }

    std::size_t block_of(int x, int y) const { return blocks_.block_of(x, y); }

    /// Adds some pixels of a block that has not been filled.
    template <class Stores = detail::PortableStores>
    FARFIELD_INLINE void add(std::size_t block, std::uint64_t pixels, Rgba8 premultiplied) {
        blocks_.open(block);
        Stores::store_selected(&pixels_[block * 64], pixels, std::bit_cast<std::uint32_t>(premultiplied));
    }
    /// Adds all pixels of a block.
    void fill_block(std::size_t block, Rgba8 premultiplied) { blocks_.fill(block, premultiplied); }
    /// Adds all pixels of a rectangle of whole blocks, which is cut off at the right and the lower border.
    void fill(int x, int y, int width_px, int height_px, Rgba8 premultiplied) {
        blocks_.fill(x, y, width_px, height_px, premultiplied);
    }

    /// Writes every pixel; may be repeated in a frame.
    void resolve(Image& image) const {
        blocks_.resolve(image, [pixels = pixels_.data()](std::size_t index, Rgba8* out) {
            detail::PixelBlocks::prefetch_beyond(pixels + index, 4 * 64 * sizeof *pixels);
            std::memcpy(static_cast<void*>(out), pixels + index, 8 * sizeof *pixels);
        });
    }

  private:
    detail::PixelBlocks blocks_;
    std::vector<std::uint32_t> pixels_;  ///< for open blocks: colors as they lie in memory
};

}  // namespace farfield
