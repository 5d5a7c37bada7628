// Draws placed stand-ins (DrawsPlaced of approximation.hpp) with as many lanes as the processor has.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "farfield/drawables.hpp"
#include "farfield/simd.hpp"

namespace farfield {

/// The lanes of several Splats. A color has the first channel in its lowest byte.
struct PlacedSplats {
    static constexpr std::size_t most = 8;
    float x[most], y[most], z[most], width[most], height[most], opacity[most];
    std::uint32_t rgb[most];
    std::int32_t is_drawn[most];

    Splat operator[](std::size_t i) const {
        const std::uint32_t c = rgb[i];
        return {{x[i], y[i], z[i]},
                {width[i], height[i]},
                opacity[i],
                {std::uint8_t(c), std::uint8_t(c >> 8), std::uint8_t(c >> 16), std::uint8_t(c >> 24)}};
    }
};

namespace detail {

/// The same kernel for four lanes and for eight.
template <class SplatsOf>
struct PlacedKernels {
    SplatsOf four, eight;
};
template <class SplatsOf>
PlacedKernels(SplatsOf, SplatsOf) -> PlacedKernels<SplatsOf>;

/// Sends the splats of `count` placed stand-ins in order. fill(kernel, first, n, out) runs the kernel for the n from
/// `first` on; where it returns false, one(i, sink) draws each of them.
template <class SplatsOf, class Fill, class One, class Sink>
void draw_placed(const PlacedKernels<SplatsOf>& kernels, std::size_t count, Fill&& fill, One&& one, Sink&& sink) {
    const auto send = [&](const Splat& splat, std::size_t i) {
        if constexpr (requires { sink(splat, i); }) {
            sink(splat, i);
        } else {
            sink(splat);
        }
    };
    const bool has_eight = lanes_for(Simd::automatic) >= 8;
    const SplatsOf kernel = has_eight ? kernels.eight : kernels.four;
    const std::size_t lanes = has_eight ? 8 : 4;
    PlacedSplats out;
    for (std::size_t first = 0; first < count; first += lanes) {
        const std::size_t n = std::min(lanes, count - first);
        const bool is_filled = fill(kernel, first, n, out);
        for (std::size_t i = 0; i < n; ++i) {
            if (!is_filled) {
                one(first + i, [&](const Splat& splat) { send(splat, first + i); });
            } else if (out.is_drawn[i] != 0) {
                send(out[i], first + i);
            }
        }
    }
}

}  // namespace detail
}  // namespace farfield
