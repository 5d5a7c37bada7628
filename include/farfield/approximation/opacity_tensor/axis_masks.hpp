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

namespace farfield {

/// side x side samples along each axis, at the corners of a grid: sample i lies at lower + i / side of the box's size.
/// Rows run along the second axis after the viewed one, in cyclic order. As many samples, twice as far apart, look
/// along the diagonals (1, 1, 1) and (1, 1, -1) of the box, so that a fit holds between the axes, too. One bit a
/// sample.
class AxisMasks {
  public:
    static constexpr int side = 32;
    static constexpr int views = 5;  ///< x, y, z and the two diagonals

    /// Adds the samples of `box` that a triangle covers; its part outside of the box is not seen. Shared edges cover a
    /// sample once. Vertices are snapped to 1/256 of a sample's distance.
    void add(const Box& box, const glm::vec3 (&corners)[3]) {
        const glm::vec3 size = box.size();
        Coordinates at[3];
        for (int axis = 0; axis < 3; ++axis) {
            const float steps = samples_per_unit(float(side) * 256, size[axis]);
            for (int i = 0; i < 3; ++i) {
                // Adding 1.5 * 2^23 rounds to an integer; two boxes away is far enough not to overflow below.
                const float s = glm::clamp((corners[i][axis] - box.lower[axis]) * steps, -0x1p13f, 0x1p14f);
                at[axis].at[i] = std::bit_cast<std::int32_t>(s + 12582912.0f) - 0x4b400000;
            }
            at[axis].find_samples();
        }
        for (int axis = 0; axis < 3; ++axis) scan(rows_[std::size_t(axis)], at[(axis + 1) % 3], at[(axis + 2) % 3]);
        // Sheared along a diagonal, the box is twice as wide; coordinates are where it meets the middle of z.
        for (int diagonal = 0; diagonal < 2; ++diagonal) {
            Coordinates u, v;
            for (int i = 0; i < 3; ++i) {
                const std::int32_t z = diagonal == 0 ? side * 256 - at[2].at[i] : at[2].at[i];
                u.at[i] = (at[0].at[i] + z) >> 1;
                v.at[i] = (at[1].at[i] + z) >> 1;
            }
            u.find_samples();
            v.find_samples();
            scan(rows_[std::size_t(3 + diagonal)], u, v);
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
        int sum = 0;
        for (const std::uint32_t row : rows_[std::size_t(view)]) sum += std::popcount(row);
        return sum;
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

  private:
    using Rows = std::array<std::uint32_t, side>;

    static std::uint32_t even_bits(std::uint32_t x) {
        x &= 0x55555555u;
        x = (x | x >> 1) & 0x33333333u;
        x = (x | x >> 2) & 0x0f0f0f0fu;
        x = (x | x >> 4) & 0x00ff00ffu;
        return (x | x >> 8) & 0x0000ffffu;
    }

    /// A triangle's coordinates on one axis, in 1/256 of a sample's distance, and the samples between them.
    struct Coordinates {
        std::int32_t at[3];
        int first, last;
        void find_samples() {
            first = std::max((std::min(std::min(at[0], at[1]), at[2]) + 255) >> 8, 0);
            last = std::min(std::max(std::max(at[0], at[1]), at[2]) >> 8, side - 1);
        }
    };

    /// Coordinates reach 2^14, so that twice an area stays below 2^30.
    static void scan(Rows& rows, const Coordinates& along_u, const Coordinates& along_v) {
        const int first_u = along_u.first, last_u = along_u.last, first_v = along_v.first, last_v = along_v.last;
        if (first_u > last_u || first_v > last_v) return;
        const std::int32_t(&u)[3] = along_u.at, (&v)[3] = along_v.at;
        const std::int32_t doubled_area = (u[1] - u[0]) * (v[2] - v[0]) - (u[2] - u[0]) * (v[1] - v[0]);
        if (doubled_area == 0) return;
        const int k[3] = {0, doubled_area > 0 ? 1 : 2, doubled_area > 0 ? 2 : 1};
        std::int32_t edge[3], by_u[3], by_v[3];
        for (int i = 0; i < 3; ++i) {
            const int from = k[(i + 1) % 3], to = k[(i + 2) % 3];
            const std::int32_t du = u[to] - u[from], dv = v[to] - v[from];
            // A sample on an edge belongs to one of the two triangles that share it.
            const std::int32_t bias = (dv < 0 || (dv == 0 && du > 0)) ? 0 : -1;
            edge[i] = du * (first_v * 256 - v[from]) - dv * (first_u * 256 - u[from]) + bias;
            by_u[i] = -dv * 256;
            by_v[i] = du * 256;
        }
        // Four samples at a step.
        constexpr Lanes lane{0, 1, 2, 3};
        const Lanes lanes0 = lane * by_u[0], lanes1 = lane * by_u[1], lanes2 = lane * by_u[2];
        const std::uint32_t inside = (2u << last_u) - (1u << first_u);
        for (int row = first_v; row <= last_v; ++row) {
            Lanes e0 = edge[0] + lanes0, e1 = edge[1] + lanes1, e2 = edge[2] + lanes2;
            std::uint32_t bits = 0;
            for (int i = first_u; i <= last_u; i += 4) {
                bits |= not_negative(e0 | e1 | e2) << i;
                e0 += by_u[0] * 4;
                e1 += by_u[1] * 4;
                e2 += by_u[2] * 4;
            }
            rows[std::size_t(row)] |= bits & inside;
            for (int i = 0; i < 3; ++i) edge[i] += by_v[i];
        }
    }

    /// 0 where a box has no extent, or so little that samples are all in one place.
    static float samples_per_unit(float samples, float size) {
        const float quotient = samples / size;
        return std::isfinite(quotient) ? quotient : 0.0f;
    }

    typedef std::int32_t Lanes __attribute__((vector_size(16)));

    /// One bit a lane.
    static std::uint32_t not_negative(Lanes v) {
#if defined(__SSE2__)
        typedef float Floats __attribute__((vector_size(16)));
        return std::uint32_t(__builtin_ia32_movmskps(reinterpret_cast<Floats>(v))) ^ 15u;
#else
        return std::uint32_t(v[0] >= 0) | std::uint32_t(v[1] >= 0) << 1 | std::uint32_t(v[2] >= 0) << 2 |
               std::uint32_t(v[3] >= 0) << 3;
#endif
    }

    std::array<Rows, views> rows_{};
};

}  // namespace farfield
