// What primitives are tessellated into: convex polygons, seen as spans, never owned.
#pragma once

#include <glm/vec3.hpp>
#include <span>

#include "farfield/geometry/rgba8.hpp"

namespace farfield {

/// A convex planar polygon of three or more vertices, counter-clockwise seen from its front. Both sides are
/// visible. `colors` holds one color for all, or one a vertex, not premultiplied. Valid only during the call
/// it is passed to.
template <class T>
struct BasicPolygon {
    std::span<const glm::vec<3, T>> vertices;
    std::span<const Rgba8> colors;
};

using Polygon = BasicPolygon<float>;
using PolygonD = BasicPolygon<double>;

}  // namespace farfield
