// What part of a box is covered, seen along its three axes: point samples whose places nest, so that a parent's samples
// are some of its children's and what a parent covers is the union of what they cover.
//
// Opacities cannot be merged like that. Whether two children's contents lie side by side or behind one another is lost
// with everything but their position: "wrong transparency" of Loubet and Neyret 2018 and of Zhou et al. 2024.
#pragma once

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
/// One bit a sample; rows run along the axis after the viewed one, in cyclic order.
class AxisMasks {
  public:
    static constexpr int side = 32;

    /// Samples of `box` that a triangle covers; what lies outside of the box is not seen. Shared edges cover a sample
    /// once. Vertices are snapped to 1/256 of a sample's distance.
    void add(const Box& box, const glm::vec3 (&corners)[3]) {
        const glm::vec3 size = box.size();
        std::int32_t at[3][3];
        int first[3], last[3];
        for (int axis = 0; axis < 3; ++axis) {
            const float steps = size[axis] > 0 ? float(side) * 256 / size[axis] : 0.0f;
            for (int i = 0; i < 3; ++i) {
                // Adding 1.5 * 2^23 rounds to an integer; 64 boxes away is far enough not to overflow below.
                const float s = glm::clamp((corners[i][axis] - box.lower[axis]) * steps, -0x1p13f, 0x1p14f);
                at[axis][i] = std::bit_cast<std::int32_t>(s + 12582912.0f) - 0x4b400000;
            }
            first[axis] = std::max((std::min(std::min(at[axis][0], at[axis][1]), at[axis][2]) + 255) >> 8, 0);
            last[axis] = std::min(std::max(std::max(at[axis][0], at[axis][1]), at[axis][2]) >> 8, side - 1);
        }
        for (int axis = 0; axis < 3; ++axis) {
            const int u = (axis + 1) % 3, v = (axis + 2) % 3;
            if (first[u] <= last[u] && first[v] <= last[v]) {
                scan(rows_[std::size_t(axis)], at[u], at[v], first[u], last[u], first[v], last[v]);
            }
        }
    }

    /// Of the child every other sample is one of the parent's, if its box is half as large and lies on the parent's
    /// grid.
    void add_child(const Box& box, const AxisMasks& child, const Box& child_box) {
        const glm::vec3 size = box.size();
        int shift[3];
        for (int axis = 0; axis < 3; ++axis) {
            const float steps = size[axis] > 0 ? float(side) / size[axis] : 0.0f;
            shift[axis] = int(std::floor((child_box.lower[axis] - box.lower[axis]) * steps + 0.5f));
        }
        for (int axis = 0; axis < 3; ++axis) {
            const int u = shift[(axis + 1) % 3], v = shift[(axis + 2) % 3];
            for (int row = 0; row < side / 2; ++row) {
                const int to = row + v;
                if (to < 0 || to >= side) continue;
                const std::uint32_t bits = even_bits(child.rows_[std::size_t(axis)][std::size_t(2 * row)]);
                rows_[std::size_t(axis)][std::size_t(to)] |= u >= 0 ? bits << u : bits >> -u;
            }
        }
    }

    /// Samples covered as seen along an axis.
    int count(int axis) const {
        int sum = 0;
        for (const std::uint32_t row : rows_[std::size_t(axis)]) sum += std::popcount(row);
        return sum;
    }

  private:
    using Rows = std::array<std::uint32_t, side>;

    static std::uint32_t even_bits(std::uint32_t x) {
        x &= 0x55555555u;
        x = (x | x >> 1) & 0x33333333u;
        x = (x | x >> 2) & 0x0f0f0f0fu;
        x = (x | x >> 4) & 0x00ff00ffu;
        return (x | x >> 8) & 0x0000ffffu;
    }

    /// Coordinates reach 2^14, so that twice an area stays below 2^30.
    static void scan(Rows& rows, const std::int32_t (&u)[3], const std::int32_t (&v)[3], int first_u, int last_u,
                     int first_v, int last_v) {
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
        for (int row = first_v; row <= last_v; ++row) {
            std::int32_t e0 = edge[0], e1 = edge[1], e2 = edge[2];
            std::uint32_t bits = 0;
            for (int i = first_u; i <= last_u; ++i, e0 += by_u[0], e1 += by_u[1], e2 += by_u[2]) {
                bits |= std::uint32_t((e0 | e1 | e2) >= 0) << i;
            }
            rows[std::size_t(row)] |= bits;
            for (int i = 0; i < 3; ++i) edge[i] += by_v[i];
        }
    }

    std::array<Rows, 3> rows_{};
};

}  // namespace farfield
