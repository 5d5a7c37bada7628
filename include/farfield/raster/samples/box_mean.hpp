// The box filter of a pixel's samples.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "farfield/geometry/rgba8.hpp"

namespace farfield::detail {

/// The mean of a_side x a_side samples, at most 8 x 8, rounded to nearest; rows are `stride` apart.
inline Rgba8 mean_of_samples(const Rgba8* samples, std::size_t stride, int a_side) {
    // A word holds two channels: sums of 64 samples stay below 2^16.
    std::uint32_t even = 0, odd = 0;
    for (int y = 0; y < a_side; ++y, samples += stride) {
        for (int x = 0; x < a_side; ++x) {
            const auto sample = std::bit_cast<std::uint32_t>(samples[x]);
            even += sample & 0x00ff00ffu;
            odd += sample >> 8 & 0x00ff00ffu;
        }
    }
    const float scale = 1.0f / float(a_side * a_side);
    const auto byte = [scale](std::uint32_t sum) {
        return std::uint32_t(std::min(float(sum & 0xffffu) * scale + 0.5f, 255.0f));
    };
    return std::bit_cast<Rgba8>(byte(even) | byte(odd) << 8 | byte(even >> 16) << 16 | byte(odd >> 16) << 24);
}

}  // namespace farfield::detail
