// What tells two pictures apart, as a picture and as numbers.
#pragma once

#include <array>
#include <string_view>

#include "farfield/image.hpp"

namespace viewer {

/// FLIP is what an eye sees that alternates between the two; absolute differences are those of the channels, amplified.
enum class Difference { flip, absolute };

inline constexpr std::array<const char*, 2> difference_names{"FLIP", "absolute, x 4"};

struct Compared {
    farfield::Image picture;  ///< opaque: dark where equal, through violet and orange to light yellow
    double flip = -1;         ///< mean; below 0: not asked for
    double rmse = 0;          ///< of channels in [0, 1]
};

/// Of opaque pictures of one size.
Compared compare(const farfield::Image& variant, const farfield::Image& exact, Difference difference);

/// From dark to light, and told apart in gray too.
farfield::Rgba8 tint_of_error(float error);

}  // namespace viewer
