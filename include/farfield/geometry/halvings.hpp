// Sizes that are halved at every level of a hierarchy.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>

namespace farfield {

/// 2^-levels, exactly; 2^-126, the smallest normal number, for more than 126 levels.
inline float two_to_the_minus(unsigned levels) {
    return std::bit_cast<float>((127u - std::min(levels, 126u)) << 23);
}

}  // namespace farfield
