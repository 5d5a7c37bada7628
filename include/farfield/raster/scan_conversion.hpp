// Which samples does a triangle cover? Exact, in integers: triangles that share an edge cover each sample once.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "farfield/raster/sample_projection.hpp"

namespace farfield::detail {

/// A triangle snapped to 1/256 sample, |coordinates| < 2^22, with q at its corners.
struct SnappedTriangle {
    std::int32_t x[3];
    std::int32_t y[3];
    float q[3];

    /// Reverses the orientation: two corners change places.
    void flip() {
        std::swap(x[1], x[2]);
        std::swap(y[1], y[2]);
        std::swap(q[1], q[2]);
    }

    /// Twice the area in 1/65536 squared samples, positive if clockwise on the screen (rows run downwards).
    std::int64_t doubled_area() const {
        return std::int64_t(x[1] - x[0]) * (y[2] - y[0]) - std::int64_t(x[2] - x[0]) * (y[1] - y[0]);
    }
};

/// q over the screen: a plane, clamped to the range of the corners because a sliver's plane is steep.
struct DepthPlane {
    float at_corner = 0, by_x = 0, by_y = 0, lowest = 0, highest = 0;
    float base_x = 0, base_y = 0;  ///< from the first corner to sample (0, 0)

    DepthPlane() = default;
    DepthPlane(const SnappedTriangle& t, std::int64_t doubled_area) {
        const float scale = 256.0f / float(doubled_area);
        const float q1 = t.q[1] - t.q[0], q2 = t.q[2] - t.q[0];
        by_x = (q1 * float(t.y[2] - t.y[0]) - q2 * float(t.y[1] - t.y[0])) * scale;
        by_y = (q2 * float(t.x[1] - t.x[0]) - q1 * float(t.x[2] - t.x[0])) * scale;
        base_x = (128.0f - float(t.x[0])) * (1.0f / 256);
        base_y = (128.0f - float(t.y[0])) * (1.0f / 256);
        at_corner = t.q[0];
        lowest = std::min(t.q[0], std::min(t.q[1], t.q[2]));
        highest = std::max(t.q[0], std::max(t.q[1], t.q[2]));
    }
    /// A plane without a triangle: q at sample (0, 0) and its change from sample to sample.
    DepthPlane(float at_first, float by_sample_x, float by_sample_y, float lowest_q, float highest_q)
        : at_corner(at_first), by_x(by_sample_x), by_y(by_sample_y), lowest(lowest_q), highest(highest_q) {}

    /// Distances are taken to the first corner, which is near, so nothing cancels against the screen's origin.
    float row(int y) const { return at_corner + by_y * (float(y) + base_y); }
    /// at(row, x) is row + column(x), clamped.
    float column(int x) const { return by_x * (float(x) + base_x); }
    float inside(float q) const { return q < lowest ? lowest : q > highest ? highest : q; }
    float at(float row, int x) const { return inside(row + column(x)); }
};

/// E(i, j) = value + by_x i + by_y j is 0 or more inside, at samples relative to the box's first one. Samples on an
/// edge belong to the triangle that has it at its top or left.
template <class Int>
struct Edge {
    Int value, by_x, by_y;

    Edge(std::int32_t x0, std::int32_t y0, std::int32_t x1, std::int32_t y1, int first_x, int first_y) {
        const Int dx = Int(x1) - x0, dy = Int(y1) - y0;
        const Int bias = (dy < 0 || (dy == 0 && dx > 0)) ? 0 : -1;
        value = dx * (Int(first_y) * 256 + 128 - y0) - dy * (Int(first_x) * 256 + 128 - x0) + bias;
        by_x = -dy * 256;
        by_y = dx * 256;
    }
    /// Narrows [first, last] to the samples i of a row where the edge is not negative.
    void narrow(Int row_value, std::int64_t& first, std::int64_t& last) const {
        if (by_x == 0) {
            if (row_value < 0) last = -1;
        } else if (by_x > 0) {
            if (row_value < 0) first = std::max<std::int64_t>(first, (-std::int64_t(row_value) + by_x - 1) / by_x);
        } else if (row_value < 0) {
            last = -1;
        } else {
            last = std::min<std::int64_t>(last, std::int64_t(row_value) / -by_x);
        }
    }
};

template <class Int, class Row>
void scan_box(const SnappedTriangle& t, int x0, int y0, int x1, int y1, Row&& row) {
    const Edge<Int> e0(t.x[0], t.y[0], t.x[1], t.y[1], x0, y0), e1(t.x[1], t.y[1], t.x[2], t.y[2], x0, y0),
        e2(t.x[2], t.y[2], t.x[0], t.y[0], x0, y0);
    Int v0 = e0.value, v1 = e1.value, v2 = e2.value;
    if (x0 == x1 && y0 == y1) {  // the commonest box far away
        if ((v0 | v1 | v2) >= 0) row(y0, x0, x0 + 1);
        return;
    }
    const int width = x1 - x0 + 1;
    for (int y = y0; y <= y1; ++y, v0 += e0.by_y, v1 += e1.by_y, v2 += e2.by_y) {
        if (width <= 8) {
            // In short rows walking is faster than dividing.
            Int a = v0, b = v1, c = v2;
            int first = 0;
            while (first < width && (a | b | c) < 0) a += e0.by_x, b += e1.by_x, c += e2.by_x, ++first;
            int end = first;
            while (end < width && (a | b | c) >= 0) a += e0.by_x, b += e1.by_x, c += e2.by_x, ++end;
            if (first < end) row(y, x0 + first, x0 + end);
        } else {
            std::int64_t first = 0, last = width - 1;
            e0.narrow(v0, first, last);
            e1.narrow(v1, first, last);
            e2.narrow(v2, first, last);
            if (first <= last) row(y, x0 + int(first), x0 + int(last) + 1);
        }
    }
}

/// Calls row(y, begin, end) for each row of covered samples, inside the projection's image. The triangle must be
/// clockwise on the screen, doubled_area() > 0.
template <class Row>
void scan_convert(const SnappedTriangle& t, const SampleProjection& image, Row&& row) {
    const std::int32_t low_x = std::min(std::min(t.x[0], t.x[1]), t.x[2]),
                       high_x = std::max(std::max(t.x[0], t.x[1]), t.x[2]);
    const std::int32_t low_y = std::min(std::min(t.y[0], t.y[1]), t.y[2]),
                       high_y = std::max(std::max(t.y[0], t.y[1]), t.y[2]);
    const int x0 = std::max((low_x + 127) >> 8, image.first_x), x1 = std::min((high_x - 128) >> 8, image.end_x - 1);
    const int y0 = std::max((low_y + 127) >> 8, image.first_y), y1 = std::min((high_y - 128) >> 8, image.end_y - 1);
    if (x0 > x1 || y0 > y1) return;
    // Edges up to 2^14 long in both directions have values below 2^31 anywhere in their box.
    if (high_x - low_x < 1 << 14 && high_y - low_y < 1 << 14) {
        scan_box<std::int32_t>(t, x0, y0, x1, y1, row);
    } else {
        scan_box<std::int64_t>(t, x0, y0, x1, y1, row);
    }
}

}  // namespace farfield::detail
