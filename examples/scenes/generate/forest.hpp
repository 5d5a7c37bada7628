// Trees in a grid over flat ground.
#pragma once

#include <cstdint>

#include "scenes/scene.hpp"

namespace farfield::scenes {

struct ForestOptions {
    std::uint64_t seed = 1;
    std::size_t columns = 5, rows = 4;  // along x, along z
    float spacing_m = 8.0f;
    /// Different trees, dealt out at random; at least 1.
    std::size_t tree_kinds = 1;
    std::uint32_t tree_triangles = 52'470;
};

/// columns * rows trees, each a placement turned by a multiple of 45 degrees about y, around the origin. The
/// root's own triangles are the ground: two a tree, at y = 0. Five by four trees of 52,470 triangles are
/// 1,049,440 triangles in all; `expanded` makes one array of them. Throws std::invalid_argument for no trees,
/// no kinds, or too few triangles a tree.
Scene forest(const ForestOptions& options);

/// trees_per_side^2 trees of one kind.
Scene forest(std::size_t trees_per_side);

}  // namespace farfield::scenes
