// The boxes around what the two sides of a plane hold, small enough to be kept with every node.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include "farfield/geometry/box.hpp"
#include "farfield/geometry/cell.hpp"

namespace farfield::detail {

/// Makes the cell a step wider than the box, so that center and half side hold it after rounding.
inline void put_around(float lower, float upper, int axis, Cell& cell) {
    const float center = Box{glm::vec3(lower), glm::vec3(upper)}.center().x;
    cell.center[axis] = cell.bounds_center[axis] = center;
    cell.half[axis] = cell.bounds_half[axis] = std::max(center - lower, upper - center) * (1 + 0x1p-22f);
}

/// Bounds of two children in 1/255 of their parent's, rounded outwards.
struct ChildBoxes {
    std::array<glm::u8vec3, 2> lower, upper;

    /// A box that is empty becomes all of the parent's.
    void fit(const Box& parent, std::size_t side, const Box& child) {
        lower[side] = glm::u8vec3(0);
        upper[side] = glm::u8vec3(255);
        if (child.is_empty()) return;
        for (int axis = 0; axis < 3; ++axis) {
            const float from = parent.lower[axis], to = parent.upper[axis];
            const float steps = to > from ? 255 / (to - from) : 0.0f;
            // Where the cell is so thin that steps are infinite, a NaN is step 0.
            const auto step = [&](float p) {
                const float s = (p - from) * steps;
                return std::uint8_t(s > 0 ? std::min(s, 255.0f) : 0.0f);
            };
            std::uint8_t first = step(child.lower[axis]), last = step(child.upper[axis]);
            while (first > 0 && at(from, to, first) > child.lower[axis]) --first;
            while (last < 255 && at(from, to, last) < child.upper[axis]) ++last;
            lower[side][axis] = first;
            upper[side][axis] = last;
        }
    }

    float lower_of(const Box& parent, std::size_t side, int axis) const {
        return at(parent.lower[axis], parent.upper[axis], lower[side][axis]);
    }
    float upper_of(const Box& parent, std::size_t side, int axis) const {
        return at(parent.lower[axis], parent.upper[axis], upper[side][axis]);
    }

  private:
    static float at(float from, float to, std::uint8_t step) {
        return step == 0 ? from : step == 255 ? to : from + (to - from) * (float(step) * (1.0f / 255));
    }
};

}  // namespace farfield::detail
