// A view as engines have it, for renderers that draw with their matrices.
#pragma once

#include "farfield/settings.hpp"

#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "farfield/view/local_view.hpp"

namespace farfield {

/// From a hierarchy's coordinates, which are primitives' minus its origin, to those of the camera in world units: x to
/// the right, y upwards, z towards the viewer, 0 at the eye.
///
///     to_eye = view_matrix(view)                                  in set_view
///     to_eye * glm::translate(glm::dmat4(1), -source.origin)      for primitives of a Source
///
/// An engine's own view matrix may differ, by a scale where the scene lies below a node that has one: with it,
/// `engines * glm::inverse(view_matrix(outermost))` in begin_frame is what comes last.
inline glm::dmat4 view_matrix(const LocalView& view) {
    const glm::dvec3 x(view.right), y(view.up), z(-view.forward), from(view.anchor);
    const double scale = double(view.scale);
    const glm::dvec3 moved(glm::dot(x, from), glm::dot(y, from), glm::dot(z, from) + double(view.anchor_depth));
    return {glm::dvec4(x.x, y.x, z.x, 0) * scale, glm::dvec4(x.y, y.y, z.y, 0) * scale,
            glm::dvec4(x.z, y.z, z.z, 0) * scale, glm::dvec4(-moved * scale, 1)};
}

}  // namespace farfield
