// How far pictures are from their references, over all frames that are compared.
#pragma once

#include <cmath>
#include <limits>
#include <optional>

#include "farfield/measure/coverage_error.hpp"
#include "farfield/measure/flicker.hpp"
#include "farfield/measure/flip.hpp"
#include "farfield/measure/image_error.hpp"
#include "farfield/measure/ssim.hpp"

namespace walkthrough {

/// Squares are averaged before roots and logarithms are taken, all else is averaged as it is.
class Errors {
  public:
    /// Of a frame later than all before it. Colors are compared over a background, coverage without one. `rect` as in
    /// measure/.
    void add(int frame, const farfield::Image& picture, const farfield::Image& reference,
             const farfield::Image& over_background, const farfield::Image& reference_over_background,
             std::optional<farfield::PixelRect> rect) {
        ++count_;
        if (frame != last_frame_ + 1) flicker_.cut();
        last_frame_ = frame;
        flicker_.add(over_background, reference_over_background, rect);
        mse_ += farfield::mse(over_background, reference_over_background, rect);
        ssim_ += farfield::ssim(over_background, reference_over_background, rect);
        flip_ += farfield::flip(over_background, reference_over_background, rect);
        const farfield::CoverageError coverage = farfield::coverage_error(picture, reference, rect);
        coverage_bias_ += coverage.bias;
        coverage_mse_ += coverage.rms * coverage.rms;
    }

    // All of at least one frame.
    double rmse() const { return std::sqrt(mse_ / count_); }
    double psnr() const { return mse_ > 0 ? -10 * std::log10(mse_ / count_) : std::numeric_limits<double>::infinity(); }
    double ssim() const { return ssim_ / count_; }
    double flip() const { return flip_ / count_; }
    double coverage_bias() const { return coverage_bias_ / count_; }
    double coverage_rms() const { return std::sqrt(coverage_mse_ / count_); }
    /// In the unit of `rmse`. None unless frames that follow each other were compared.
    std::optional<double> flicker_rms() const {
        return flicker_.steps() > 0 ? std::optional(flicker_.rms()) : std::nullopt;
    }

  private:
    double count_ = 0, mse_ = 0, ssim_ = 0, flip_ = 0, coverage_bias_ = 0, coverage_mse_ = 0;
    farfield::Flicker flicker_;
    int last_frame_ = -1;
};

}  // namespace walkthrough
