// How much of a pixel is left after something of a given area was drawn into it.
//
// Where two things of area X each fall into one pixel, the pixel may end up covered by 2X (they are parts of one
// surface, side by side) or by 1 - (1 - X)^2 (leaves, strewn independently). One number c tells the two apart:
//
//     (T' + c) = (T + c) exp(-X / (1 + c)), cut off at 0
//
//     c = 0: T' = T exp(-X)        c -> infinity: T' = T - X
//
// T is the transmittance still left. The law is exact under splitting a thing in parts and does not ask in which order
// they come, which is why it lives at the pixel and not in a cell's alpha; and it takes from T a part that is linear in
// T, so that a deposit is two numbers whatever its law. ((T^k - k X)^(1/k), with k from 0 to 1, has the same ends and
// the same virtues but needs a power in between.) Three classes are enough: 0, 1 and infinity.
//
// Things of different laws do depend on their order, by less than the product of their areas.
#pragma once

#include "farfield/settings.hpp"

#include <bit>
#include <cstdint>

namespace farfield {

enum class AreaLaw : std::uint8_t { independent = 0, mixed = 1, coherent = 2 };  ///< c = 0, 1, infinity

/// Below this a sample counts as closed: half a step of eight bits.
inline constexpr float closed_transmittance = 0.5f / 255.0f;

/// The part that is taken from a transmittance T: T' = max(0, T - relative T - absolute). Where only a part of a sample
/// is covered, that part of both is taken. Neither is negative; relative is 1 at most, absolute may be more.
struct Loss {
    float relative = 0;
    float absolute = 0;
};

namespace detail {
/// 1 - exp(-x) to 1e-5, and to 1e-5 of itself, for x of 0 or more; 1 at most. By arithmetic alone, which is the same on
/// every machine where a library's exponential is not: Pade's quotient at x / 8, squared three times.
constexpr float absorbed(float x) {
    const float y = x < 24 ? 0.125f * x : 3.0f;
    float part = 12 * y / (12 + y * (6 + y));
    for (int i = 0; i < 3; ++i) part *= 2 - part;
    return part;
}

/// The area that absorbed() takes `part` by, -ln(1 - part), to 1e-6 of itself and 1e-7, for a part of 0 to 1; 88 at
/// most, by which nothing is left. By arithmetic alone, too: what is left is m 2^e, and ln m is a series in
/// (m - 1) / (m + 1), which is a sixth at most.
constexpr float absorbing_area(float part) {
    const float left = 1 - part;
    if (!(left > 0x1p-126f)) return 88;
    constexpr std::uint32_t root_of_half = 0x3f3504f3;
    const std::uint32_t above = std::bit_cast<std::uint32_t>(left) - root_of_half;
    const int e = int(above) >> 23;
    const float m = std::bit_cast<float>((above & 0x7fffffu) + root_of_half);
    const float z = (m - 1) / (m + 1), zz = z * z;
    return -(float(e) * 0.69314718f + 2 * z * (1 + zz * (1.0f / 3 + zz * (1.0f / 5 + zz / 7))));
}
}  // namespace detail

/// The loss by depositing `area`, 0 or more, in units of the sample's own area.
constexpr Loss loss_of_area(float area, AreaLaw law) {
    switch (law) {
        case AreaLaw::coherent:
            return {0, area};
        case AreaLaw::mixed: {
            const float part = detail::absorbed(0.5f * area);
            return {part, part};
        }
        case AreaLaw::independent:
            return {detail::absorbed(area), 0};
    }
    return {};
}

/// The loss that leaves 1 - alpha of a fresh sample. Alpha is the coverage of something opaque, or an opacity, 0 to 1.
constexpr Loss loss_of_opacity(float alpha, AreaLaw law) {
    switch (law) {
        case AreaLaw::coherent:
            return {0, alpha};
        case AreaLaw::mixed:
            return {0.5f * alpha, 0.5f * alpha};
        case AreaLaw::independent:
            return {alpha, 0};
    }
    return {};
}

/// What a part of the areas covers, 0 to 1, if all of them cover `opacity` of a fresh sample: areas of a surface add
/// up, and of what is strewn a part covers more than its share, as less of it hides itself. Parts that add up to 1
/// cover as much as all.
constexpr float opacity_of_part(float opacity, float part, AreaLaw law) {
    switch (law) {
        case AreaLaw::coherent:
            return opacity * part;
        case AreaLaw::mixed:
            return 2 * detail::absorbed(part * detail::absorbing_area(0.5f * opacity));
        case AreaLaw::independent:
            return detail::absorbed(part * detail::absorbing_area(opacity));
    }
    return 0;
}

/// Transmittance after a loss. Never negative.
constexpr float transmitted(float transmittance, Loss loss) {
    const float left = transmittance - (transmittance * loss.relative + loss.absolute);
    return left > 0 ? left : 0.0f;
}

/// Transmittance after depositing `area`, in units of the sample's own area. Both arguments 0 or more.
constexpr float transmitted(float transmittance, float area, AreaLaw law) {
    return transmitted(transmittance, loss_of_area(area, law));
}

/// The law that suits something of this opacity where nothing else is known: opaque things are surfaces, thin ones are
/// strewn. (Chamberlain's cubes carry an opacity only.)
constexpr AreaLaw law_of_opacity(float alpha) {
    return alpha >= 0.75f ? AreaLaw::coherent : alpha >= 0.375f ? AreaLaw::mixed : AreaLaw::independent;
}

}  // namespace farfield
