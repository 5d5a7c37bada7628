// How far a picture is from the truth.
#pragma once

#include <optional>

#include "farfield/measure/coverage_error.hpp"
#include "farfield/measure/flip.hpp"
#include "farfield/measure/image_error.hpp"
#include "farfield/measure/pixel_rect.hpp"
#include "farfield/measure/projected_rect.hpp"
#include "farfield/measure/ssim.hpp"
#include "report/picture.hpp"
#include "row.hpp"
#include "scenes/built_scene.hpp"

namespace farfield::bench {

/// Exact at 256 samples a pixel: 64 on a picture of twice the width and height, averaged. So that exact at 64 has an
/// error too, and a place on the chart.
class Reference {
  public:
    Reference() = default;
    /// `viewer` draws 64 samples a pixel.
    Reference(scenes::SceneViewer& viewer, View view, const Box& bounds) : rect_(projected_rect(bounds, view)) {
        image_ = Image(view.width, view.height);
        view.width *= 2;
        view.height *= 2;
        viewer.frame(view);
        const Image& fine = viewer.image();
        for (int y = 0; y < image_.height(); ++y) {
            for (int x = 0; x < image_.width(); ++x) {
                const auto mean = [&](std::uint8_t Rgba8::*channel) {
                    const int sum = fine.at(2 * x, 2 * y).*channel + fine.at(2 * x + 1, 2 * y).*channel +
                                    fine.at(2 * x, 2 * y + 1).*channel + fine.at(2 * x + 1, 2 * y + 1).*channel;
                    return std::uint8_t((sum + 2) / 4);
                };
                image_.at(x, y) = {mean(&Rgba8::r), mean(&Rgba8::g), mean(&Rgba8::b), mean(&Rgba8::a)};
            }
        }
        over_white_ = report::over_background(image_, {});
    }

    const Image& over_white() const { return over_white_; }

    /// What of a picture is compared.
    Image compared_part(const Image& picture) const {
        const PixelRect part = compared_rect(picture, over_white_, rect_);
        Image result(part.width(), part.height());
        for (int y = 0; y < result.height(); ++y) {
            for (int x = 0; x < result.width(); ++x) result.at(x, y) = picture.at(part.x0 + x, part.y0 + y);
        }
        return result;
    }

    /// Over the rectangle that the object takes; over the whole picture where the eye is within its bounds.
    void compare(const Image& image, Row& row) const {
        const Image picture = report::over_background(image, {});
        row.rmse = rmse(picture, over_white_, rect_);
        row.flip = flip(picture, over_white_, rect_);
        row.ssim = ssim(picture, over_white_, rect_);
        const CoverageError coverage = coverage_error(image, image_, rect_);
        row.coverage_bias = coverage.bias;
        row.coverage_rms = coverage.rms;
    }

  private:
    std::optional<PixelRect> rect_;
    Image image_, over_white_;
};

}  // namespace farfield::bench
