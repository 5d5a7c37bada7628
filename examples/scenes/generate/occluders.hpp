// What hides much, and what a renderer that culls what is hidden may get wrong.
#pragma once

#include <cstdint>
#include <vector>

#include "farfield/primitive/triangle.hpp"

namespace farfield::scenes {

struct GapOptions {
    float gap = 0.01f;              ///< between the occluders, from x = -gap / 2 to gap / 2
    std::uint32_t side_quads = 16;  ///< of each occluder, and of a sheet behind
    std::uint32_t behind = 40'000;  ///< triangles; more if the sheet has more
};

/// Two dark occluders side by side in z = 0, four wide and four high each, with a gap between them; behind them,
/// from z = -1 to -3, bright triangles at random, as wide as they are together, before a bright sheet. Every triangle
/// has one color. Seen from z all but the gap's part of it is hidden. Throws std::invalid_argument for a gap that is
/// not positive and below 1, and for no quads or triangles.
std::vector<Triangle> occluders_with_gap(const GapOptions& options = {});

/// Of what lies behind, and of nothing else.
inline bool is_bright(Rgba8 color) {
    return color.r > 128;
}

}  // namespace farfield::scenes
