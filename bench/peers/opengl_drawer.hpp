// OpenGL without a window, into a picture eight times as wide and high: where no graphics card is found, Mesa's
// llvmpipe on the processor.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "support/drawer.hpp"

namespace farfield::bench {

/// A frame is every quadrilateral of the scene in one call, with a depth test, until glFinish returns. It is neither
/// filtered nor read; image() does both. Only one at a time. Throws std::runtime_error where there is no OpenGL 4.5.
std::unique_ptr<Drawer> opengl_drawer(std::span<const VertexColoredTriangle> pairs_of_triangles);
/// Of the last drawer's renderer.
std::string opengl_name();

}  // namespace farfield::bench
