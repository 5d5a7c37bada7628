// Faces of a cell's box: the visible ones, how large they look, and the splat that stands for them from afar.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <utility>

#include "farfield/drawables.hpp"
#include "farfield/geometry/area_law.hpp"
#include "farfield/geometry/cell.hpp"
#include "farfield/geometry/halvings.hpp"
#include "farfield/geometry/length.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield {

/// A power of two that a cell's sides are near, since squares of local units may leave single precision.
inline float length_unit(const Cell& cell) {
    const float side = cell.largest_side();
    // It is taken from the bits wherever it can be, as every stand-in drawn asks for it.
    const std::uint32_t exponent = std::bit_cast<std::uint32_t>(side) >> 23 & 255;
    if (exponent >= 1 && exponent <= 252) return std::bit_cast<float>((exponent + 1) << 23);
    return std::ldexp(1.0f, glm::clamp(exponent_of(side), -126, 126));
}

/// The area of a box's outline, seen from a unit vector.
inline float outline_of(glm::vec3 half, glm::vec3 w) {
    const glm::vec3 sides = glm::abs(w) * glm::vec3(half.y * half.z, half.z * half.x, half.x * half.y);
    return 4 * (sides.x + sides.y + sides.z);
}

/// The faces of a cell that look at the viewer, and how large they are to it.
struct VisibleFaces {
    std::array<std::uint8_t, 3> side{};  ///< 0..5: -x, +x, -y, +y, -z, +z
    std::array<float, 3> projected{};    ///< area seen squarely from the viewer, in squares of length_unit()
    int count = 0;

    /// Finds at most three, none from inside. They are projected as if the viewer were far, which cells about a pixel
    /// wide allow.
    VisibleFaces(const Cell& cell, const LocalView& view) {
        const glm::vec3 d = view.towards_viewer(cell.center);
        const float inverse_length = 1.0f / length_of(d);
        const glm::vec3 half = cell.half * (1 / length_unit(cell));
        for (int axis = 0; axis < 3; ++axis) {
            const float reach = view.is_perspective ? cell.half[axis] : 0.0f;
            if (!(std::abs(d[axis]) > reach)) continue;
            const float face = 4 * half[(axis + 1) % 3] * half[(axis + 2) % 3];
            side[std::size_t(count)] = std::uint8_t(2 * axis + (d[axis] > 0 ? 1 : 0));
            projected[std::size_t(count)] = face * std::abs(d[axis]) * inverse_length;
            ++count;
        }
    }
};

/// What cubes of faces are expected to err by (wanted_error.hpp): off its axes one covers too much, however small it
/// is.
inline float cube_rmse(float side_px, float covered) {
    return 0.9f * std::sqrt(covered) * side_px / (side_px + 0.8f);
}

/// The face of a cell's box on one side.
inline Face face_of(const Cell& cell, unsigned side, Rgba8 premultiplied) {
    Face face{cell.center - cell.half, cell.center + cell.half, premultiplied, std::uint8_t(side)};
    const int axis = int(side / 2);
    (side & 1 ? face.lower : face.upper)[axis] = (side & 1 ? face.upper : face.lower)[axis];
    return face;
}

/// A lower bound, in pixels, of the projected side of cells `levels` below this one, each half as large as its parent.
inline float least_projected_side(const Cell& cell, unsigned levels, const LocalView& view) {
    const float side = cell.largest_side() * two_to_the_minus(levels);
    const glm::vec3 d = cell.center - view.eye;
    const float farthest = view.distance == DistanceMeasure::depth
                               ? glm::dot(d, view.forward) + glm::dot(glm::abs(view.forward), cell.half)
                               : length_of(d) + length_of(cell.half);
    return view.pixels(side, farthest);
}

/// Whether a box of this side is small enough on the screen to be deposited as a splat.
inline bool is_small(glm::vec3 center, float side, const LocalView& view, float splat_limit_px) {
    return splat_limit_px > 0 && view.pixels(side, view.is_perspective ? view.depth(center) : 1.0f) <= splat_limit_px;
}

/// One deposit for faces seen from far enough: `footprint` is their area seen squarely, in squares of `unit`, `sum`
/// their premultiplied colors (0 to 255) weighted by it, with an alpha above 0. The covered part of the footprint
/// decides the law.
inline Splat splat_of(glm::vec3 center, float footprint, float unit, glm::vec4 sum, const LocalView& view) {
    // Where all faces are opaque, both are sums that were rounded in different ways.
    const float alpha = std::min(sum.w / (255 * footprint), 1.0f);
    const AreaLaw law = law_of_opacity(alpha);
    // Of cells that are all but flat and seen from their edge, the inverse of the area would be infinite.
    const glm::vec3 rgb = glm::min(glm::vec3(sum) * (255.0f / std::max(sum.w, 0x1p-118f)) + 0.5f, glm::vec3(255.0f));
    return {center, glm::vec2(unit * std::sqrt(footprint * view.stretch(center))), alpha,
            Rgba8{std::uint8_t(rgb.x), std::uint8_t(rgb.y), std::uint8_t(rgb.z), std::uint8_t(law)}};
}

}  // namespace farfield
