// Chooses a given number of a pixel's 64 samples, scattered over it.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <utility>

namespace farfield::detail {

/// The first n samples of a random permutation of 64, for n of 0 to 64.
inline constexpr auto first_samples = [] {
    std::array<std::uint64_t, 65> masks{};
    std::array<unsigned, 64> order{};
    for (unsigned k = 0; k < 64; ++k) order[k] = k;
    std::uint32_t state = 1;
    for (unsigned k = 64; k > 1; --k) {
        state = state * 1664525u + 1013904223u;
        std::swap(order[k - 1], order[(state >> 16) % k]);
    }
    for (unsigned k = 0; k < 64; ++k) masks[k + 1] = masks[k] | std::uint64_t(1) << order[k];
    return masks;
}();

/// Chooses alpha / 255 of the samples: exactly so on average, at most one more or less in a pixel, the same in every
/// frame. The mask is turned by a hash of thing and pixel, so that of two things over one another each covers, on
/// average, its part of what the other leaves. (x, y) is the pixel's first sample.
inline std::uint64_t scattered_samples(std::uint8_t alpha, std::uint32_t hash, int x, int y) {
    std::uint32_t h = std::uint32_t(x) * 0x9e3779b1u ^ std::uint32_t(y) * 0x85ebca77u ^ hash;
    h = (h ^ h >> 15) * 0x2c1b3c6du;
    h = (h ^ h >> 12) * 0x297a2d39u;
    h ^= h >> 15;
    const unsigned count = std::min((unsigned(alpha) * 64 + (h & 255) * 254 / 255) / 255, 64u);
    const std::uint64_t mask = std::rotl(first_samples[count], int(h >> 8 & 7) * 8);
    const unsigned columns = h >> 11 & 7;
    const std::uint64_t wrapped = 0x0101010101010101u * ((1u << columns) - 1);
    return (mask << columns & ~wrapped) | (mask >> (8 - columns) % 8 & wrapped);
}

}  // namespace farfield::detail
