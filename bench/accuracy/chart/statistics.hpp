// What is told of measurements that were repeated, on a machine that others use too.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace farfield::bench {

/// A quarter of the values lies below `first`, a half below `median`, a quarter above `third`.
struct Quartiles {
    double first = 0, median = 0, third = 0;

    friend bool operator==(const Quartiles&, const Quartiles&) = default;
};

/// Linear between neighbors in order, the smallest value at 0 and the largest at 1 (Hyndman and Fan 1996, definition
/// 7). All NaN over no values.
inline Quartiles quartiles(std::vector<double> values) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    if (values.empty()) return {nan, nan, nan};
    std::sort(values.begin(), values.end());
    const auto at = [&](double part) {
        const double place = part * double(values.size() - 1);
        const auto below = std::size_t(place);
        const std::size_t above = std::min(below + 1, values.size() - 1);
        const double weight = place - double(below);
        return weight > 0 ? values[below] + weight * (values[above] - values[below]) : values[below];
    };
    return {at(0.25), at(0.5), at(0.75)};
}

}  // namespace farfield::bench
