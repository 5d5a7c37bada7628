// From where the scenes of a chart are looked at, and on what ground.
#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <string_view>

#include "farfield/geometry/box.hpp"
#include "farfield/view.hpp"

namespace farfield::bench {

/// Chamberlain et al. 1996, Table 2: from `distance` radii, `angle_degrees` off the front axis; a radius is half of the
/// largest side of the bounds. Square.
inline View view_from(const Box& bounds, glm::vec3 scene_up, double distance, double angle_degrees, int size_px) {
    const glm::dvec3 up(glm::normalize(scene_up));
    const glm::dvec3 other = std::abs(up.x) < 0.9 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const glm::dvec3 front = glm::normalize(glm::cross(other, up)), right = glm::cross(up, front);
    const double angle = angle_degrees * std::numbers::pi / 180;
    const double radius = bounds.largest_side() > 0 ? 0.5 * double(bounds.largest_side()) : 1.0;
    const glm::dvec3 center(bounds.center());
    const glm::dvec3 eye = center + (right * std::sin(angle) + front * std::cos(angle)) * (radius * distance);
    constexpr float field_of_view = std::numbers::pi_v<float> / 3;
    return {
        .camera = Camera::perspective(eye, center, glm::vec3(up), field_of_view), .width = size_px, .height = size_px};
}

/// All surfaces are closed and counter-clockwise from outside.
inline bool culls_back_faces(std::string_view scene) {
    return scene == "molecule";
}

}  // namespace farfield::bench
