// Boxes against the planes of a view, remembering which planes need no further test below.
#pragma once

#include "farfield/settings.hpp"

#include <array>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace farfield {

/// Bits of the planes that a box still crosses; 0 means that it lies inside all of them, as does everything in it.
using PlaneMask = std::uint32_t;
inline constexpr PlaneMask plane_count = 6;
inline constexpr PlaneMask all_planes = (PlaneMask(1) << plane_count) - 1;
inline constexpr PlaneMask border_count = 4;  ///< of a tile
inline constexpr PlaneMask all_borders = (PlaneMask(1) << border_count) - 1;
inline constexpr PlaneMask outside_a_plane = ~PlaneMask(0);

/// Returns the planes that the box still crosses, or `outside_a_plane`. It is conservative: a box outside no single
/// plane counts as inside. `mask` names the planes worth testing (Assarsson and Moller 2000, "plane masking").
inline PlaneMask crossed_planes(const std::array<glm::vec4, plane_count>& planes, glm::vec3 center, glm::vec3 half,
                                PlaneMask mask) {
    PlaneMask crossed = 0;
    for (PlaneMask i = 0; i < plane_count; ++i) {
        if ((mask >> i & 1) == 0) continue;
        const glm::vec3 normal(planes[i]);
        const float distance = glm::dot(normal, center) + planes[i].w;
        const float reach = glm::dot(glm::abs(normal), half);
        if (distance < -reach) return outside_a_plane;
        if (distance < reach) crossed |= PlaneMask(1) << i;
    }
    return crossed;
}

/// The same for the borders of a tile, and conservative against the rounding of bounds too: what is lost at the border
/// of a picture is lost, but tiles have neighbors that would show it. Planes [0, count) are tested, if in `mask`.
inline PlaneMask crossed_borders(const std::array<glm::vec4, border_count>& borders, PlaneMask count, glm::vec3 center,
                                 glm::vec3 half, PlaneMask mask) {
    PlaneMask crossed = 0;
    for (PlaneMask i = 0; i < count; ++i) {
        if ((mask >> i & 1) == 0) continue;
        const glm::vec3 normal(borders[i]), size = glm::abs(normal);
        const float distance = glm::dot(normal, center) + borders[i].w;
        const float rounding = 0x1p-20f * (glm::dot(size, glm::abs(center)) + glm::abs(borders[i].w));
        const float reach = glm::dot(size, half) + rounding;
        if (distance < -reach) return outside_a_plane;
        if (distance < reach) crossed |= PlaneMask(1) << i;
    }
    return crossed;
}

}  // namespace farfield
