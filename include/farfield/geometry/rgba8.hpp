// Colors of eight bits a channel. Alpha is not premultiplied unless a comment says so where one is used.
#pragma once

#include "farfield/settings.hpp"

#include <cstdint>
#include <glm/vec4.hpp>

namespace farfield {

struct Rgba8 {
    std::uint8_t r = 0, g = 0, b = 0, a = 255;

    friend constexpr bool operator==(const Rgba8&, const Rgba8&) = default;
};
static_assert(sizeof(Rgba8) == 4);

/// The color with its channels in [0, 1].
inline glm::vec4 to_vec4(Rgba8 c) {
    return glm::vec4(float(c.r), float(c.g), float(c.b), float(c.a)) * (1.0f / 255.0f);
}

/// Rounds to nearest; channels outside [0, 1] are clamped, NaN becomes 0.
inline Rgba8 to_rgba8(glm::vec4 c) {
    const auto byte = [](float v) {
        return static_cast<std::uint8_t>(v > 0 ? (v < 1 ? v * 255.0f + 0.5f : 255.0f) : 0.0f);
    };
    return {byte(c.x), byte(c.y), byte(c.z), byte(c.w)};
}

/// The color times its alpha, as what is drawn over something else is kept; rounded to nearest.
inline Rgba8 premultiplied(Rgba8 c) {
    const auto part = [&](std::uint8_t v) { return static_cast<std::uint8_t>((unsigned(v) * c.a + 127) / 255); };
    return {part(c.r), part(c.g), part(c.b), c.a};
}

}  // namespace farfield
