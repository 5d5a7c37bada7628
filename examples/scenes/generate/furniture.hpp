// What stands in an office: groups of closed boxes (boxes.hpp), each on y = 0 around the origin in plan, meters.
#pragma once

#include "scenes/generate/random.hpp"
#include "scenes/scene.hpp"

namespace farfield::scenes {

/// 1.6 wide (x), 0.8 deep: drawers, a monitor, a keyboard, a telephone, a lamp, papers. Who works at it sits at -z.
Group desk(Random& random);
/// On four feet, looks to +z; the seat is 0.5 high.
Group chair(glm::vec3 cloth);
/// 1.75 wide (z), 0.35 deep, 2 high, with binders and gaps; opens to +x.
Group shelf(Random& random);
/// 1.2 wide (z), 0.45 deep, 0.8 high; opens to -x.
Group cabinet(Random& random);
/// A pot and leaves.
Group plant(Random& random);
/// Open above.
Group bin();
/// 1.5 wide (z) on a wall that faces -x; the lower edge is 1 above the floor.
Group whiteboard();

}  // namespace farfield::scenes
