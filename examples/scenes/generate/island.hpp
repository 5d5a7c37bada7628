// An island with a wood: what Chamberlain et al. 1996 measure with (section 5 and table 1: 3,642,224
// triangles, of which 33,000 ground; 480 trees), made anew.
#pragma once

#include <cstdint>
#include <vector>

#include "farfield/view.hpp"
#include "scenes/scene.hpp"

namespace farfield::scenes {

struct IslandOptions {
    std::uint64_t seed = 1;
    /// The island grows with their number, so that a wood is a wood: about 100 square meters of land a tree.
    std::size_t trees = 480;
    /// Of one tree, exact; see TreeOptions. The paper's island has about this many; 52,470 gives 25 million.
    std::uint32_t tree_triangles = 7'519;
    /// Different trees, from slender to broad, 5 to 12 meters tall; at least 1.
    std::size_t tree_kinds = 4;
    /// Of the ground along a side, two triangles each; at least 1.
    int ground_cells = 128;
};

/// What Shade et al. 1996 measure with (section 5): 131,072 triangles of ground and 1,117 trees of one kind, 36,230
/// triangles each; and the sea around, 336.
inline constexpr IslandOptions shade_island{
    .trees = 1'117, .tree_triangles = 36'230, .tree_kinds = 1, .ground_cells = 256};

/// Ground and sea are the root's own triangles (33,104 with 128 cells along a side), every tree is a placement: turned
/// about y, scaled, standing on the ground, none in the sea. Group i < tree_kinds is a tree. Sea level is y = 0;
/// meters. Throws std::invalid_argument for no tree kinds, no ground or too few triangles a tree.
Scene island(const IslandOptions& options);

/// The walk that Shade et al. 1996 measure along (section 5): "the camera first tracks along the edge of the model,
/// then flies in toward the center of the island at tree-top level", on a B-spline. One camera a frame; 1,200 frames
/// over `shade_island` are 0.6 m a frame.
std::vector<Camera> walk_over_island(const IslandOptions& options, int frames);
inline constexpr int frames_of_island_walk = 1200;

/// As island(options); `instanced` false gives one group (see `expanded`), 3,642,224 triangles for 480 trees.
Scene island(std::size_t trees = 480, bool instanced = true);

}  // namespace farfield::scenes
