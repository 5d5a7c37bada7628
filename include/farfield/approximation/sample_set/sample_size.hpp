// How many polygons make a sample, and which: sections 4.3 and 5.2 of Klein et al. 2002.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "farfield/geometry/mixed.hpp"

namespace farfield {

/// The constant c of Theorem 1 by which an image is correct with a probability between 0 and 1, if the traversal stops
/// at so many cells (Corollary 1): p^cells, where p = exp(-exp(-c)) is that of one cell.
inline double sample_constant(double probability_of_correct_image, double cells = 1e4) {
    return -std::log(-std::log(probability_of_correct_image) / cells);
}

/// Theorem 1: m = q ln q + c q drawings, where q is the area in a cell in squares of its side. A q below 1 is drawn for
/// as 1 is, since the proof has one group at least. The paper rounds q up; but an area of 1.0001 sides would then take
/// twice as many polygons as one of 1. At least 1, and at most 2^31.
inline std::uint32_t sample_size(double q, double c) {
    const double groups = q > 1 ? std::min(q, 0x1p31) : 1.0;
    // Less a thousandth, lest rounding take one more.
    const double m = std::ceil(groups * std::log(groups) + c * groups - 1e-3);
    return std::uint32_t(std::clamp(m, 1.0, 0x1p31));
}

namespace detail {

/// Uniform in (0, 1), by a primitive's index and a seed: splitmix64's finalizer.
inline double uniform_of(std::uint32_t index, std::uint32_t seed) {
    std::uint64_t h = mixed(std::uint64_t(seed) + 1, index);
    h = (h ^ h >> 30) * 0xbf58476d1ce4e5b9u;
    h = (h ^ h >> 27) * 0x94d049bb133111ebu;
    h ^= h >> 31;
    return (double(h >> 11) + 0.5) * 0x1p-53;
}

/// The time at which an exponential clock of rate `area`, above 0, goes off: it is the first of several with a
/// probability proportional to its area.
inline float race_key(std::uint32_t index, std::uint32_t seed, double area) {
    return float(std::min(-std::log(uniform_of(index, seed)) / area, double(0x1.fffffep127f)));
}

}  // namespace detail
}  // namespace farfield
