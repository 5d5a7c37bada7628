// Views by where they look from, and at what.
#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "farfield/view.hpp"

namespace farfield::test {

inline View looking(glm::dvec3 eye, glm::dvec3 target = glm::dvec3(0), int size = 128, float tolerance = 0) {
    View view;
    view.camera = Camera::perspective(
        eye, target, std::abs(glm::normalize(target - eye).y) > 0.99 ? glm::vec3(0, 0, 1) : glm::vec3(0, 1, 0), 0.9f);
    view.width = view.height = size;
    view.tolerance_px = tolerance;
    return view;
}
inline View looking_orthographic(glm::dvec3 eye, glm::dvec3 target = glm::dvec3(0), float height = 3, int size = 128,
                                 float tolerance = 0) {
    View view;
    view.camera = Camera::orthographic(
        eye, target, std::abs(glm::normalize(target - eye).y) > 0.99 ? glm::vec3(0, 0, 1) : glm::vec3(0, 1, 0), height);
    view.width = view.height = size;
    view.tolerance_px = tolerance;
    return view;
}

}  // namespace farfield::test
