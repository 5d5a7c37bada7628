// A chessboard of as many polygons as asked for on the same ground: what Klein et al. 2002 measure the growth of time
// with (section 7.2: black and white polygons, fixed dimensions, 80,000 to 320 million).
#pragma once

#include <cstdint>

#include "farfield/view.hpp"
#include "scenes/scene.hpp"

namespace farfield::scenes {

struct ChessboardOptions {
    /// Wanted; the board has the number nearest to it that is twice a square, and at least 2. The 80,000 of the paper
    /// are such a number (200 x 200 squares); its 320 million would be 319,994,402 and 15 GB.
    std::uint32_t triangles = 80'000;
    /// Of the whole board, in meters, whatever the number of squares: screen area and light stay the same.
    float side_m = 100.0f;
};

/// Squares along one side.
std::uint32_t squares_per_side(const ChessboardOptions& options);

/// In the plane y = 0, the middle at the origin, seen from +y. Squares row by row (x runs faster), each two triangles
/// of its color, the first one black. Neighbors share the bits of their corners. Throws std::invalid_argument for no
/// triangles, and for sides that are not positive and finite or too small for that many squares.
Scene chessboard(const ChessboardOptions& options);
Scene chessboard(std::uint32_t triangles = 80'000);

/// From "a very low altitude", so that many squares are near and nearly all are seen: on the middle of one edge, a
/// fiftieth of the side high, towards the middle of the edge across.
Camera low_over_chessboard(const ChessboardOptions& options);

}  // namespace farfield::scenes
