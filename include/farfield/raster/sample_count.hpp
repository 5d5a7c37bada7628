// How many samples an image has.
#pragma once

#include "farfield/settings.hpp"

#include <stdexcept>
#include <string>

#include "farfield/fail.hpp"
#include "farfield/raster/sample_projection.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield::detail {

/// The side of a pixel's square of samples. Throws std::invalid_argument, naming the renderer, for a number that is not
/// a square of 1 to 8.
inline int checked_samples_a_side(int samples, const char* renderer) {
    int side = 1;
    while (side < 8 && side * side < samples) ++side;
    if (side * side != samples) {
        detail::fail<std::invalid_argument>("farfield::" + std::string(renderer) +
                                            ": samples must be 1, 4, 9, 16, 25, 36, 49 or 64, not " +
                                            std::to_string(samples));
    }
    return side;
}

/// Throws std::invalid_argument, naming the renderer, for images of no or too many samples: 16,000 on a side.
inline void check_image_size(const LocalView& view, int samples_a_side, const char* renderer) {
    const double limit = double(SampleProjection::guard_band);
    if (view.width < 1 || view.height < 1 || double(view.width) * samples_a_side > limit ||
        double(view.height) * samples_a_side > limit) {
        detail::fail<std::invalid_argument>("farfield::" + std::string(renderer) +
                                            ": an image must have 1 to 16000 samples on a side");
    }
}

}  // namespace farfield::detail
