// Which way is up, and where things are.
#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "farfield/geometry/box.hpp"

namespace walkthrough {

/// Plan coordinates are x along `right` and y along `front`, heights are along `up`: right-handed, unit length. With y
/// up, right is +x and front is +z, towards a viewer who looks down the z axis.
///
/// Lengths are in a unit of about the largest coordinate that there is, so that their squares do not leave single
/// precision, whatever the scene's unit. It is a power of two: nothing else changes.
struct FrameOfReference {
    glm::vec3 up{0, 1, 0};
    glm::vec3 right{1, 0, 0};
    glm::vec3 front{0, 0, 1};

    int exponent = 0;  ///< the unit is 2^exponent of the scene's

    FrameOfReference(glm::vec3 scene_up, const farfield::Box& bounds) : up(glm::normalize(scene_up)) {
        const glm::vec3 most = glm::max(glm::abs(bounds.lower), glm::abs(bounds.upper));
        const float largest = glm::max(most.x, glm::max(most.y, most.z));
        if (largest > 0) exponent = std::ilogb(largest) + 1;
        const glm::vec3 other = glm::abs(up.x) < 0.9f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
        front = glm::normalize(glm::cross(other, up));
        right = glm::cross(up, front);
    }

    /// From the scene's coordinates and back.
    glm::vec3 in_units(glm::vec3 p) const {
        return {std::ldexp(p.x, -exponent), std::ldexp(p.y, -exponent), std::ldexp(p.z, -exponent)};
    }
    glm::dvec3 in_scene(glm::vec3 p) const { return glm::dvec3(p) * std::ldexp(1.0, exponent); }

    glm::vec2 plan(glm::vec3 p) const { return {glm::dot(p, right), glm::dot(p, front)}; }
    float height(glm::vec3 p) const { return glm::dot(p, up); }
    glm::vec3 at(glm::vec2 plan, float height) const { return right * plan.x + front * plan.y + up * height; }
};

}  // namespace walkthrough
