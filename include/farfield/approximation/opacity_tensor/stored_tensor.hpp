// The 16 bytes that an opacity tensor keeps of a cell, and the numbers that they stand for.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "farfield/geometry/area_law.hpp"
#include "farfield/geometry/cell.hpp"
#include "farfield/geometry/rgba8.hpp"

namespace farfield {

/// The unit of length of a TensorShape: the largest side of the cell's bounds.
inline float tensor_unit(const Cell& cell) {
    return 2 * glm::max(cell.bounds_half.x, glm::max(cell.bounds_half.y, cell.bounds_half.z));
}

/// A cell's contents as numbers; lengths in sides of the cell's bounds, areas in squares of it.
struct TensorShape {
    /// Lower triangle L, by columns (xx, yx, zx, yy, zy, zz), of the tensor: towards a unit vector w the contents'
    /// projected area is |L^T w|.
    std::array<float, 6> root{};
    /// Area of fronts less that of backs, seen from w: dot(facing, w). Closed surfaces only.
    glm::vec3 facing{0};
    /// Luminance times area, in units of the mean luminance, is area + dot(tone, w).
    glm::vec3 tone{0};
    glm::vec3 center{0};  ///< centroid, from the lower corner of the bounds; 0 to 1
    glm::vec3 extent{0};  ///< of the box that stands for the contents, above 0
    glm::vec3 rgb{0};     ///< 0 to 255
    float error = 0;      ///< 0 to 1
    AreaLaw law = AreaLaw::independent;
};

/// The root of the tensor is quantized, not the tensor itself: an error of 1/62 is one of the area seen, not of its
/// square, so that a sheet stays thin seen edge-on.
struct StoredTensor {
    // Fields are listed from the lowest bit. All bits are used: nothing more is worth a seventeenth byte.
    std::uint64_t first = 0;  ///< root 6 x 6, center 3 x 5, extent 3 x 4, scale's lowest
    /// Facing 3 x 5, tone 3 x 5, color 5 + 6 + 5, rest of scale 8, law 2, error's root 5, extent's highest 3 x 1.
    std::uint64_t second = 0;

    static StoredTensor packed(const TensorShape& shape) {
        float largest = 0;
        for (const float v : shape.root) largest = std::max(largest, std::abs(v));
        const float exponent = std::ceil((std::log2(std::max(largest, 1e-30f)) + octaves_below) * steps_an_octave);
        const float kept = std::min(std::max(0.0f, exponent), 511.0f);
        const float scale = scale_of(std::uint32_t(kept));
        StoredTensor tensor;
        Bits low{tensor.first}, high{tensor.second};
        for (const float v : shape.root) low.put(6, signed_bits(v / scale, 31));
        for (int axis = 0; axis < 3; ++axis) low.put(5, nearest(shape.center[axis] * 32, 31));
        for (int axis = 0; axis < 3; ++axis) low.put(4, extent_code(shape.extent[axis]) & 15);
        for (int axis = 0; axis < 3; ++axis) high.put(5, signed_bits(shape.facing[axis] / scale, 15));
        for (int axis = 0; axis < 3; ++axis) high.put(5, signed_bits(shape.tone[axis] / scale, 15));
        high.put(5, nearest(shape.rgb.x * (31.0f / 255), 31));
        high.put(6, nearest(shape.rgb.y * (63.0f / 255), 63));
        high.put(5, nearest(shape.rgb.z * (31.0f / 255), 31));
        low.put(1, std::uint32_t(kept) & 1);
        high.put(8, std::uint32_t(kept) >> 1);
        high.put(2, std::uint32_t(shape.law));
        high.put(5, std::uint32_t(std::ceil(std::sqrt(std::min(std::max(0.0f, shape.error), 1.0f)) * 31)));
        for (int axis = 0; axis < 3; ++axis) high.put(1, extent_code(shape.extent[axis]) >> 4);
        return tensor;
    }

    TensorShape unpacked() const {
        TensorShape s;
        // Each number has a fixed place, so that none waits for another.
        const auto bits = [](std::uint64_t word, unsigned at, unsigned count) {
            return std::int32_t(word >> at & ((1u << count) - 1));
        };
        const float scale = this->scale();
        const float root_step = scale * (1.0f / 31), step = scale * (1.0f / 15);
        for (unsigned i = 0; i < 6; ++i) s.root[i] = float(bits(first, 6 * i, 6) - 32) * root_step;
        for (int axis = 0; axis < 3; ++axis) {
            const auto i = unsigned(axis);
            s.center[axis] = float(bits(first, 36 + 5 * i, 5)) * (1.0f / 32);
            s.extent[axis] = extents[std::size_t(bits(second, 61 + i, 1) << 4 | bits(first, 51 + 4 * i, 4))];
            s.facing[axis] = float(bits(second, 5 * i, 5) - 16) * step;
            s.tone[axis] = float(bits(second, 15 + 5 * i, 5) - 16) * step;
        }
        s.rgb = glm::vec3(float(bits(second, 30, 5)) * (255.0f / 31), float(bits(second, 35, 6)) * (255.0f / 63),
                          float(bits(second, 41, 5)) * (255.0f / 31));
        s.law = area_law();
        s.error = error();
        return s;
    }

    /// Roots are in 31sts of it, facing and tone in 15ths.
    float scale() const { return scale_of(std::uint32_t(second >> 46 & 255) << 1 | std::uint32_t(first >> 63)); }
    AreaLaw area_law() const { return AreaLaw(second >> 54 & 3); }
    float error() const {
        const float root = float(second >> 56 & 31) * (1.0f / 31);
        return root * root;
    }
    glm::vec3 extent() const {
        const auto along = [&](unsigned axis) {
            return extents[std::size_t((second >> (61 + axis) & 1) << 4 | (first >> (51 + 4 * axis) & 15))];
        };
        return {along(0), along(1), along(2)};
    }
    /// The extent that is stored for one, which is from 1/64 to 1.
    static glm::vec3 rounded_extent(glm::vec3 extent) {
        return {extents[extent_code(extent.x)], extents[extent_code(extent.y)], extents[extent_code(extent.z)]};
    }
    /// False for a law that does not exist: all other bits mean something.
    bool is_sound() const { return (second >> 54 & 3) <= 2; }

    friend bool operator==(const StoredTensor&, const StoredTensor&) = default;

  private:
    /// Scales run from 2^-22 to 2^10 in steps of 4 % and are rounded up, so that nothing is cut off.
    static constexpr float octaves_below = 22, steps_an_octave = 16;

    /// In 64ths, of which each octave above the first has eight steps: thin layers are as exact as thick ones.
    static constexpr std::array<float, 32> extents = [] {
        std::array<float, 32> all{};
        for (unsigned code = 0; code < 32; ++code) {
            const unsigned octave = code >> 3, step = code & 7;
            all[code] = (1.0f / 64) * float(octave == 0 ? step + 1 : (step + 9) << (octave - 1));
        }
        return all;
    }();
    static std::uint32_t extent_code(float extent) {
        std::uint32_t code = 0;
        while (code < 31 && extent >= 0.5f * (extents[code] + extents[code + 1])) ++code;
        return code;
    }
    static float scale_of(std::uint32_t exponent) {
        // Two to the power of 0, 1/16, 2/16 and so on.
        static constexpr std::array<float, 16> fractions{
            1.0f,        1.04427378f, 1.09050773f, 1.13878863f, 1.18920712f, 1.24185781f, 1.29683955f, 1.35425555f,
            1.41421356f, 1.47682615f, 1.54221083f, 1.61049033f, 1.68179283f, 1.75625216f, 1.83400809f, 1.91520656f};
        return fractions[exponent & 15] * std::bit_cast<float>((127u - 22u + (exponent >> 4)) << 23);
    }
    // In this order of arguments NaN gives 0.
    static std::uint32_t nearest(float v, float most) {
        return std::uint32_t(std::min(std::max(0.0f, v + 0.5f), most + 0.5f));
    }
    /// A number from -1 to 1, offset so that it is not negative.
    static std::uint32_t signed_bits(float v, float most) {
        const float kept = std::min(std::max(-1.0f, v), 1.0f);
        return std::uint32_t(std::int32_t(std::round(kept * most)) + std::int32_t(most) + 1);
    }

    struct Bits {
        std::uint64_t& to;
        unsigned at = 0;
        void put(unsigned count, std::uint32_t value) {
            to |= std::uint64_t(value) << at;
            at += count;
        }
    };
};
static_assert(sizeof(StoredTensor) == 16);

}  // namespace farfield
