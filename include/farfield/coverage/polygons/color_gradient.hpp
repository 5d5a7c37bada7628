// Interpolates colors that differ from corner to corner of a polygon, with perspective, at the centers of pixels.
#pragma once

#include "farfield/settings.hpp"

#include <array>
#include <cstdint>

#include "farfield/geometry/rgba8.hpp"
#include "farfield/raster/sample_projection.hpp"
#include "farfield/raster/scan_conversion.hpp"
#include "farfield/simd.hpp"

namespace farfield::detail {

/// Color times weight and weight are linear on the screen; the weight is q in perspective. Results are clamped to the
/// range of the corners, because pixels that a polygon only touches have their centers beyond its edges.
class ColorGradient {
  public:
    ColorGradient() = default;
    /// `corners` belong to colors[0..2]; all four colors bound the results. A triangle without area gives any color in
    /// bounds.
    FARFIELD_INLINE ColorGradient(const SnappedTriangle& corners, const std::array<Rgba8, 4>& colors,
                                  ColorWeight weight_of) {
        const std::int64_t area = corners.doubled_area();
        const float scale = area != 0 ? 256.0f / float(area) : 0.0f;
        const auto x1 = float(corners.x[1] - corners.x[0]), y1 = float(corners.y[1] - corners.y[0]);
        const auto x2 = float(corners.x[2] - corners.x[0]), y2 = float(corners.y[2] - corners.y[0]);
        x_ = float(corners.x[0]) * (1.0f / 256);
        y_ = float(corners.y[0]) * (1.0f / 256);
        const float weight[3] = {weight_of(corners.q[0]), weight_of(corners.q[1]), weight_of(corners.q[2])};
        const auto make = [&](auto& value, auto& by_x, auto& by_y, auto v0, auto v1, auto v2) {
            const auto d1 = v1 - v0, d2 = v2 - v0;
            value = v0;
            by_x = (d1 * y2 - d2 * y1) * scale;
            by_y = (d2 * x1 - d1 * x2) * scale;
        };
        make(weight_, weight_by_x_, weight_by_y_, weight[0], weight[1], weight[2]);
        const Floats channels[4] = {channels_of(colors[0]), channels_of(colors[1]), channels_of(colors[2]),
                                    channels_of(colors[3])};
        make(value_, by_x_, by_y_, channels[0] * weight[0], channels[1] * weight[1], channels[2] * weight[2]);
        lowest_ = highest_ = channels[0];
        for (const Floats& c : channels) {
            lowest_ = c < lowest_ ? c : lowest_;
            highest_ = c > highest_ ? c : highest_;
        }
    }

    /// The colors of eight pixels in a row, each eight samples wide; (x, y) is the center of the first, in samples.
    FARFIELD_INLINE std::array<Rgba8, 8> eight_pixels(float x, float y) const {
        typedef float Eight __attribute__((vector_size(32)));
        typedef std::int32_t EightInts __attribute__((vector_size(32)));
        const Eight dx = Eight{0, 8, 16, 24, 32, 40, 48, 56} + (x - x_);
        const float dy = y - y_;
        const Eight inverse = 1.0f / (dx * weight_by_x_ + (dy * weight_by_y_ + weight_));
        const Floats at_row = dy * by_y_ + value_;
        EightInts packed{};
        for (int c = 0; c < 4; ++c) {
            Eight v = (dx * by_x_[c] + at_row[c]) * inverse;
            v = v > lowest_[c] ? v : Eight{} + lowest_[c];  // NaN too
            v = v < highest_[c] ? v : Eight{} + highest_[c];
            packed |= __builtin_convertvector(v + 0.5f, EightInts) << std::int32_t(8 * c);
        }
        std::array<Rgba8, 8> colors;
        __builtin_memcpy(static_cast<void*>(colors.data()), &packed, sizeof colors);
        return colors;
    }
    /// The same for one pixel.
    FARFIELD_INLINE Rgba8 pixel(float x, float y) const {
        typedef std::int32_t Ints __attribute__((vector_size(16)));
        const float dx = x - x_, dy = y - y_;
        const float inverse = 1.0f / (dx * weight_by_x_ + (dy * weight_by_y_ + weight_));
        Floats v = (dx * by_x_ + (dy * by_y_ + value_)) * inverse;
        v = v > lowest_ ? v : lowest_;  // NaN too
        v = v < highest_ ? v : highest_;
        const Ints rounded = __builtin_convertvector(v + 0.5f, Ints);
        return {std::uint8_t(rounded[0]), std::uint8_t(rounded[1]), std::uint8_t(rounded[2]), std::uint8_t(rounded[3])};
    }

  private:
    typedef float Floats __attribute__((vector_size(16)));  ///< r, g, b, a

    FARFIELD_INLINE static Floats channels_of(Rgba8 c) {
        return Floats{float(c.r), float(c.g), float(c.b), float(c.a)};
    }

    Floats value_{}, by_x_{}, by_y_{};  ///< channels times weight, at the first corner
    Floats lowest_{}, highest_{};
    float weight_ = 0, weight_by_x_ = 0, weight_by_y_ = 0;
    float x_ = 0, y_ = 0;  ///< first corner, in samples
};

}  // namespace farfield::detail
