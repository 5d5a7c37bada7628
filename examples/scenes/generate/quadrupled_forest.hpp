// The forest of Chamberlain et al. 1996, section 5.2 and plate 5: a tree, four of them, four of those, and so on, by
// "recursively instancing the tree model", up to 16,384 trees of 52,470 triangles: 859 million.
#pragma once

#include <cstdint>

#include "farfield/view.hpp"
#include "scenes/scene.hpp"

namespace farfield::scenes {

struct QuadrupledForestOptions {
    std::uint64_t seed = 1;
    /// 4^levels trees: 0 is a single one, 7 are 16,384. At most 20, where floats still tell half meters apart.
    std::uint32_t levels = 7;
    std::uint32_t tree_triangles = 52'470;
    /// Between trees. Powers of two place every tree and every patch of ground exactly.
    float spacing_m = 8.0f;
    /// Two triangles a tree, at y = 0; instanced with it.
    bool ground = true;
};

/// Group 0 is the tree on its patch of ground, under a sun overhead so that it is lit alike however it is turned. Group
/// k + 1 is four placements of group k, each with another of the four turns by 90 degrees about y, dealt out anew at
/// each level: no level is a lattice of one picture. Around the origin. Memory is that of the tree and 4 placements a
/// level; the root of 0 levels is the tree itself. Throws std::invalid_argument for too many levels, too few triangles
/// a tree, or a spacing that is not positive and finite.
Scene quadrupled_forest(const QuadrupledForestOptions& options);

/// 4^levels trees with the other options as they are.
Scene quadrupled_forest(std::uint32_t levels = 7);

/// Half of the forest's side, in meters: trees stand within.
double half_extent_m(const QuadrupledForestOptions& options);

/// At the edge, looking in: a quarter of the spacing outside of the middle of the edge at +z, `height_m` above the
/// ground, towards the middle of the forest at a slant of 10 degrees, so as not to look down an aisle. Trees near the
/// eye stand in the same places, turned otherwise, for any number of levels from 2.
Camera eye_level(const QuadrupledForestOptions& options, double height_m = 7.0);

/// From `elevation_degrees` above the horizon on the +z side, as near as has the whole forest in an image that is at
/// least as wide as high: the distance grows with the extent. Leaves room for crowns
/// that hang over the edge by a quarter of the spacing and for trees 12 m high. 0 < elevation < 90.
Camera aerial(const QuadrupledForestOptions& options, double elevation_degrees = 35.0);

}  // namespace farfield::scenes
