// A cell of a partition. Cells are not stored but computed at every descent.
#pragma once

#include "farfield/settings.hpp"

#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <initializer_list>

#include "farfield/geometry/box.hpp"
#include "farfield/geometry/length.hpp"

namespace farfield {

/// A part of space, in the hierarchy's own coordinates (the user's less the hierarchy's origin). Centers and half
/// sides are kept instead of corners because culling and projection use them.
struct Cell {
    /// The box of the part of space that the cell stands for: colors and errors are about it.
    glm::vec3 center{0}, half{0};
    /// A box that holds all that is drawn for the cell's subtree: culling is about it.
    glm::vec3 bounds_center{0}, bounds_half{0};
    std::uint16_t depth = 0;            ///< levels below the root
    std::uint16_t partition_state = 0;  ///< for the partition's own use

    Box box() const { return {center - half, center + half}; }
    Box bounds() const { return {bounds_center - bounds_half, bounds_center + bounds_half}; }
    float largest_side() const { return 2 * glm::max(half.x, glm::max(half.y, half.z)); }

    /// A power of two by which the cell can be multiplied so that areas and volumes in it are ordinary numbers,
    /// whatever its unit of length. 1 if they are already; else the side of its bounds comes near 1.
    float to_ordinary() const {
        const int side = exponent_of(detail::largest_component(bounds_half)),
                  place = exponent_of(detail::largest_component(bounds_center));
        const int exponent = glm::clamp(glm::max(side, place - 60), -126, 126);
        return glm::abs(exponent) <= 16 ? 1.0f : std::ldexp(1.0f, -exponent);
    }
    /// The cell in a space that is `factor` times as large.
    Cell scaled(float factor) const {
        Cell cell = *this;
        for (glm::vec3* v : {&cell.center, &cell.half, &cell.bounds_center, &cell.bounds_half}) *v *= factor;
        return cell;
    }
};

}  // namespace farfield
