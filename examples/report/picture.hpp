// From what a renderer gives to what people look at.
#pragma once

#include <filesystem>
#include <span>

#include "farfield/image.hpp"

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

/// From left to right, with lines of `gap` white pixels between. At least one, all of one height.
Image side_by_side(std::span<const Image> images, int gap);

/// How often something was visited, row by row: a value for each pixel, or for each square of them.
struct WorkMap {
    std::span<const float> visits;
    int columns = 0, rows = 0;
};

/// In grays of a logarithmic scale: black is 1/64 a pixel or less, the middle 1, white 64 or more. Visits of a square
/// are shared out among its pixels, `width` being about `columns` times its side.
Image work_image(const WorkMap& map, int width, int height);

/// Colors only, for opaque images. Throws std::runtime_error naming the file.
void write_png(const Image& image, const std::filesystem::path& file);

}  // namespace farfield::report
