// A cell of a partition. Cells are not stored but computed at every descent.
#pragma once

#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "farfield/geometry/box.hpp"

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
};

}  // namespace farfield
