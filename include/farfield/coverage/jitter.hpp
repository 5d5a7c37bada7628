// Jittered samples: each lies at random within its own square of the 8 x 8 of a pixel, which turns aliasing into noise.
// Pixels choose among several such patterns, because a single one gives "subtle patterned aliasing artifacts" (Greene
// 1996, sections 4.4 and 9; R. L. Cook, "Stochastic Sampling in Computer Graphics", ACM Transactions on
// Graphics 5(1), 1986).
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <stdexcept>
#include <vector>

#if defined(__SSE2__)
#include <emmintrin.h>

#include "farfield/fail.hpp"
#endif

namespace farfield::detail {

/// The positions of a pixel's 64 samples, row by row; without jitter at first.
struct alignas(16) JitterPattern {
    /// x and y of each in 1/256 sample, from the regular center of the first one.
    std::int16_t position[64][2];

    constexpr JitterPattern() : position() {
        for (unsigned k = 0; k < 64; ++k) place(k, 0, 0);
    }
    /// Places sample k = 8 * row + column relative to its regular center: -128 to 127.
    constexpr void place(unsigned k, int x, int y) {
        position[k][0] = std::int16_t(int(k % 8) * 256 + x);
        position[k][1] = std::int16_t(int(k / 8) * 256 + y);
    }
    constexpr int x(unsigned k) const { return position[k][0] - int(k % 8) * 256; }
    constexpr int y(unsigned k) const { return position[k][1] - int(k / 8) * 256; }
};

/// The samples of a jittered pixel that an edge function does not exclude: bit k is set where
/// e + a * position[k][0] + b * position[k][1] >= 0. So `e` is the value at the regular center of the pixel's first
/// sample, and `a` and `b` are the growth by 1/256 sample. Exact for |e| < 2^62 and |a|, |b| < 2^24: the reversed edge,
/// (-e - 1, -a, -b), gives the complement.
std::uint64_t samples(const JitterPattern& pattern, std::int64_t e, std::int32_t a, std::int32_t b);

/// The most by which an edge function can differ at a sample from its value at the sample's regular center.
inline std::int64_t jitter_slack(std::int32_t a, std::int32_t b) {
    return 128 * (std::abs(std::int64_t(a)) + std::abs(std::int64_t(b)));
}

class JitterPatterns {
  public:
    /// The same seed gives the same patterns everywhere. Throws std::invalid_argument for 0 or too many.
    explicit JitterPatterns(std::size_t count, std::uint64_t seed = 0) {
        if (count == 0 || count > 0xffffffffu) {
            detail::fail<std::invalid_argument>("farfield::JitterPatterns: the count must be from 1 to 2^32 - 1");
        }
        patterns_.resize(count);
        for (JitterPattern& pattern : patterns_) {
            for (unsigned k = 0; k < 64; ++k) {
                const std::uint64_t bits = scrambled(seed += 0x9e3779b97f4a7c15u);
                pattern.place(k, int(bits >> 56) - 128, int(bits >> 48 & 255) - 128);
            }
        }
    }

    std::size_t size() const { return patterns_.size(); }
    const JitterPattern& operator[](std::size_t i) const { return patterns_[i]; }
    /// A pixel's pattern: irregular, but the same in every frame, so that still images do not flicker.
    const JitterPattern& pattern_of(int x_px, int y_px) const {
        const std::uint64_t hash = scrambled(std::uint64_t(std::uint32_t(y_px)) << 32 | std::uint32_t(x_px));
        return patterns_[std::size_t((hash >> 32) * patterns_.size() >> 32)];
    }

  private:
    /// splitmix64 (G. L. Steele, D. Lea, C. H. Flood, "Fast Splittable Pseudorandom Number Generators", OOPSLA 2014).
    static std::uint64_t scrambled(std::uint64_t z) {
        z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
        z = (z ^ z >> 27) * 0x94d049bb133111ebu;
        return z ^ z >> 31;
    }

    std::vector<JitterPattern> patterns_;
};

/// Applies the definition.
inline std::uint64_t samples_one_by_one(const JitterPattern& pattern, std::int64_t e, std::int32_t a, std::int32_t b) {
    std::uint64_t mask = 0;
    for (unsigned k = 0; k < 64; ++k) {
        const std::int64_t x = pattern.position[k][0], y = pattern.position[k][1];
        mask |= std::uint64_t(a * x + b * y >= -e) << k;
    }
    return mask;
}

#if defined(__SSE2__)
/// An edge function E split for arithmetic of 32 bits: with a = 512 A + a', b and e alike, and primed ones in
/// [0, 512), E is 0 or more where A x + B y + C + floor((a' x + b' y + e') / 512) is. A and B have 16 bits, and C may
/// be cut off where the other terms, below 2^28, do not reach. A short edge, |a|, |b| < 2^15, needs no split.
template <bool is_short>
std::uint64_t samples_eight_at_a_time(const JitterPattern& pattern, std::int64_t e, std::int32_t a, std::int32_t b) {
    const auto pair = [](std::int32_t x, std::int32_t y) {
        return _mm_set1_epi32(std::int32_t(std::uint32_t(x) & 0xffffu) | std::int32_t(std::uint32_t(y) << 16));
    };
    constexpr int shift = is_short ? 0 : 9;
    const __m128i upper = pair(a >> shift, b >> shift), lower = pair(a & 511, b & 511);
    const __m128i upper_e = _mm_set1_epi32(std::int32_t(std::clamp<std::int64_t>(e >> shift, -(1 << 29), 1 << 29)));
    const __m128i lower_e = _mm_set1_epi32(std::int32_t(e & 511));
    const auto value = [&](__m128i xy) {
        const __m128i whole = _mm_add_epi32(_mm_madd_epi16(xy, upper), upper_e);
        if (is_short) return whole;
        const __m128i rest = _mm_srai_epi32(_mm_add_epi32(_mm_madd_epi16(xy, lower), lower_e), 9);
        return _mm_add_epi32(whole, rest);
    };
    const auto row = [&](unsigned j) {  // eight values, cut off to 16 bits
        const auto* xy = reinterpret_cast<const __m128i*>(pattern.position[8 * j]);
        return _mm_packs_epi32(value(_mm_load_si128(xy)), value(_mm_load_si128(xy + 1)));
    };
    std::uint64_t negative = 0;
    for (unsigned j = 0; j < 8; j += 2) {
        const int signs = _mm_movemask_epi8(_mm_packs_epi16(row(j), row(j + 1)));
        negative |= std::uint64_t(std::uint32_t(signs)) << (8 * j);
    }
    return ~negative;
}
#endif

inline std::uint64_t samples(const JitterPattern& pattern, std::int64_t e, std::int32_t a, std::int32_t b) {
#if defined(__SSE2__)
    const bool is_short = std::int16_t(a) == a && std::int16_t(b) == b;
    return is_short ? samples_eight_at_a_time<true>(pattern, e, a, b)
                    : samples_eight_at_a_time<false>(pattern, e, a, b);
#else
    return samples_one_by_one(pattern, e, a, b);
#endif
}

}  // namespace farfield::detail
