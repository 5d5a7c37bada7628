// Which way is up, and where things are.
#pragma once

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace walkthrough {

/// Plan coordinates are x along `right` and y along `front`, heights are along `up`: right-handed, unit length. With y
/// up, right is +x and front is +z, towards a viewer who looks down the z axis.
struct FrameOfReference {
    glm::vec3 up{0, 1, 0};
    glm::vec3 right{1, 0, 0};
    glm::vec3 front{0, 0, 1};

    explicit FrameOfReference(glm::vec3 scene_up) : up(glm::normalize(scene_up)) {
        const glm::vec3 other = glm::abs(up.x) < 0.9f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
        front = glm::normalize(glm::cross(other, up));
        right = glm::cross(up, front);
    }

    glm::vec2 plan(glm::vec3 p) const { return {glm::dot(p, right), glm::dot(p, front)}; }
    float height(glm::vec3 p) const { return glm::dot(p, up); }
    glm::vec3 at(glm::vec2 plan, float height) const { return right * plan.x + front * plan.y + up * height; }
};

}  // namespace walkthrough
