// Errors between the colors of two pictures, pixel by pixel.
//
// The definitions and their limits: Z. Wang, A. C. Bovik, "Mean Squared Error: Love It or Leave It?
// A New Look at Signal Fidelity Measures", IEEE Signal Processing Magazine 26(1), 2009.
#pragma once

#include "farfield/settings.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "farfield/image.hpp"
#include "farfield/measure/pixel_rect.hpp"

namespace farfield {

/// Mean squared error over the pixels of `rect` (without one: all) and their red, green and blue, each as
/// stored, in [0, 1]: 0 for equal pictures, 1 for black against white. Symmetric. Alpha is not compared: draw
/// both over the same background, see coverage_error.hpp for pictures without one. Throws as `compared_rect`
/// does.
inline double mse(const Image& variant, const Image& reference, const std::optional<PixelRect>& rect = {}) {
    const PixelRect r = compared_rect(variant, reference, rect);
    const auto squared = [](std::uint8_t a, std::uint8_t b) {
        const std::int64_t difference = std::int64_t{a} - std::int64_t{b};
        return difference * difference;
    };
    // Integers: exact in any order, and enough of them for 2^45 pixels.
    std::int64_t sum = 0;
    for (int y = r.y0; y < r.y1; ++y) {
        for (int x = r.x0; x < r.x1; ++x) {
            const Rgba8 v = variant.at(x, y);
            const Rgba8 w = reference.at(x, y);
            sum += squared(v.r, w.r) + squared(v.g, w.g) + squared(v.b, w.b);
        }
    }
    const double channels = 3.0 * r.width() * r.height();
    return static_cast<double>(sum) / (channels * 255.0 * 255.0);
}

/// Square root of `mse`, in the unit of a channel.
inline double rmse(const Image& variant, const Image& reference, const std::optional<PixelRect>& rect = {}) {
    return std::sqrt(mse(variant, reference, rect));
}

/// Peak signal-to-noise ratio in decibels, for channels whose peak is 1: 0 for black against white, larger is
/// better, +infinity for equal pictures.
inline double psnr(const Image& variant, const Image& reference, const std::optional<PixelRect>& rect = {}) {
    const double error = mse(variant, reference, rect);
    return error > 0 ? -10.0 * std::log10(error) : std::numeric_limits<double>::infinity();
}

}  // namespace farfield
