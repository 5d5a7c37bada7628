// Images that color the corners of triangles. Not for users, as load_detail.hpp.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <string_view>
#include <vector>

#include "farfield/geometry/rgba8.hpp"

namespace farfield::scenes::detail {

struct Image {
    int width = 0, height = 0;
    std::vector<Rgba8> texels{};  ///< the top row first
};

/// PNG, JPEG, TGA or BMP, whatever the file's name says. No texels if it is none of them, is broken or has more than
/// 2^26 texels: no header is believed before that is checked.
Image decoded(std::string_view bytes);

/// What lies beyond the unit square.
enum class Wrap : std::uint8_t { repeat, mirror, clamp };

/// An image as a material uses it. The image outlives it and has texels.
struct Texture {
    const Image* image = nullptr;
    Wrap across = Wrap::repeat, up = Wrap::repeat;
    /// Texels with less are not seen: 0 where the material ignores alpha.
    std::uint8_t least_alpha = 128;

    /// The nearest texel; (0, 0) is the lower left corner of the image. What is not finite counts as 0.
    Rgba8 at(glm::vec2 uv) const;

    /// A texel for each corner of a triangle. It is taken from a tenth of the way to the middle, for in atlases the
    /// corner's own texel may be the neighbor's. Cut-out leaves are drawn whole, and the color of a texel that is not
    /// seen is often black: then the first that is seen on the way to the middle counts, else the mean of those within
    /// the triangle, else the mean of those of the image, else white.
    std::array<Rgba8, 3> corners(const std::array<glm::vec2, 3>& uv) const;
};

}  // namespace farfield::scenes::detail
