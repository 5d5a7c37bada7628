// Cameras that have all of a box in view.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "farfield/geometry/box.hpp"
#include "farfield/view.hpp"

namespace farfield::scenes {

/// Looks at the middle of the box from `direction` (any length, not along y), y up, from as near as has every corner in
/// an image at least as wide as high.
inline Camera framing(const BoxD& box, glm::dvec3 direction, float vertical_fov_radians) {
    const glm::dvec3 back = glm::normalize(direction), right = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), back));
    const glm::dvec3 up = glm::cross(back, right), half = box.size() * 0.5;
    const double tangent = std::tan(0.5 * double(vertical_fov_radians));
    double distance = 0;
    for (int i = 0; i < 8; ++i) {
        const glm::dvec3 corner = half * glm::dvec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
        const double across = std::max(std::abs(glm::dot(corner, right)), std::abs(glm::dot(corner, up)));
        distance = std::max(distance, across / tangent + glm::dot(corner, back));
    }
    // A point is looked at from one unit away, or from as far as its coordinates tell apart.
    const glm::dvec3 center = box.center(), away = glm::abs(center);
    if (!(distance > 0)) distance = std::max({1.0, 0x1p-20 * away.x, 0x1p-20 * away.y, 0x1p-20 * away.z});
    return Camera::perspective(center + back * (1.02 * distance), center, {0, 1, 0}, vertical_fov_radians);
}

}  // namespace farfield::scenes
