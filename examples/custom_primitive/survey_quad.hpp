// A type of somebody else's, which cannot be changed: it plugs in by a specialization of primitive_traits. Its
// coordinates are too large for single precision; that its bounds are in double is all that has to be said.
#pragma once

#include <algorithm>
#include <cstdint>

#include "farfield/primitive.hpp"

namespace survey {

/// A piece of ground in national coordinates, meters: east, height and south, each for four corners.
struct Quad {
    double east[4], height[4], south[4];
    std::uint8_t vegetation;
};

}  // namespace survey

template <>
struct farfield::primitive_traits<survey::Quad> {
    static BoxD bounds(const survey::Quad& q) {
        BoxD box = BoxD::empty();
        for (int i = 0; i < 4; ++i) box.add(glm::dvec3(q.east[i], q.height[i], q.south[i]));
        return box;
    }
    /// Two triangles, since nobody promised that the four corners lie in a plane.
    template <class Sink>
    static void polygons(const survey::Quad& q, Sink&& sink) {
        const auto corner = [&](int i) { return glm::dvec3(q.east[i], q.height[i], q.south[i]); };
        const glm::dvec3 first[] = {corner(0), corner(1), corner(2)}, second[] = {corner(0), corner(2), corner(3)};
        const Rgba8 color{std::uint8_t(200 - q.vegetation / 2), std::uint8_t(150 + q.vegetation / 4), 90};
        sink(PolygonD{first, {&color, 1}});
        sink(PolygonD{second, {&color, 1}});
    }
};

static_assert(farfield::PrimitiveWithPolygons<survey::Quad> && farfield::has_double_bounds<survey::Quad>);
