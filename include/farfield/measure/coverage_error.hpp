// Does a stand-in cover as much of the picture as its primitives do? A far field that is too thick or too thin on
// average is a change of tone that mean squared errors rank below harmless noise; here it has a sign of its own.
//
// Simplification must keep the area that is covered, in the mean: R. L. Cook, J. Halstead, M. Planck, D. Ryu,
// "Stochastic Simplification of Aggregate Detail", SIGGRAPH 2007. The two numbers are the mean and the root mean square
// of an estimator's error, the first relative to the quantity estimated.
#pragma once

#include "farfield/settings.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "farfield/image.hpp"
#include "farfield/measure/pixel_rect.hpp"

namespace farfield {

struct CoverageError {
    /// (sum of the variant's alpha - sum of the reference's) / sum of the reference's, from -1 (all is
    /// missing) up: positive where the variant covers too much. Over an empty reference 0 if the variant is
    /// empty too, else +infinity; never NaN.
    double bias = 0;
    /// Root mean square of the difference of alpha over all pixels compared, covered or not, in [0, 1].
    double rms = 0;

    friend bool operator==(const CoverageError&, const CoverageError&) = default;
};

/// Compares alpha only, over the pixels of `rect` (without one: all). It is meant for pictures drawn without a
/// background, whose alpha is coverage; over a background alpha is 255 everywhere and both numbers are 0.
/// `rms` depends on how much empty picture is compared, `bias` does not. Throws as `compared_rect` does.
inline CoverageError coverage_error(const Image& variant, const Image& reference, std::optional<PixelRect> rect = {}) {
    const PixelRect r = compared_rect(variant, reference, rect);
    // Integers: exact in any order.
    std::int64_t sum_variant = 0;
    std::int64_t sum_reference = 0;
    std::int64_t sum_squares = 0;
    for (int y = r.y0; y < r.y1; ++y) {
        for (int x = r.x0; x < r.x1; ++x) {
            const std::int64_t v = variant.at(x, y).a;
            const std::int64_t w = reference.at(x, y).a;
            sum_variant += v;
            sum_reference += w;
            sum_squares += (v - w) * (v - w);
        }
    }
    CoverageError error;
    if (sum_reference > 0) {
        error.bias = static_cast<double>(sum_variant - sum_reference) / static_cast<double>(sum_reference);
    } else if (sum_variant > 0) {
        error.bias = std::numeric_limits<double>::infinity();
    }
    const double pixels = static_cast<double>(r.width()) * r.height();
    error.rms = std::sqrt(static_cast<double>(sum_squares) / pixels) / 255.0;
    return error;
}

}  // namespace farfield
