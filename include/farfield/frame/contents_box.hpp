// What is drawn of a cell whose contents are missing, however near it is and around the eye too: all of its box, as it
// lies in the picture.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>

#include "farfield/approximation.hpp"
#include "farfield/drawables.hpp"
#include "farfield/geometry/length.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield::detail {

/// A splat over all of the picture that the part of a box before the near plane may cover, as deep as the box reaches:
/// what is known of the cells in it lies in front. Nothing if no part of it does.
inline std::optional<Splat> splat_over(const ContentsBox& box, const LocalView& view) {
    if (!(largest_component(box.half) > 0)) return {};
    // Of what is small in a large cell so little is known that pictures of eight bits would not have it.
    const float opacity = std::max(box.opacity, 1.0f / 255);
    const auto in_view = [&](glm::vec3 d) {
        return glm::vec3(glm::dot(view.right, d), glm::dot(view.up, d), glm::dot(view.forward, d));
    };
    const glm::vec3 center = in_view(box.center - view.eye);
    const glm::vec3 sides[3] = {in_view({box.half.x, 0, 0}), in_view({0, box.half.y, 0}), in_view({0, 0, box.half.z})};
    const glm::vec3 reach = glm::abs(sides[0]) + glm::abs(sides[1]) + glm::abs(sides[2]);
    const float nearest = view.near_depth, farthest = center.z + reach.z;
    if (!(farthest > nearest)) return {};
    if (!view.is_perspective) {
        return Splat{box.center + reach.z * view.forward, 2.0f * glm::vec2(reach), opacity, box.rgb};
    }

    // Beyond the picture there is nothing to cover, and next to the eye there is no end of it.
    const glm::vec2 whole(view.part.whole_width, view.part.whole_height);
    const glm::vec2 most = whole / (view.focal_px * view.squeeze) * (1.0f + glm::abs(glm::vec2(view.whole_off_center)));
    glm::vec2 low(std::numeric_limits<float>::infinity()), high(-low);
    const auto add = [&](glm::vec3 p) {
        const glm::vec2 at = glm::clamp(glm::vec2(p) / p.z, -most, most);
        low = glm::min(low, at);
        high = glm::max(high, at);
    };
    std::array<glm::vec3, 8> corners;
    for (unsigned c = 0; c < 8; ++c) {
        corners[c] =
            center + (c & 1 ? sides[0] : -sides[0]) + (c & 2 ? sides[1] : -sides[1]) + (c & 4 ? sides[2] : -sides[2]);
    }
    for (unsigned c = 0; c < 8; ++c) {
        const glm::vec3 p = corners[c];
        if (p.z >= nearest) {
            add(p);
            continue;
        }
        for (unsigned axis = 0; axis < 3; ++axis) {
            const glm::vec3 q = corners[c ^ 1u << axis];
            if (!(q.z > nearest)) continue;
            const float t = (nearest - p.z) / (q.z - p.z);
            add({glm::vec2(p) + t * (glm::vec2(q) - glm::vec2(p)), nearest});
        }
    }
    const glm::vec2 middle = 0.5f * (low + high), size = high - low;
    if (!(size.x > 0 && size.y > 0)) return {};
    return Splat{view.eye + farthest * (view.forward + middle.x * view.right + middle.y * view.up), farthest * size,
                 opacity, box.rgb};
}

}  // namespace farfield::detail
