// Samples that have a color and no depth, and the picture made from them.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "farfield/geometry/rgba8.hpp"
#include "farfield/image.hpp"
#include "farfield/raster/made_for.hpp"
#include "farfield/raster/sample_projection.hpp"
#include "farfield/raster/sample_rect.hpp"
#include "farfield/raster/samples/box_mean.hpp"

namespace farfield::detail {

/// Samples are addressed relative to the projection's center sample. Only what the last frame drew is cleared.
class ColorSamples {
  public:
    void begin(const SampleProjection& projection, int samples_a_side, Rgba8 background) {
        const int width = projection.end_x - projection.first_x, height = projection.end_y - projection.first_y;
        const bool is_new = made_for_({{width, height}, samples_a_side, background}, [&] {
            width_ = width;
            height_ = height;
            side_ = samples_a_side;
            background_ = background;
            color_.assign(std::size_t(width) * std::size_t(height) + padding, background);
            image_is_stale_ = true;
        });
        if (!is_new) {
            for (int y = drawn_.y0; y < drawn_.y1; ++y) {
                std::fill(at(drawn_.x0, y), at(drawn_.x1, y), background_);
            }
        }
        drawn_ = {};
        first_x_ = projection.first_x;
        first_y_ = projection.first_y;
    }

    /// The colors of row y, indexed with x. The caller reports what it writes by drawn().
    Rgba8* row(int y) { return at(0, y - first_y_) - first_x_; }
    void drawn(int x0, int y0, int x1, int y1) {
        drawn_.add(x0 - first_x_, y0 - first_y_, x1 - first_x_, y1 - first_y_);
    }

    /// Writes the mean of each pixel's samples, but only where they changed since the last resolve into the same image.
    void resolve(Image& image) {
        const int width = width_ / side_, height = height_ / side_;
        if (image_is_stale_ || image.width() != width || image.height() != height) {
            image = Image(width, height, background_);
            drawn_in_image_ = {};
            image_is_stale_ = false;
        }
        SampleRect changed = drawn_in_image_;
        changed.add(drawn_);
        drawn_in_image_ = drawn_;
        if (changed.is_empty()) return;
        for (int y = changed.y0 / side_; y <= (changed.y1 - 1) / side_; ++y) {
            const int x0 = changed.x0 / side_, x1 = (changed.x1 - 1) / side_;
            const Rgba8* from = at(x0 * side_, y * side_);
            if (side_ == 1) {
                std::copy(from, from + (x1 - x0 + 1), &image.at(x0, y));
                continue;
            }
            for (int x = x0; x <= x1; ++x, from += side_) {
                image.at(x, y) = mean_of_samples(from, std::size_t(width_), side_);
            }
        }
    }

  private:
    static constexpr std::size_t padding = 8;  ///< rows are filled in vectors

    struct Kind {
        BufferSize size;
        int samples_a_side;
        Rgba8 background;
        friend bool operator==(const Kind&, const Kind&) = default;
    };

    Rgba8* at(int x, int y) { return color_.data() + (std::size_t(y) * std::size_t(width_) + std::size_t(x)); }

    MadeFor<Kind> made_for_;
    int width_ = 0, height_ = 0, side_ = 1;
    int first_x_ = 0, first_y_ = 0;
    Rgba8 background_{0, 0, 0, 0};
    std::vector<Rgba8> color_;
    SampleRect drawn_, drawn_in_image_;  ///< relative to the upper left sample
    bool image_is_stale_ = true;
};

}  // namespace farfield::detail
