// The place of an object in the picture, so that errors are those of the object and not of the empty picture around it.
#pragma once

#include "farfield/settings.hpp"

#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>

#include "farfield/geometry/box.hpp"
#include "farfield/measure/pixel_rect.hpp"
#include "farfield/view.hpp"

namespace farfield {

/// The pixels that a box in the user's coordinates may take: the extent of its corners, rounded outwards and clipped to
/// the picture. Never empty. There is none for a box that is empty, not finite, outside of the picture, or, in a
/// perspective view, not all in front of the eye.
template <class T>
std::optional<PixelRect> projected_rect(const BasicBox<T>& box, const View& view) {
    if (box.is_empty() || !box.is_finite()) return std::nullopt;
    const Camera& camera = view.camera;
    const glm::dvec2 size(view.width, view.height), whole(view.whole_width(), view.whole_height());
    const double focal_px = 0.5 * whole.y / double(camera.half_height);
    const glm::dvec2 focal(camera.half_width > 0 ? 0.5 * whole.x / double(camera.half_width) : focal_px, focal_px);
    const glm::dvec2 axis_at =
        0.5 * whole * (1.0 + camera.off_center * glm::dvec2(-1, 1)) - glm::dvec2(view.part.left, view.part.top);
    glm::dvec2 lower(std::numeric_limits<double>::infinity()), upper(-lower);
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 p(corner & 1 ? box.upper.x : box.lower.x, corner & 2 ? box.upper.y : box.lower.y,
                           corner & 4 ? box.upper.z : box.lower.z);
        const glm::dvec3 d = p - camera.eye;
        double depth = 1;
        if (camera.projection == Projection::perspective) {
            depth = glm::dot(d, glm::dvec3(camera.forward));
            if (!(depth > 0)) return std::nullopt;
        }
        const glm::dvec2 across(glm::dot(d, glm::dvec3(camera.right)), -glm::dot(d, glm::dvec3(camera.up)));
        const glm::dvec2 px = across * focal / depth + axis_at;
        lower = glm::min(lower, px);
        upper = glm::max(upper, px);
    }
    if (!(lower.x < size.x && lower.y < size.y && upper.x >= 0 && upper.y >= 0)) return std::nullopt;
    lower = glm::clamp(glm::floor(lower), glm::dvec2(0), size - 1.0);
    upper = glm::clamp(glm::ceil(upper), lower + 1.0, size);  // a point on a border takes the pixel after it
    return PixelRect{int(lower.x), int(lower.y), int(upper.x), int(upper.y)};
}

}  // namespace farfield
