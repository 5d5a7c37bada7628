// The ray along which a point of a picture looks into the scene.
#pragma once

#include "farfield/settings.hpp"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "farfield/camera.hpp"
#include "farfield/geometry/ray.hpp"
#include "farfield/view.hpp"

namespace farfield {

/// The ray of a point of the view's picture, in pixels from its left and its top: {0.5, 0.5} is the center of the first
/// one. Its distances are depths along `Camera::forward`, between the camera's `near_depth` and `far_depth`; of an
/// orthographic view without a near depth they may be below 0. Throws std::invalid_argument as View::validate does.
inline Ray ray_through(const View& view, glm::dvec2 pixel) {
    view.validate();
    const Camera& camera = view.camera;
    const glm::dvec2 whole(view.whole_width(), view.whole_height());
    const glm::dvec2 at = (pixel + glm::dvec2(view.part.left, view.part.top)) / whole * 2.0 - 1.0;
    const double half_height = double(camera.half_height);
    const double half_width = camera.half_width > 0 ? double(camera.half_width) : half_height * whole.x / whole.y;
    const glm::dvec3 aside = glm::dvec3(camera.right) * ((at.x + camera.off_center.x) * half_width) +
                             glm::dvec3(camera.up) * ((camera.off_center.y - at.y) * half_height);
    Ray ray{camera.eye, glm::dvec3(camera.forward), double(camera.near_depth), double(camera.far_depth)};
    if (camera.projection == Projection::perspective) {
        ray.direction += aside;
    } else {
        ray.origin += aside;
        if (camera.near_depth == 0) ray.nearest = -detail::missed;
    }
    return ray;
}

}  // namespace farfield
