#include "scenes/how_drawn.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace farfield::scenes {

Rgba8 tint_of_level(unsigned depth) {
    constexpr std::array<Rgba8, 6> tints{Rgba8{230, 60, 50},  Rgba8{245, 160, 30}, Rgba8{120, 190, 50},
                                         Rgba8{30, 170, 190}, Rgba8{60, 100, 220}, Rgba8{170, 70, 200}};
    return tints[depth % tints.size()];
}

Image geometry_in_gray(const Image& stand_ins_black, const Image& stand_ins_tinted) {
    Image out = stand_ins_tinted;
    for (std::size_t i = 0; i < out.pixels().size(); ++i) {
        const Rgba8 geometry = stand_ins_black.pixels()[i], both = stand_ins_tinted.pixels()[i];
        const int gray = (2126 * geometry.r + 7152 * geometry.g + 722 * geometry.b + 5000) / 10000;
        const auto channel = [&](int with_tint, int without) {
            return std::uint8_t(std::clamp(gray + with_tint - without, 0, int(both.a)));
        };
        out.pixels()[i] = {channel(both.r, geometry.r), channel(both.g, geometry.g), channel(both.b, geometry.b),
                           both.a};
    }
    return out;
}

}  // namespace farfield::scenes
