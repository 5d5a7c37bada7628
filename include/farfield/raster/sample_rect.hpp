// A rectangle of samples.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <limits>

namespace farfield::detail {

/// Half open; empty where first >= end.
struct SampleRect {
    int x0 = std::numeric_limits<int>::max(), y0 = std::numeric_limits<int>::max();
    int x1 = std::numeric_limits<int>::min(), y1 = std::numeric_limits<int>::min();

    bool is_empty() const { return x0 >= x1 || y0 >= y1; }
    void add(int left, int top, int right, int bottom) {
        x0 = std::min(x0, left);
        y0 = std::min(y0, top);
        x1 = std::max(x1, right);
        y1 = std::max(y1, bottom);
    }
    void add(const SampleRect& r) {
        if (!r.is_empty()) add(r.x0, r.y0, r.x1, r.y1);
    }
};

}  // namespace farfield::detail
