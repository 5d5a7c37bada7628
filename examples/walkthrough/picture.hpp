// From what a renderer gives to what people look at.
#pragma once

#include <filesystem>

#include "farfield/raster/image.hpp"
#include "setting.hpp"

namespace walkthrough {

/// Over the setting's background; opaque.
farfield::Image over_background(const farfield::Image& premultiplied, const Setting& setting);

/// How many times differences are amplified, so that a quarter of the range is white.
inline constexpr int difference_gain = 4;

/// Absolute differences of each channel times difference_gain, opaque, black where equal. Of one size.
farfield::Image difference(const farfield::Image& a, const farfield::Image& b);

/// Colors only, for opaque images. Throws std::runtime_error naming the file.
void write_png(const farfield::Image& image, const std::filesystem::path& file);

}  // namespace walkthrough
