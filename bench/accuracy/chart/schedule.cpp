#include "schedule.hpp"

#include <algorithm>
#include <cmath>

namespace farfield::bench {
namespace {

std::string rounded(double seconds) {
    if (seconds < 90) return std::to_string(10 * std::lround(std::ceil(seconds / 10))) + " s";
    return std::to_string(std::lround(std::ceil(seconds / 60))) + " min";
}

}  // namespace

void Schedule::begin(const std::string& task, double seconds, int steps) {
    done_ += current_;
    current_ = seconds;
    const double elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
    // The guesses count as if they had been right for a while, lest the first steps decide.
    constexpr double trusted_seconds = 10;
    const double pace = (elapsed + trusted_seconds) / (done_ + trusted_seconds);
    const double left = std::max(planned_ - done_, seconds) * pace;
    progress_.begin(task + " (about " + rounded(left) + " left)", steps);
}

}  // namespace farfield::bench
