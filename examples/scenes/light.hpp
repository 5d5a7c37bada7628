// Light baked into colors. The pictures of the papers have colors fixed before the hierarchy is built; these
// few lines give generated scenes a sun and a sky without asking a renderer for any.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "farfield/geometry/rgba8.hpp"

namespace farfield::scenes {

/// Directions are unit vectors; colors are linear. The sky lights from +y, the ground reflects from -y.
struct Light {
    glm::vec3 to_sun = glm::normalize(glm::vec3(0.45f, 0.75f, 0.48f));
    glm::vec3 sun{2.1f, 1.95f, 1.65f};
    glm::vec3 sky{0.42f, 0.52f, 0.68f};
    glm::vec3 ground{0.16f, 0.15f, 0.11f};
};

/// A direction of a scene in which another axis is up, as it is where y is. A half of a turn or a quarter.
inline glm::vec3 with_y_up(glm::vec3 direction, glm::vec3 up) {
    const glm::vec3 other = std::abs(up.x) < 0.9f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
    const glm::vec3 front = glm::cross(other, up), right = glm::cross(up, front);
    return {glm::dot(direction, right), glm::dot(direction, up), glm::dot(direction, front)};
}

/// Diffuse reflection, linear. `sun_seen` and `sky_seen` in [0, 1] are the unshadowed parts.
inline glm::vec3 lit(const Light& light, glm::vec3 albedo, glm::vec3 normal, float sun_seen, float sky_seen) {
    const float facing = std::max(0.0f, glm::dot(normal, light.to_sun));
    const float upward = 0.5f + 0.5f * normal.y;
    const glm::vec3 ambient = light.ground * (1.0f - upward) + light.sky * upward;
    return albedo * (light.sun * (facing * sun_seen) + ambient * sky_seen);
}

/// Linear to display: gamma 2.2; what is brighter than white becomes white.
inline Rgba8 display_color(glm::vec3 linear) {
    const auto encode = [](float v) { return std::pow(std::clamp(v, 0.0f, 1.0f), 1.0f / 2.2f); };
    return to_rgba8({encode(linear.x), encode(linear.y), encode(linear.z), 1.0f});
}

/// Display to linear: the inverse of `display_color`.
inline glm::vec3 linear_color(Rgba8 c) {
    const auto decode = [](std::uint8_t v) { return std::pow(static_cast<float>(v) / 255.0f, 2.2f); };
    return {decode(c.r), decode(c.g), decode(c.b)};
}

}  // namespace farfield::scenes
