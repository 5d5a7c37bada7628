// Which of many are worth choosing: those that no other one beats in time and in error.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <span>
#include <vector>

namespace farfield::bench {

struct ChartPoint {
    double x = 0, y = 0;  ///< less is better
};

/// Indices of the points that no other point equals or beats in both coordinates, from left to right, that is with
/// falling y. Of equal points the first; points that are not finite never.
inline std::vector<std::size_t> pareto_front(std::span<const ChartPoint> points) {
    std::vector<std::size_t> order(points.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::erase_if(order, [&](std::size_t i) { return !std::isfinite(points[i].x) || !std::isfinite(points[i].y); });
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return points[a].x != points[b].x ? points[a].x < points[b].x : points[a].y < points[b].y;
    });
    std::vector<std::size_t> front;
    for (const std::size_t i : order) {
        if (front.empty() || points[i].y < points[front.back()].y) front.push_back(i);
    }
    return front;
}

}  // namespace farfield::bench
