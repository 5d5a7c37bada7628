// Masks of 4 x 4 x 4 voxels, or of cubes of voxels, on one side of a plane (Greene 1996, section 8). A voxel is bit
// 16 z + 4 y + x.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstdint>
#include <glm/vec3.hpp>

#include "farfield/coverage/triage_mask.hpp"
#include "farfield/voxel/voxel_plane.hpp"

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace farfield::detail {

/// Which of 64 values e + a x + b y + c z are negative? Values are below 2^63.
inline std::uint64_t negative_voxels_scalar(std::int64_t e, std::int64_t a, std::int64_t b, std::int64_t c) {
    std::uint64_t mask = 0;
    for (int row = 0; row < 16; ++row) {
        const std::int64_t v = e + b * (row & 3) + c * (row >> 2);
        const std::uint64_t bits = std::uint64_t(v < 0) | std::uint64_t(v + a < 0) << 1 |
                                   std::uint64_t(v + 2 * a < 0) << 2 | std::uint64_t(v + 3 * a < 0) << 3;
        mask |= bits << (4 * row);
    }
    return mask;
}

/// The same in a quarter of the time where the machine is known to have SSE2.
inline std::uint64_t negative_voxels(std::int64_t e, std::int64_t a, std::int64_t b, std::int64_t c) {
#if defined(__SSE2__)
    // A register holds two values; the halves with the signs of a row are taken, and packing keeps signs because it
    // saturates.
    const auto signs = [](__m128i left, __m128i right) {
        return _mm_castps_si128(
            _mm_shuffle_ps(_mm_castsi128_ps(left), _mm_castsi128_ps(right), _MM_SHUFFLE(3, 1, 3, 1)));
    };
    const __m128i by_y = _mm_set1_epi64x(b), by_2y = _mm_add_epi64(by_y, by_y), by_z = _mm_set1_epi64x(c);
    __m128i left = _mm_set_epi64x(e + a, e), right = _mm_add_epi64(left, _mm_set1_epi64x(2 * a));
    std::uint64_t mask = 0;
    for (int z = 0; z < 4; ++z) {
        const __m128i left_1 = _mm_add_epi64(left, by_y), right_1 = _mm_add_epi64(right, by_y);
        const __m128i rows_01 = _mm_packs_epi32(signs(left, right), signs(left_1, right_1));
        const __m128i rows_23 = _mm_packs_epi32(signs(_mm_add_epi64(left, by_2y), _mm_add_epi64(right, by_2y)),
                                                signs(_mm_add_epi64(left_1, by_2y), _mm_add_epi64(right_1, by_2y)));
        mask |= std::uint64_t(std::uint32_t(_mm_movemask_epi8(_mm_packs_epi16(rows_01, rows_23)))) << (16 * z);
        left = _mm_add_epi64(left, by_z);
        right = _mm_add_epi64(right, by_z);
    }
    return mask;
#else
    return negative_voxels_scalar(e, a, b, c);
#endif
}

/// The mask of 64 cubes of `side` voxels a side; e is the plane's value at the first voxel of the first cube. It is
/// exact: cubes are covered if all their voxels are inside and vacant if none is.
inline TriageMask voxel_triage(std::int64_t e, const VoxelPlane& p, int side) {
    const std::int64_t zero = 0, last = side - 1;
    const std::int64_t least = last * (std::min(p.a, zero) + std::min(p.b, zero) + std::min(p.c, zero));
    const std::int64_t most = last * (std::max(p.a, zero) + std::max(p.b, zero) + std::max(p.c, zero));
    return {~negative_voxels(e + least, side * p.a, side * p.b, side * p.c),
            negative_voxels(e + most, side * p.a, side * p.b, side * p.c)};
}

/// The mask of the first size.x by size.y by size.z of 4 x 4 x 4, each clamped to [0, 4].
inline std::uint64_t voxel_corner(glm::ivec3 size) {
    const auto ones = [](int bits) { return bits >= 64 ? all_subcells : (std::uint64_t(1) << std::max(bits, 0)) - 1; };
    return ones(std::min(size.x, 4)) *
           (0x1111111111111111u & ones(4 * std::min(size.y, 4)) * 0x0001000100010001u & ones(16 * std::min(size.z, 4)));
}

}  // namespace farfield::detail
