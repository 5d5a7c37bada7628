// How long things take here.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <vector>

namespace farfield::bench {

inline double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

template <class F>
double seconds(F&& f) {
    const auto start = std::chrono::steady_clock::now();
    f();
    return seconds_since(start);
}

/// Of a frame that takes turns with those of others; the last one took `last_seconds`, 0: there was none. Short frames
/// are drawn twice and timed once: a viewer draws the same scene frame after frame and finds it in the caches, which
/// the others here have emptied. Long ones fill the caches with themselves anyway.
template <class F>
double seconds_in_turn(double last_seconds, F&& frame) {
    constexpr double short_frame = 4e-3;
    if (last_seconds < short_frame) frame();
    return seconds(frame);
}

/// The upper one of an even number; there must be one.
inline double median(std::vector<double> v) {
    std::nth_element(v.begin(), v.begin() + std::ptrdiff_t(v.size() / 2), v.end());
    return v[v.size() / 2];
}

}  // namespace farfield::bench
