// Stand-ins as they lie on the GPU: 24 bytes a face or splat.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <glm/vec3.hpp>

#include "farfield/drawables.hpp"
#include "farfield/geometry/area_law.hpp"
#include "farfield/geometry/box.hpp"

namespace farfield::opengl {

/// A face is its lower corner and two extents, along the axes after its own; a splat is its center and its two sides.
/// Bits of the extents that no one sees hold the rest:
///
///     sign bits of u, v          axis of the face (0 to 2), or law of the splat
///     lowest bit of u            1: a face
///     color                      premultiplied; of a splat r, g, b, and the upper eight of 24 bits of its opacity
///     bits 1-8 of u, 0-7 of v    the lower eight bits of them, and the middle ones
struct FarRecord {
    glm::vec3 place;
    std::uint32_t u, v, color;
};
static_assert(sizeof(FarRecord) == 24);

namespace detail {
inline std::uint32_t packed(Rgba8 c) {
    return c.r | std::uint32_t(c.g) << 8 | std::uint32_t(c.b) << 16 | std::uint32_t(c.a) << 24;
}
inline std::uint32_t length_bits(float length) {
    return std::bit_cast<std::uint32_t>(length) & 0x7fffffffu;
}
}  // namespace detail

/// A face whose opacity is above 0.
inline FarRecord record_of(const Face& face) {
    const unsigned axis = face.side / 2u;
    const int first = int(axis + 1) % 3, second = int(axis + 2) % 3;
    return {face.lower, (detail::length_bits(face.upper[first] - face.lower[first]) | 1u) | (axis & 1u) << 31,
            detail::length_bits(face.upper[second] - face.lower[second]) | (axis >> 1) << 31,
            detail::packed(face.rgba)};
}

inline FarRecord record_of(const Splat& splat) {
    const unsigned law = splat.rgb.a & 3u;
    const auto opacity = std::uint32_t(double(std::clamp(splat.opacity, 0.0f, 1.0f)) * 0xffffff + 0.5);
    return {splat.center, (detail::length_bits(splat.size.x) & ~0x1ffu) | (opacity & 255u) << 1 | (law & 1u) << 31,
            (detail::length_bits(splat.size.y) & ~0xffu) | (opacity >> 8 & 255u) | (law >> 1) << 31,
            (detail::packed(splat.rgb) & 0xffffffu) | (opacity >> 16) << 24};
}

inline bool is_face(const FarRecord& record) {
    return (record.u & 1u) != 0;
}

/// A box that holds it, seen from anywhere.
inline Box box_of(const FarRecord& r) {
    const float u = std::bit_cast<float>(r.u & 0x7fffffffu), v = std::bit_cast<float>(r.v & 0x7fffffffu);
    if (!is_face(r)) return {r.place - 0.5f * (u + v), r.place + 0.5f * (u + v)};
    Box box{r.place, r.place};
    const int axis = int(r.u >> 31 | r.v >> 31 << 1);
    box.upper[(axis + 1) % 3] += u;
    box.upper[(axis + 2) % 3] += v;
    return box;
}

inline AreaLaw law_of(const FarRecord& record) {
    if (is_face(record)) return law_of_opacity(float(record.color >> 24) * (1.0f / 255));
    return AreaLaw((record.u >> 31) | (record.v >> 31) << 1);
}

}  // namespace farfield::opengl
