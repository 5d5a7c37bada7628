// The covered part of a box, seen along its three axes: point samples whose places nest, so that a parent's samples are
// some of its children's and a parent covers the union of what they cover.
//
// Opacities cannot be merged like that. Whether two children's contents lie side by side or behind one another is lost
// with everything but their position: "wrong transparency" of Loubet and Neyret 2018 and of Zhou et al. 2024.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include "farfield/geometry/box.hpp"
#include "farfield/simd.hpp"

namespace farfield {
namespace detail {

inline constexpr int mask_side = 32;
using MaskRows = std::array<std::uint32_t, mask_side>;  ///< one bit a sample

/// A triangle's coordinates on one axis, in 1/256 of a sample's distance, and the samples between them.
struct MaskCoordinates {
    std::int32_t at[3];
    int first, last;
    FARFIELD_INLINE void find_samples() {
        first = std::max((std::min(std::min(at[0], at[1]), at[2]) + 255) >> 8, 0);
        last = std::min(std::max(std::max(at[0], at[1]), at[2]) >> 8, mask_side - 1);
    }
};

#define FARFIELD_LANES 4
namespace four_mask_samples {
#include "farfield/approximation/opacity_tensor/axis_masks_lanes.inl"
}
#undef FARFIELD_LANES

#if defined(__x86_64__)
FARFIELD_BEGIN_EIGHT_LANES
#define FARFIELD_LANES 8
namespace eight_mask_samples {
#include "farfield/approximation/opacity_tensor/axis_masks_lanes.inl"
}
#undef FARFIELD_LANES
FARFIELD_END_LANES
#else
namespace eight_mask_samples = four_mask_samples;  // lanes_for() has no eight there
#endif

}  // namespace detail

/// side x side samples along each axis, at the corners of a grid: sample i lies at lower + i / side of the box's size.
/// Rows run along the second axis after the viewed one, in cyclic order. As many samples, twice as far apart, look
/// along the diagonals (1, 1, 1) and (1, 1, -1) of the box, so that a fit holds between the axes, too. One bit a
/// sample.
class AxisMasks {
  public:
    static constexpr int side = detail::mask_side;
    static constexpr int views = 5;  ///< x, y, z and the two diagonals

    /// Adds the samples of `box` that a triangle covers; its part outside of the box is not seen. Shared edges cover a
    /// sample once. Vertices are snapped to 1/256 of a sample's distance. Vectors of any width give the same.
    void add(const Box& box, const glm::vec3 (&corners)[3], Simd simd = Simd::automatic) {
        const glm::vec3 size = box.size();
        detail::MaskCoordinates at[3];
        for (int axis = 0; axis < 3; ++axis) {
            const float steps = samples_per_unit(float(side) * 256, size[axis]);
            for (int i = 0; i < 3; ++i) {
                // Adding 1.5 * 2^23 rounds to an integer; two boxes away is far enough not to overflow below.
                const float s = glm::clamp((corners[i][axis] - box.lower[axis]) * steps, -0x1p13f, 0x1p14f);
                at[axis].at[i] = std::bit_cast<std::int32_t>(s + 12582912.0f) - 0x4b400000;
            }
            at[axis].find_samples();
        }
        if (detail::lanes_for(simd) >= 8) {
            detail::eight_mask_samples::add_triangle(rows_.data(), at);
        } else {
            detail::four_mask_samples::add_triangle(rows_.data(), at);
        }
    }

    /// Adds a child's samples: every other one is one of the parent's, if the child's box is half as large and lies on
    /// the parent's grid.
    void add_child(const Box& box, const AxisMasks& child, const Box& child_box) {
        const glm::vec3 size = box.size();
        int shift[3];
        for (int axis = 0; axis < 3; ++axis) {
            const float steps = samples_per_unit(float(side), size[axis]);
            shift[axis] = int(std::floor((child_box.lower[axis] - box.lower[axis]) * steps + 0.5f));
        }
        for (int view = 0; view < views; ++view) {
            int u = shift[(view + 1) % 3], v = shift[(view + 2) % 3];
            if (view >= 3) {
                // A child's z runs from its own box: half of a side lies between the two middles.
                const int z = view == 3 ? side / 2 - shift[2] : shift[2];
                u = (shift[0] + z) / 2;
                v = (shift[1] + z) / 2;
            }
            for (int row = 0; row < side / 2; ++row) {
                const int to = row + v;
                if (to < 0 || to >= side) continue;
                const std::uint32_t bits = even_bits(child.rows_[std::size_t(view)][std::size_t(2 * row)]);
                rows_[std::size_t(view)][std::size_t(to)] |= u >= 0 ? bits << u : bits >> -u;
            }
        }
    }

    /// The number of samples covered in a view.
    int count(int view) const {
        // By halves, in each of four bytes: processors that may have no instruction for it would call a function a row.
        std::uint32_t bytes = 0;
        for (std::uint32_t row : rows_[std::size_t(view)]) {
            row -= row >> 1 & 0x55555555u;
            row = (row & 0x33333333u) + (row >> 2 & 0x33333333u);
            row = (row + (row >> 4)) & 0x0f0f0f0fu;
            bytes += (row & 0x00ff00ffu) + (row >> 8 & 0x00ff00ffu);
        }
        return int((bytes & 0xffffu) + (bytes >> 16));
    }

    /// How many samples lie within the contents' box along each axis. One that lies on both borders counts once.
    static glm::ivec3 samples_within(const Box& box, const Box& contents) {
        const glm::vec3 size = box.size();
        glm::ivec3 count(0);
        for (int axis = 0; axis < 3; ++axis) {
            if (!(size[axis] > 0)) continue;
            const float steps = float(side) / size[axis];
            const float first = std::ceil((contents.lower[axis] - box.lower[axis]) * steps);
            const float last = std::ceil((contents.upper[axis] - box.lower[axis]) * steps);
            count[axis] = int(std::min(last, float(side)) - std::max(first, 0.0f));
        }
        return glm::max(count, 0);
    }

    /// The unit vector of a view; the box is taken for a cube.
    static glm::vec3 direction(int view) {
        const float r = 0.57735027f;
        const std::array<glm::vec3, views> all{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {r, r, r}, {r, r, -r}}};
        return all[std::size_t(view)];
    }
    /// The area of a sample seen squarely, in squares of the side of the box, which is taken for a cube.
    static float sample_area(int view) { return view < 3 ? 1.0f / (side * side) : 4 * 0.57735027f / (side * side); }

    friend bool operator==(const AxisMasks&, const AxisMasks&) = default;

  private:
    static std::uint32_t even_bits(std::uint32_t x) {
        x &= 0x55555555u;
        x = (x | x >> 1) & 0x33333333u;
        x = (x | x >> 2) & 0x0f0f0f0fu;
        x = (x | x >> 4) & 0x00ff00ffu;
        return (x | x >> 8) & 0x0000ffffu;
    }

    /// 0 where a box has no extent, or so little that samples are all in one place.
    static float samples_per_unit(float samples, float size) {
        const float quotient = samples / size;
        return std::isfinite(quotient) ? quotient : 0.0f;
    }

    std::array<detail::MaskRows, views> rows_{};
};

}  // namespace farfield
