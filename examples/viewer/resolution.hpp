// How large pictures are drawn while the camera moves, so that they come often enough; when it stands they are whole.
#pragma once

#include <array>
#include <cstddef>

namespace viewer {

class Resolution {
  public:
    static constexpr int coarsest = 6;

    explicit Resolution(double wanted_ms = 60) : wanted_ms_(wanted_ms) {}

    /// Pixels on the side of what is drawn as one: the least of which pictures are expected to come in time.
    int moving() const {
        for (int side = 1; side < coarsest; ++side) {
            if (expected_ms(side) <= wanted_ms_) return side;
        }
        return coarsest;
    }
    /// Tells what a picture took.
    void took(int side, double ms) {
        double& known = ms_[std::size_t(side)];
        known = known > 0 ? 0.6 * known + 0.4 * ms : ms;
        // What others would take is guessed anew from the last: the scene looks different now.
        for (std::size_t i = 1; i < ms_.size(); ++i) {
            if (int(i) != side) ms_[i] = 0;
        }
        last_ = side;
    }
    void forget() {
        ms_ = {};
        last_ = 0;
    }

  private:
    /// Half of the time goes with the pixels, half with what is drawn.
    double expected_ms(int side) const {
        if (last_ == 0) return side < 2 ? wanted_ms_ * 2 : 0;
        const double ratio = double(last_) / double(side);
        return ms_[std::size_t(last_)] * (0.5 + 0.5 * ratio * ratio);
    }

    double wanted_ms_;
    std::array<double, coarsest + 1> ms_{};
    int last_ = 0;  ///< 0: nothing is known
};

}  // namespace viewer
