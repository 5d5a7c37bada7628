// A picture in memory, which the software renderers make and measure/ compares.
#pragma once

#include "farfield/settings.hpp"

#include <cstddef>
#include <span>
#include <stdexcept>
#include <vector>

#include "farfield/fail.hpp"
#include "farfield/geometry/rgba8.hpp"

namespace farfield {

/// Rows run from top to bottom and pixels from left to right, without padding. Colors with alpha below 255 are
/// premultiplied: a renderer without a background gives coverage in alpha.
class Image {
  public:
    Image() = default;
    /// Throws std::invalid_argument for a negative size.
    Image(int width, int height, Rgba8 fill = {0, 0, 0, 0}) : width_(width), height_(height) {
        if (width < 0 || height < 0) detail::fail<std::invalid_argument>("farfield::Image: negative size");
        pixels_.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), fill);
    }

    int width() const { return width_; }
    int height() const { return height_; }

    /// There is no bounds check.
    Rgba8& at(int x, int y) { return pixels_[index(x, y)]; }
    Rgba8 at(int x, int y) const { return pixels_[index(x, y)]; }

    std::span<Rgba8> pixels() { return pixels_; }
    std::span<const Rgba8> pixels() const { return pixels_; }

    friend bool operator==(const Image&, const Image&) = default;

  private:
    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
    }

    int width_ = 0;
    int height_ = 0;
    std::vector<Rgba8> pixels_;
};

}  // namespace farfield
