// How much a sequence of pictures changes beyond its reference: the part of an error that a still picture does not
// show. Where levels of detail are swapped it gathers in a few frames, the pops.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <vector>

#include "farfield/fail.hpp"
#include "farfield/image.hpp"
#include "farfield/measure/pixel_rect.hpp"

namespace farfield {

/// Takes in the frames of a sequence and of its reference, in order. With I and R the red, green and blue of both, as
/// stored, in [0, 1], it measures (I_t - I_t-1) - (R_t - R_t-1), the change of the error from a frame to the next:
/// movement in both does not count, nor does an error that stays. Alpha is not compared.
///
/// It errs high for an error on a moving thing: it changes every pixel that it crosses, though an eye that follows sees
/// it stand still. It errs low for one pop in a long calm sequence: the mean thins it out, `largest_pop_rms` does not.
class Flicker {
  public:
    /// Adds the next frame, compared over `rect` (without one: all). The step to it is compared over the smallest
    /// rectangle that holds those of both its frames. Throws as `compared_rect` does, and std::invalid_argument for a
    /// size other than the first frame's, and is then as before. Allocates at the first frame only.
    void add(const Image& variant, const Image& reference, std::optional<PixelRect> rect = {});

    /// Says that the next frame does not follow the last one: there is no step between them.
    void cut() { follows_ = false; }

    /// The number of frames added, and of steps between two that follow each other, which are compared.
    int frames() const { return frames_; }
    int steps() const { return steps_; }

    /// Mean of the square over channels, pixels and steps, all steps alike: in [0, 4], 0 without a step.
    double mse() const { return steps_ > 0 ? sum_of_mse_ / steps_ : 0.0; }
    /// Square root of `mse`, in the unit of a channel: in [0, 2].
    double rms() const { return std::sqrt(mse()); }

    /// The largest root mean square of a single step: in [0, 2], 0 without a step.
    double largest_pop_rms() const { return std::sqrt(largest_mse_); }
    /// The frame that step leads to, counted from 0 in order of `add`; the first of equal ones. 0, which no step leads
    /// to, if nothing has changed.
    int largest_pop_frame() const { return largest_frame_; }

  private:
    using Error = std::array<std::int16_t, 3>;

    static Error error(Rgba8 variant, Rgba8 reference) {
        const auto difference = [](int a, int b) { return static_cast<std::int16_t>(a - b); };
        return {difference(variant.r, reference.r), difference(variant.g, reference.g),
                difference(variant.b, reference.b)};
    }

    int width_ = 0, height_ = 0;  ///< of all frames
    std::vector<Error> errors_;   ///< of the last frame, all of its pixels
    PixelRect rect_;              ///< of the last frame
    bool follows_ = false;        ///< does the next frame follow the last one?
    int frames_ = 0, steps_ = 0, largest_frame_ = 0;
    double sum_of_mse_ = 0, largest_mse_ = 0;
};

inline void Flicker::add(const Image& variant, const Image& reference, std::optional<PixelRect> rect) {
    const PixelRect compared = compared_rect(variant, reference, rect);
    if (frames_ == 0) {
        errors_.resize(reference.pixels().size());
        width_ = reference.width();
        height_ = reference.height();
    } else if (reference.width() != width_ || reference.height() != height_) {
        detail::fail<std::invalid_argument>("farfield::Flicker: frames of one sequence must be of one size");
    }
    PixelRect r = compared;
    if (follows_)
        r = {std::min(r.x0, rect_.x0), std::min(r.y0, rect_.y0), std::max(r.x1, rect_.x1), std::max(r.y1, rect_.y1)};

    // Integers: exact in any order.
    std::int64_t sum = 0;
    auto last = errors_.begin();
    for (int y = 0; y < height_; ++y) {
        for (int x = 0; x < width_; ++x, ++last) {
            const Error now = error(variant.at(x, y), reference.at(x, y));
            if (x >= r.x0 && x < r.x1 && y >= r.y0 && y < r.y1) {
                for (std::size_t k = 0; k < 3; ++k) {
                    const int change = now[k] - (*last)[k];
                    sum += change * change;
                }
            }
            *last = now;
        }
    }
    if (follows_) {
        const double step = static_cast<double>(sum) / (3.0 * r.width() * r.height() * 255.0 * 255.0);
        sum_of_mse_ += step;
        ++steps_;
        if (step > largest_mse_) {
            largest_mse_ = step;
            largest_frame_ = frames_;
        }
    }
    rect_ = compared;
    follows_ = true;
    ++frames_;
}

}  // namespace farfield
