// From what a renderer gives to what people look at.
#pragma once

#include <filesystem>

#include "farfield/raster/image.hpp"

namespace farfield::report {

/// A gradient down the image, opaque.
struct Background {
    Rgba8 top{255, 255, 255};
    Rgba8 bottom{255, 255, 255};
};

/// Opaque.
Image over_background(const Image& premultiplied, const Background& background);

/// How many times differences are amplified, so that a quarter of the range is white.
inline constexpr int difference_gain = 4;

/// Absolute differences of each channel times difference_gain, opaque, black where equal. Of one size.
Image difference(const Image& a, const Image& b);

/// Colors only, for opaque images. Throws std::runtime_error naming the file.
void write_png(const Image& image, const std::filesystem::path& file);

}  // namespace farfield::report
