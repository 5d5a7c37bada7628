// Where boxes lie along the normal of a plane, and on which side of it.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "farfield/geometry/length.hpp"
#include "farfield/partition.hpp"
#include "farfield/partition/extent.hpp"

namespace farfield::detail {

/// The axis that a direction of length 1 lies along, or -1.
inline int axis_of(glm::vec3 normal) {
    for (int axis = 0; axis < 3; ++axis) {
        if (std::abs(normal[axis]) == 1) return axis;
    }
    return -1;
}

/// A direction of length 1, or zero; exact along an axis, where touching boxes must touch.
inline glm::vec3 unit_direction(glm::vec3 d) {
    for (int axis = 0; axis < 3; ++axis) {
        glm::vec3 along(0);
        along[axis] = d[axis];
        if (along != d) continue;
        along[axis] = d[axis] > 0 ? 1.0f : d[axis] < 0 ? -1.0f : 0.0f;
        return along;
    }
    return direction_of(d);
}

/// Heights above a cell's center: along an axis just what the box says, so that neighbors which touch do so here.
class HeightsInCell {
  public:
    HeightsInCell(glm::vec3 normal, const Cell& cell) : normal_(normal), center_(cell.center), axis_(axis_of(normal)) {}

    Extent of(const Box& box) const {
        if (axis_ >= 0) {
            const float a = (box.lower[axis_] - center_[axis_]) * normal_[axis_],
                        b = (box.upper[axis_] - center_[axis_]) * normal_[axis_];
            return {std::min(a, b), std::max(a, b), 0, false};
        }
        const glm::vec3 a = (box.lower - center_) * normal_, b = (box.upper - center_) * normal_;
        const glm::vec3 least = glm::min(a, b), most = glm::max(a, b);
        return {least.x + least.y + least.z, most.x + most.y + most.z, 0, false};
    }

  private:
    glm::vec3 normal_, center_;
    int axis_;
};

/// The side of a plane that a thing stored once goes to: 0 behind it, 1 in front, or -1 where it is too long for
/// either.
class SidesInCell {
  public:
    SidesInCell(const Cell& cell, const CuttingPlane& plane)
        : heights_(plane.normal, cell), offset_(plane.offset), longest_(glm::dot(glm::abs(plane.normal), cell.half)) {}

    int side_of(const Box& box) const {
        const Extent e = heights_.of(box);
        if (e.upper <= offset_) return 0;
        if (e.lower >= offset_) return 1;
        if (e.upper - e.lower > longest_) return -1;
        return e.lower + e.upper < 2 * offset_ ? 0 : 1;
    }

  private:
    HeightsInCell heights_;
    float offset_, longest_;
};

/// The part of a box behind a plane across an axis, or in front of it.
inline Box half_of(Box box, const Cell& cell, const CuttingPlane& plane, bool is_behind) {
    const int axis = axis_of(plane.normal);
    if (axis < 0) return box;
    const float at = cell.center[axis] + plane.offset * plane.normal[axis];
    if (is_behind == (plane.normal[axis] > 0)) {
        box.upper[axis] = std::min(box.upper[axis], at);
    } else {
        box.lower[axis] = std::max(box.lower[axis], at);
    }
    return box;
}

}  // namespace farfield::detail
