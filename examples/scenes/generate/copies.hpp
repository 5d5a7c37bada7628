// The same thing again and again, as Klein et al. 2002, section 7.5, fill a landscape with instances.
#pragma once

#include <cstdint>

#include "scenes/scene.hpp"

namespace farfield::scenes {

/// The scene `count` times in the rows of a square across its up axis, each turned about that by an angle of its own.
/// What it has of triangles stays there once. The rows lie 1.25 times as far apart as the scene is wide. Throws
/// std::invalid_argument for no copies, and for a scene without anything to copy.
Scene copies(Scene scene, std::uint32_t count);

}  // namespace farfield::scenes
