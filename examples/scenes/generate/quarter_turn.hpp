// Placements that lose no bits.
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

namespace farfield::scenes {

/// Turned by `turns` times 90 degrees about y, +z towards +x, then moved. Of zeros and ones where glm::rotate has
/// 4e-8 for cos 90 degrees, so that what touched before touches after.
inline glm::mat4 quarter_turn(int turns, glm::vec3 move) {
    constexpr float cosines[4] = {1, 0, -1, 0};
    const float c = cosines[turns & 3], s = cosines[(turns + 3) & 3];
    return {{c, 0, -s, 0}, {0, 1, 0, 0}, {s, 0, c, 0}, {move, 1}};
}

}  // namespace farfield::scenes
