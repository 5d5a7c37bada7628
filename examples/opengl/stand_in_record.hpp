// Stand-ins as they lie on the GPU, in texels of eight bytes: faces and splats (far_record.hpp), and what the shader
// makes splats of, which is as it is stored and the same from everywhere.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <utility>

#include "farfield/approximation/color_cube/cube_lanes.hpp"
#include "farfield/approximation/opacity_tensor/appearance_lanes.hpp"
#include "farfield/approximation/opacity_tensor/stored_tensor.hpp"
#include "farfield/drawables.hpp"
#include "farfield/geometry/area_law.hpp"
#include "farfield/geometry/box.hpp"
#include "opengl/far_record.hpp"

namespace farfield::opengl {

enum class StandInKind : std::uint8_t { splat, face, tensor, cube };

/// What is drawn by one program.
enum class StandInGroup : std::uint8_t { as_they_are, tensors, cubes };
inline constexpr std::size_t stand_in_groups = 3;
constexpr StandInGroup group_of(StandInKind kind) {
    return kind == StandInKind::tensor ? StandInGroup::tensors
           : kind == StandInKind::cube ? StandInGroup::cubes
                                       : StandInGroup::as_they_are;
}

constexpr std::size_t texels_of(StandInKind kind) {
    return kind == StandInKind::tensor ? 4 : kind == StandInKind::cube ? 6 : 3;
}
template <StandInKind kind>
using StandInTexels = std::array<std::uint64_t, texels_of(kind)>;

/// Which of the two blendings of the area law draw it: independent ones the first, coherent ones the second, and what
/// is mixed, or may be either from somewhere, both.
using LawClass = std::uint8_t;

template <StandInKind kind>
StandInTexels<kind> texels_of(const FarRecord& record) {
    return std::bit_cast<StandInTexels<kind>>(record);
}

namespace detail {

inline std::uint64_t texel(std::uint32_t low, std::uint32_t high) {
    return low | std::uint64_t(high) << 32;
}
inline float number(std::uint32_t bits) {
    return std::bit_cast<float>(bits);
}

/// In place of the error, which nobody asks for when it is drawn.
inline constexpr unsigned gains_bit = 56;

}  // namespace detail

/// The stored 16 bytes, the lower corner of the cell's bounds, and its unit of length. Whether it gains as a sheet is
/// told once (OpacityTensor::sheet_gain).
inline StandInTexels<StandInKind::tensor> texels_of_tensor(const std::uint32_t* words) {
    using namespace farfield::opengl::detail;
    const auto word = [&](std::size_t i) { return words[i * PlacedStandIns::stride]; };
    StoredTensor tensor{texel(word(0), word(1)), texel(word(2), word(3))};
    bool gains = false;
    if (tensor.area_law() == AreaLaw::coherent) {
        const glm::vec3 e = tensor.extent();
        const float second = std::max(std::min(e.x, e.y), std::min(std::max(e.x, e.y), e.z));
        gains = second * number(word(PlacedTensor::unit)) >= number(word(PlacedTensor::reach));
    }
    tensor.second = (tensor.second & ~(std::uint64_t(31) << gains_bit)) | std::uint64_t(gains) << gains_bit;
    return {tensor.first, tensor.second, texel(word(PlacedTensor::x), word(PlacedTensor::y)),
            texel(word(PlacedTensor::z), word(PlacedTensor::unit))};
}

/// The cell's center and half sides, and six colors.
inline StandInTexels<StandInKind::cube> texels_of_cube(const std::uint32_t* words) {
    StandInTexels<StandInKind::cube> texels;
    for (std::size_t i = 0; i < texels.size(); ++i) {
        const std::uint32_t* const two = words + 2 * i * PlacedStandIns::stride;
        texels[i] = detail::texel(two[0], two[PlacedStandIns::stride]);
    }
    return texels;
}

inline FarRecord far_record_of(const std::uint64_t* texels) {
    return std::bit_cast<FarRecord>(std::array<std::uint64_t, 3>{texels[0], texels[1], texels[2]});
}

/// A cube's opacity lies between those of its faces, from wherever it is seen.
inline LawClass law_class(StandInKind kind, const std::uint64_t* texels) {
    if (kind == StandInKind::tensor) return LawClass(texels[1] >> 54 & 3);
    if (kind != StandInKind::cube) return LawClass(law_of(far_record_of(texels)));
    std::uint32_t least = 255, most = 0;
    for (std::size_t i = 3; i < 6; ++i) {
        for (const std::uint64_t alpha : {texels[i] >> 24 & 255, texels[i] >> 56}) {
            least = std::min(least, std::uint32_t(alpha));
            most = std::max(most, std::uint32_t(alpha));
        }
    }
    return LawClass(law_of_opacity(float(least) * (1.0f / 255)) == AreaLaw::coherent     ? 2
                    : law_of_opacity(float(most) * (1.0f / 255)) == AreaLaw::independent ? 0
                                                                                         : 1);
}

/// A box that holds it, seen from anywhere, if nothing is stretched by more than `stretch` where it meets the picture.
inline Box box_of(StandInKind kind, const std::uint64_t* texels, float stretch) {
    const auto low = [&](std::size_t i) { return detail::number(std::uint32_t(texels[i])); };
    const auto high = [&](std::size_t i) { return detail::number(std::uint32_t(texels[i] >> 32)); };
    if (kind == StandInKind::tensor) {
        // It lies about a point of the cell, as large as the cell's outline at most, and has three times its area.
        const glm::vec3 corner(low(2), high(2), low(3));
        const float unit = high(3);
        return {corner - 2 * stretch * unit, corner + (1 + 2 * stretch) * unit};
    }
    if (kind == StandInKind::cube) {
        const glm::vec3 center(low(0), high(0), low(1)), half(high(1), low(2), high(2));
        const float reach = 2 * stretch * std::max(half.x, std::max(half.y, half.z));
        return {center - reach, center + reach};
    }
    return box_of(far_record_of(texels));
}

}  // namespace farfield::opengl
