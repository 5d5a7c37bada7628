// Which samples of a block of 8 x 8 are meant: a bit each, row by row.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstdint>

#include "farfield/raster/sample_rect.hpp"

namespace farfield::detail::block_bits {

inline constexpr int log2_side = 3, side = 1 << log2_side, area = side * side;

/// Of a sample of the picture in its block.
constexpr int number_of(int x, int y) {
    return (y & (side - 1)) * side + (x & (side - 1));
}
constexpr std::uint64_t of(int x, int y) {
    return std::uint64_t(1) << number_of(x, y);
}

/// Of a block's first row, ends included; these may lie beyond the block.
constexpr std::uint64_t in_row(int first, int last) {
    return 255u << std::max(first, 0) & 255u >> (side - 1 - std::min(last, side - 1));
}

/// Those inside a rectangle, of the block whose first sample is (x, y).
constexpr std::uint64_t inside(const SampleRect& r, int x, int y) {
    if (r.x0 >= x + side || r.x1 <= x || r.y0 >= y + side || r.y1 <= y) return 0;
    const int low = std::max(r.y0 - y, 0) * side, high = std::min(r.y1 - y, side) * side - 1;
    const std::uint64_t rows = ~std::uint64_t(0) << low & ~std::uint64_t(0) >> (area - 1 - high);
    return in_row(r.x0 - x, r.x1 - 1 - x) * 0x0101010101010101u & rows;
}

}  // namespace farfield::detail::block_bits
