// Generated scenes by name.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "scenes/scene.hpp"

namespace farfield::scenes {

/// What `make` knows, in the order in which to list it.
///
///     tree                    52,470 triangles, one group
///     molecule             5,227,200 triangles, one group
///     island               3,642,224 triangles, 480 placements of 4 trees
///     shade-island        40,600,318 triangles, 1,117 placements of one tree
///     forest               1,049,440 triangles, one group: 20 trees expanded
///     forest-instanced    20,988,800 triangles, 400 placements of one tree
///     quadrupled-forest  859,701,248 triangles, 16,384 trees by 7 levels of 4 placements
///     building               961,452 triangles, 5 placements of a floor, nested further
///     chessboard              80,000 triangles, one group
///     cube                       384 triangles, one group: 192 squares
std::vector<std::string> names();

/// With default options. Throws std::invalid_argument, listing the known names, for any other name.
Scene make(std::string_view name);

}  // namespace farfield::scenes
