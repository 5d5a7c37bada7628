// Two ready-made primitives, which also show how a type of your own plugs in by members (see primitive.hpp).
#pragma once

#include "farfield/settings.hpp"

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "farfield/geometry/box.hpp"
#include "farfield/geometry/length.hpp"
#include "farfield/geometry/polygon.hpp"
#include "farfield/geometry/rgba8.hpp"

namespace farfield {

/// The bounds of a triangle, not finite if one coordinate is not: minimum and maximum alone may lose a NaN.
inline Box bounds_of(const std::array<glm::vec3, 3>& v) {
    const glm::vec3 zero = v[0] * 0.0f + v[1] * 0.0f + v[2] * 0.0f;
    return {glm::min(v[0], glm::min(v[1], v[2])) + zero, glm::max(v[0], glm::max(v[1], v[2])) + zero};
}

/// Double, because areas in squares of a large or small unit leave single precision.
inline double area_of(const std::array<glm::vec3, 3>& v) {
    const glm::dvec3 a(v[0]);
    return 0.5 * length_of(glm::cross(glm::dvec3(v[1]) - a, glm::dvec3(v[2]) - a));
}

/// A triangle of one color, counter-clockwise seen from its front.
struct Triangle {
    std::array<glm::vec3, 3> vertices{};
    Rgba8 rgba{};

    Box bounds() const { return bounds_of(vertices); }
    /// One-sided area, in squared world units.
    double area() const { return area_of(vertices); }
    glm::vec4 color() const { return to_vec4(rgba); }
    template <class Sink>
    void polygons(Sink&& sink) const {
        sink(Polygon{vertices, {&rgba, 1}});
    }
};
static_assert(sizeof(Triangle) == 40 || !vectors_are_packed);

/// A triangle with a color at each vertex, interpolated in perspective between them.
struct VertexColoredTriangle {
    std::array<glm::vec3, 3> vertices{};
    std::array<Rgba8, 3> rgba{};

    Box bounds() const { return bounds_of(vertices); }
    double area() const { return area_of(vertices); }
    glm::vec4 color() const { return (to_vec4(rgba[0]) + to_vec4(rgba[1]) + to_vec4(rgba[2])) * (1.0f / 3.0f); }
    template <class Sink>
    void polygons(Sink&& sink) const {
        sink(Polygon{vertices, rgba});
    }
};
static_assert(sizeof(VertexColoredTriangle) == 48 || !vectors_are_packed);

}  // namespace farfield
