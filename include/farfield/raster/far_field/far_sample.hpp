// The far field in front of one sample: its color, and how much light still comes through in each of 4 x 4 lanes.
// Things side by side in a sample then add up and things one behind the other do not, whatever the area law
// (geometry/area_law.hpp).
//
// Lanes are integers of 16 bits, and 65535 stands for one. It is 257 x 255, hence the units that edges are rounded to:
// 1/257 of a lane's width and 1/255 of its height. The part of a lane between two pairs of edges is then the product of
// two integers, exactly, and squares that share edges cover a lane once.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstdint>

#include "farfield/geometry/area_law.hpp"

namespace farfield::detail {

namespace lanes {
inline constexpr int side = 4, count = side * side;  ///< of a sample
inline constexpr int one = 65535;
inline constexpr int width = 257, height = 255;  ///< of a lane, in units
inline constexpr int sample_width = side * width, sample_height = side * height;
static_assert(width * height == one);
inline constexpr int most_samples = 16;  ///< that a small square touches along a side
inline constexpr int closed = int(closed_transmittance * float(count * one));  ///< where the sum of lanes is below
}  // namespace lanes

/// Not set to anything by itself, so that memory for many is not touched before they are.
struct alignas(16) FarSample {
    float r, g, b;        ///< premultiplied
    float transmittance;  ///< mean of the lanes, or 0 if that is below closed_transmittance

    /// What nothing was deposited into.
    static constexpr FarSample fresh() { return {0, 0, 0, 1}; }
};

/// Most of a large deposit's samples are covered whole, and their lanes stay alike: the transmittance tells them. Lanes
/// are kept, and memory for them touched, only of samples that something covers in part.
struct alignas(32) FarLanes {
    std::uint16_t lane[lanes::count];  ///< row by row

    void fill(std::uint16_t all) { std::fill_n(lane, lanes::count, all); }
};

/// What each of a sample's lanes is, if they are alike. The transmittance was computed from it with an error far below
/// half a unit.
inline int lane_of(float transmittance) {
    return int(transmittance * float(lanes::one) + 0.5f);
}

}  // namespace farfield::detail
