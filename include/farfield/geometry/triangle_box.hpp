// Does a triangle touch a box? By separating axes (Akenine-Moller 2001).
#pragma once

#include "farfield/settings.hpp"

#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "farfield/geometry/box.hpp"
#include "farfield/geometry/length.hpp"

namespace farfield {

/// Both are closed sets: touching counts. Rounding errs only for triangles within a few float steps of the box.
inline bool triangle_touches(const Box& box, glm::vec3 a, glm::vec3 b, glm::vec3 c) {
    const glm::vec3 center = box.center();
    glm::vec3 half = box.size() * 0.5f;
    std::array<glm::vec3, 3> v{a - center, b - center, c - center};
    // Sides of planes are told by products of three lengths.
    const float largest =
        glm::max(detail::largest_component(half),
                 glm::max(detail::largest_component(v[0]),
                          glm::max(detail::largest_component(v[1]), detail::largest_component(v[2]))));
    if (!(largest > 0x1p-20f && largest < 0x1p40f)) {
        const int exponent = -exponent_of(largest);
        half = detail::times_power_of_two(half, exponent);
        for (glm::vec3& p : v) p = detail::times_power_of_two(p, exponent);
    }
    const auto separates = [&](glm::vec3 axis) {
        const float p0 = glm::dot(axis, v[0]), p1 = glm::dot(axis, v[1]), p2 = glm::dot(axis, v[2]);
        const float reach = glm::dot(glm::abs(axis), half);
        return glm::min(p0, glm::min(p1, p2)) > reach || glm::max(p0, glm::max(p1, p2)) < -reach;
    };
    const std::array<glm::vec3, 3> edges{v[1] - v[0], v[2] - v[1], v[0] - v[2]};
    for (int axis = 0; axis < 3; ++axis) {
        glm::vec3 unit(0);
        unit[axis] = 1;
        if (separates(unit)) return false;
        for (const glm::vec3& edge : edges) {
            if (separates(glm::cross(unit, edge))) return false;
        }
    }
    return !separates(glm::cross(edges[0], edges[1]));
}

}  // namespace farfield
