// Primary rays by Embree 3: 64 a pixel, in packets of 16, on one core.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "support/drawer.hpp"

namespace farfield::bench {

/// Built when it is made, which is not part of a frame. A sample has the first color of the quadrilateral that its ray
/// meets first, without interpolation, and a pixel their mean. Throws std::runtime_error where Embree cannot run.
std::unique_ptr<Drawer> embree_drawer(std::span<const VertexColoredTriangle> pairs_of_triangles);
/// How wide packets really are, and of which version.
std::string embree_name();

}  // namespace farfield::bench
