// How much of a pixel is left after something of a given area was drawn into it.
//
// Where two things of area X each fall into one pixel, the pixel may end up covered by 2X (they are parts of one
// surface, side by side) or by 1 - (1 - X)^2 (leaves, strewn independently). One number k tells the two apart:
//
//     T' = max(0, T^k - k X)^(1/k)        k = 1: T' = T - X        k -> 0: T' = T exp(-X)
//
// T is the transmittance still left. The law is exact under splitting a thing in parts, which is why it lives at the
// pixel and not in a cell's alpha. Three classes of k are enough, and need no power function.
#pragma once

#include <cmath>
#include <cstdint>

namespace farfield {

enum class AreaLaw : std::uint8_t { independent = 0, mixed = 1, coherent = 2 };  ///< k = 0, 1/2, 1

/// Below this a sample counts as closed: half a step of eight bits.
inline constexpr float closed_transmittance = 0.5f / 255.0f;

/// Transmittance after depositing `area`, in units of the sample's own area. Both arguments 0 or more.
inline float transmitted(float transmittance, float area, AreaLaw law) {
    switch (law) {
        case AreaLaw::coherent:
            return transmittance > area ? transmittance - area : 0.0f;
        case AreaLaw::mixed: {
            const float root = std::sqrt(transmittance) - 0.5f * area;
            return root > 0 ? root * root : 0.0f;
        }
        case AreaLaw::independent:
            // exp(-area) to 0.002 for areas below 1/2, never below it: what falls into one sample is small, and a
            // quotient is the same on every machine where a library's exponential is not.
            return transmittance / (1 + area * (1 + area * (0.5f + area * (1.0f / 6))));
    }
    return transmittance;
}

/// The law that suits something of this opacity where nothing else is known: what is opaque is a surface, what is
/// thin is strewn. (Chamberlain's cubes carry an opacity only.)
constexpr AreaLaw law_of_opacity(float alpha) {
    return alpha >= 0.75f ? AreaLaw::coherent : alpha >= 0.375f ? AreaLaw::mixed : AreaLaw::independent;
}

/// The area that leaves 1 - alpha of a fresh sample: the inverse of `transmitted(1, x, law)`, for `independent` to 0.01
/// up to an alpha of 1/2.
inline float area_of_opacity(float alpha, AreaLaw law) {
    switch (law) {
        case AreaLaw::coherent:
            return alpha;
        case AreaLaw::mixed:
            return 2 * (1 - std::sqrt(1 - alpha));
        case AreaLaw::independent:
            return alpha *
                   (1 + alpha * (0.5f + alpha * (1.0f / 3 + alpha * (0.25f + alpha * 0.2f))));  // -log(1 - alpha)
    }
    return alpha;
}

}  // namespace farfield
