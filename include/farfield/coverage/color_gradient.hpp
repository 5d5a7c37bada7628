// Colors that differ from corner to corner of a polygon, as perspective has them, at the centers of pixels.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "farfield/geometry/rgba8.hpp"
#include "farfield/raster/scan_conversion.hpp"

namespace farfield {

/// Color times weight and weight are linear on the screen, the weight being q in perspective. Kept inside what the
/// corners span: pixels that a polygon only touches have their centers beyond its edges.
class ColorGradient {
  public:
    ColorGradient() = default;
    /// `corners` are colors[0..2]'s; all of `colors` bound what comes out. Of a triangle without area, anything.
    ColorGradient(const SnappedTriangle& corners, const std::array<Rgba8, 4>& colors, bool is_perspective) {
        const std::int64_t area = corners.doubled_area();
        const float scale = area != 0 ? 256.0f / float(area) : 0.0f;
        const auto x1 = float(corners.x[1] - corners.x[0]), y1 = float(corners.y[1] - corners.y[0]);
        const auto x2 = float(corners.x[2] - corners.x[0]), y2 = float(corners.y[2] - corners.y[0]);
        x_ = float(corners.x[0]) * (1.0f / 256);
        y_ = float(corners.y[0]) * (1.0f / 256);
        float weight[3] = {1, 1, 1};
        if (is_perspective) std::copy(corners.q, corners.q + 3, weight);
        for (unsigned c = 0; c < 5; ++c) {
            float v[3];
            for (unsigned i = 0; i < 3; ++i) v[i] = weight[i] * (c == 4 ? 1.0f : channel(colors[i], c));
            const float d1 = v[1] - v[0], d2 = v[2] - v[0];
            value_[c] = v[0];
            by_x_[c] = (d1 * y2 - d2 * y1) * scale;
            by_y_[c] = (d2 * x1 - d1 * x2) * scale;
        }
        for (unsigned c = 0; c < 4; ++c) {
            lowest_[c] = highest_[c] = channel(colors[0], c);
            for (const Rgba8 color : colors) {
                lowest_[c] = std::min(lowest_[c], channel(color, c));
                highest_[c] = std::max(highest_[c], channel(color, c));
            }
        }
    }

    /// Of eight pixels in a row, the center of the first being (x, y), in samples; each is eight samples wide.
    [[gnu::always_inline]] std::array<Rgba8, 8> eight_pixels(float x, float y) const {
        typedef float Floats __attribute__((vector_size(32)));
        typedef std::int32_t Ints __attribute__((vector_size(32)));
        const Floats dx = Floats{0, 8, 16, 24, 32, 40, 48, 56} + (x - x_);
        const Floats inverse = 1.0f / (dx * by_x_[4] + ((y - y_) * by_y_[4] + value_[4]));
        Ints packed{};
        for (unsigned c = 0; c < 4; ++c) {
            Floats v = (dx * by_x_[c] + ((y - y_) * by_y_[c] + value_[c])) * inverse;
            v = v > lowest_[c] ? v : Floats{} + lowest_[c];  // NaN too
            v = v < highest_[c] ? v : Floats{} + highest_[c];
            packed |= __builtin_convertvector(v + 0.5f, Ints) << std::int32_t(8 * c);
        }
        std::array<Rgba8, 8> colors;
        __builtin_memcpy(static_cast<void*>(colors.data()), &packed, sizeof colors);
        return colors;
    }
    Rgba8 pixel(float x, float y) const { return eight_pixels(x, y)[0]; }

  private:
    static float channel(Rgba8 color, unsigned c) {
        return float(c == 0 ? color.r : c == 1 ? color.g : c == 2 ? color.b : color.a);
    }

    float x_ = 0, y_ = 0;                       ///< of the first corner, in samples
    float value_[5]{}, by_x_[5]{}, by_y_[5]{};  ///< of r, g, b, a times weight, and of the weight
    float lowest_[4]{}, highest_[4]{};
};

}  // namespace farfield
