// A cell of a partition, as it is computed while descending.
#pragma once

#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "farfield/geometry/box.hpp"

namespace farfield {

/// A part of space, in the hierarchy's own coordinates (the user's less the hierarchy's origin). Centers and half
/// sides instead of corners, for that is what culling and projection use.
struct Cell {
    glm::vec3 center{0};  ///< of the part of space the cell stands for: colors and errors are about this box
    glm::vec3 half{0};    ///< its half side on each axis
    glm::vec3 bounds_center{
        0};  ///< of a box that holds all that is drawn for the cell's subtree: culling is about this
    glm::vec3 bounds_half{0};
    std::uint16_t depth = 0;  ///< levels below the root
    std::uint16_t stage = 0;  ///< the partition's own: which part of a nested partition is at work

    Box box() const { return {center - half, center + half}; }
    Box bounds() const { return {bounds_center - bounds_half, bounds_center + bounds_half}; }
    float largest_side() const { return 2 * glm::max(half.x, glm::max(half.y, half.z)); }
};

}  // namespace farfield
