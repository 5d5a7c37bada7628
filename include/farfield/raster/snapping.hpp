// Snaps coordinates to 1/256 sample; coverage is exact from there on.
#pragma once

#include "farfield/settings.hpp"

#include <bit>
#include <cstdint>

namespace farfield::detail {

/// Adding this rounds any float below 2^22 to the nearest integer and leaves that in the low bits.
inline constexpr float snap_rounder = 12582912.0f;
inline constexpr std::uint32_t snap_rounder_bits = 0x4b400000;
inline std::int32_t snapped_to_256th(float v) {
    return std::int32_t(std::bit_cast<std::uint32_t>(v + snap_rounder) - snap_rounder_bits);
}

}  // namespace farfield::detail
