// The part of two pictures that is compared.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>

#include "farfield/fail.hpp"
#include "farfield/image.hpp"

namespace farfield {

/// A half-open rectangle of the pixels x0 <= x < x1, y0 <= y < y1, counted from the top left. Any rectangle is legal,
/// also one that reaches beyond a picture; one with x1 <= x0 or y1 <= y0 is empty.
struct PixelRect {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;

    bool is_empty() const { return x1 <= x0 || y1 <= y0; }
    /// Width and height of a rectangle that was clipped to an image and is not empty.
    int width() const { return x1 - x0; }
    int height() const { return y1 - y0; }

    PixelRect clipped_to(const Image& image) const {
        return {std::max(x0, 0), std::max(y0, 0), std::min(x1, image.width()), std::min(y1, image.height())};
    }

    friend constexpr bool operator==(const PixelRect&, const PixelRect&) = default;
};

/// The pixels that are compared: `rect` clipped to the pictures, or all of them without one. Never empty:
/// throws std::invalid_argument if no pixel is left, as an average over nothing is not a number, and if the
/// pictures differ in size.
inline PixelRect compared_rect(const Image& variant, const Image& reference, std::optional<PixelRect> rect) {
    if (variant.width() != reference.width() || variant.height() != reference.height()) {
        detail::fail<std::invalid_argument>("farfield: pictures of different sizes cannot be compared");
    }
    const PixelRect whole{0, 0, reference.width(), reference.height()};
    const PixelRect compared = rect.value_or(whole).clipped_to(reference);
    if (compared.is_empty()) {
        detail::fail<std::invalid_argument>("farfield: the rectangle to compare holds no pixel of the pictures");
    }
    return compared;
}

}  // namespace farfield
