// A broadleaf tree: what Chamberlain et al. 1996 measure with (section 5: 52,470 triangles), made anew.
#pragma once

#include <cstdint>

#include "scenes/light.hpp"
#include "scenes/scene.hpp"

namespace farfield::scenes {

struct TreeOptions {
    std::uint64_t seed = 1;
    /// From the ground to about the highest leaf, in meters.
    float height_m = 10.0f;
    /// Crown width in relation to an ordinary tree of this height; 0.7 is slender, 1.2 is broad.
    float breadth = 1.0f;
    /// Exact, wood and leaves together; 2,000 or more. Fewer triangles give coarser wood and fewer but larger
    /// leaves: the area of all leaves together stays.
    std::uint32_t triangles = 52'470;
    /// A tree that will be placed with many rotations needs a sun overhead.
    Light light{};
};

/// Stands with the middle of its trunk at the origin, y up, lowest vertices at y = 0. Wood first, then
/// leaves, twig by twig. A leaf is two triangles folded along its midrib, seen from both sides; wood is open
/// at the ground and inside its parent branch. Throws std::invalid_argument for fewer than 2,000 triangles or
/// a height or breadth that is not positive and finite.
Scene tree(const TreeOptions& options);
Scene tree(std::uint64_t seed = 1);

}  // namespace farfield::scenes
