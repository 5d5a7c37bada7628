// The z-pyramid of N. Greene, M. Kass, G. Miller, "Hierarchical Z-buffer Visibility", SIGGRAPH 1993, section 3.2: the
// farthest depth of ever larger squares of samples, so that few numbers tell what lies behind all of them.
//
// Two things differ from the paper. A square has 8 x 8 of the next finer ones instead of 2 x 2: the samples of the
// finest are eight vectors, and a third of the memory and of the levels is saved. And nothing is propagated while
// drawing: depths only come nearer within a frame, so an outdated farthest depth errs towards the far side, and a
// square is updated when it is asked about.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <limits>
#include <vector>

namespace farfield::detail {

/// Lies over a z-buffer that it does not own, stored row by row, larger when nearer. It has one number for 64 samples,
/// one for 64 of those and so on.
class DepthPyramid {
  public:
    static constexpr int log2_side = 3, side = 1 << log2_side;

    /// `depth` must be empty, that is -infinity, and stay in its place until the next begin().
    void begin(const float* depth, int width, int height) {
        depth_ = depth;
        width_ = width;
        height_ = height;
        std::size_t count = 0;
        int columns = width, rows = height;
        level_count_ = 0;
        do {
            columns = (columns + side - 1) >> log2_side;
            rows = (rows + side - 1) >> log2_side;
            levels_[level_count_++] = {count, columns};
            count += std::size_t(columns) * std::size_t(rows);
        } while (columns > side || rows > side);
        farthest_.assign(count, -std::numeric_limits<float>::infinity());
    }

    /// Is every sample of a rectangle (ends included, inside the picture) nearer than q?
    bool all_nearer(int x0, int y0, int x1, int y1, float q) {
        return all_nearer(x0, y0, x1, y1, [q](int, int, int, int) { return q; });
    }
    /// The same for something whose q is at most nearest(x0, y0, x1, y1) in any such rectangle.
    template <class Nearest>
    requires std::invocable<Nearest, int, int, int, int>
    bool all_nearer(int x0, int y0, int x1, int y1, const Nearest& nearest) {
        // Most queries are about something visible and fail here.
        const int middle_x = (x0 + x1) >> 1, middle_y = (y0 + y1) >> 1;
        if (!(at(middle_x, middle_y) > nearest(middle_x, middle_y, middle_x, middle_y))) return false;
        const int width = x1 - x0 + 1, height = y1 - y0 + 1;
        if (width <= side && height <= side && width * height <= side * side / 2) {
            return samples_nearer(x0, y0, x1, y1, nearest);
        }
        int level = 0;
        while (level + 1 < level_count_ && std::max(width, height) >> (log2_side * (level + 2)) > 1) ++level;
        return squares_nearer(level, x0, y0, x1, y1, nearest);
    }

  private:
    struct Level {
        std::size_t first;
        int columns;
    };

    float at(int x, int y) const { return depth_[std::size_t(y) * std::size_t(width_) + std::size_t(x)]; }

    template <class Nearest>
    bool samples_nearer(int x0, int y0, int x1, int y1, const Nearest& nearest) const {
        for (int y = y0; y <= y1; ++y) {
            const float* row = depth_ + std::size_t(y) * std::size_t(width_);
            for (int x = x0; x <= x1; ++x) {
                if (!(row[x] > nearest(x, y, x, y))) return false;
            }
        }
        return true;
    }

    template <class Nearest>
    bool squares_nearer(int level, int x0, int y0, int x1, int y1, const Nearest& nearest) {
        const int shift = log2_side * (level + 1);
        for (int row = y0 >> shift; row <= y1 >> shift; ++row) {
            float* farthest =
                farthest_.data() + levels_[level].first + std::size_t(row) * std::size_t(levels_[level].columns);
            for (int column = x0 >> shift; column <= x1 >> shift; ++column) {
                const int left = column << shift, right = std::min(left + (1 << shift), width_) - 1;
                const int top = row << shift, bottom = std::min(top + (1 << shift), height_) - 1;
                const float q =
                    nearest(std::max(x0, left), std::max(y0, top), std::min(x1, right), std::min(y1, bottom));
                if (farthest[column] > q) continue;
                const bool is_inside = x0 <= left && y0 <= top && x1 >= right && y1 >= bottom;
                if (level == 0) {
                    farthest[column] = farthest_sample(left, top, right, bottom);
                    if (farthest[column] > q) continue;
                    if (!samples_nearer(std::max(x0, left), std::max(y0, top), std::min(x1, right),
                                        std::min(y1, bottom), nearest)) {
                        return false;
                    }
                } else {
                    if (!squares_nearer(level - 1, std::max(x0, left), std::max(y0, top), std::min(x1, right),
                                        std::min(y1, bottom), nearest)) {
                        return false;
                    }
                    if (is_inside) farthest[column] = farthest_square(level - 1, left, top, right, bottom);
                }
            }
        }
        return true;
    }

    float farthest_sample(int left, int top, int right, int bottom) const {
        if (right - left + 1 < side) {
            float least = at(left, top);
            for (int y = top; y <= bottom; ++y) {
                for (int x = left; x <= right; ++x) least = std::min(least, at(x, y));
            }
            return least;
        }
        typedef float Floats __attribute__((vector_size(16)));
        Floats least[2];
        const float* row = depth_ + std::size_t(top) * std::size_t(width_) + std::size_t(left);
        __builtin_memcpy(least, row, sizeof least);
        for (int y = top; y < bottom; ++y) {
            row += width_;
            Floats next[2];
            __builtin_memcpy(next, row, sizeof next);
            least[0] = next[0] < least[0] ? next[0] : least[0];
            least[1] = next[1] < least[1] ? next[1] : least[1];
        }
        least[0] = least[1] < least[0] ? least[1] : least[0];
        return std::min(std::min(least[0][0], least[0][1]), std::min(least[0][2], least[0][3]));
    }

    float farthest_square(int level, int left, int top, int right, int bottom) const {
        const int shift = log2_side * (level + 1);
        float least = std::numeric_limits<float>::infinity();
        for (int row = top >> shift; row <= bottom >> shift; ++row) {
            const float* farthest =
                farthest_.data() + levels_[level].first + std::size_t(row) * std::size_t(levels_[level].columns);
            for (int column = left >> shift; column <= right >> shift; ++column) {
                least = std::min(least, farthest[column]);
            }
        }
        return least;
    }

    const float* depth_ = nullptr;
    int width_ = 0, height_ = 0, level_count_ = 0;
    Level levels_[8]{};
    std::vector<float> farthest_;  ///< finest level first
};

}  // namespace farfield::detail
