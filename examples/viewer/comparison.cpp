#include "comparison.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "farfield/measure/flip.hpp"
#include "farfield/measure/image_error.hpp"

namespace viewer {

using farfield::Image;
using farfield::Rgba8;

Rgba8 tint_of_error(float error) {
    static constexpr std::array<Rgba8, 6> stops{Rgba8{0, 0, 4, 255},      Rgba8{60, 15, 110, 255},
                                                Rgba8{140, 40, 130, 255}, Rgba8{220, 70, 95, 255},
                                                Rgba8{252, 155, 70, 255}, Rgba8{252, 250, 190, 255}};
    const float at = std::clamp(error, 0.0f, 1.0f) * float(stops.size() - 1);
    const std::size_t first = std::min(std::size_t(at), stops.size() - 2);
    const float t = at - float(first);
    const auto between = [t](std::uint8_t a, std::uint8_t b) {
        return std::uint8_t(std::lround(float(a) + t * float(int(b) - int(a))));
    };
    const Rgba8 a = stops[first], b = stops[first + 1];
    return {between(a.r, b.r), between(a.g, b.g), between(a.b, b.b), 255};
}

Compared compare(const Image& variant, const Image& exact, Difference difference) {
    Compared out{.picture = Image(variant.width(), variant.height())};
    out.rmse = farfield::rmse(variant, exact);
    if (difference == Difference::flip) {
        const std::vector<float> errors = farfield::flip_map(variant, exact);
        double sum = 0;
        for (std::size_t i = 0; i < errors.size(); ++i) {
            out.picture.pixels()[i] = tint_of_error(errors[i]);
            sum += double(errors[i]);
        }
        out.flip = sum / double(errors.size());
        return out;
    }
    constexpr float gain = 4;
    for (std::size_t i = 0; i < out.picture.pixels().size(); ++i) {
        const Rgba8 a = variant.pixels()[i], b = exact.pixels()[i];
        const int most = std::max({std::abs(a.r - b.r), std::abs(a.g - b.g), std::abs(a.b - b.b)});
        out.picture.pixels()[i] = tint_of_error(gain * float(most) / 255);
    }
    return out;
}

}  // namespace viewer
