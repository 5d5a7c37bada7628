// The z-pyramid of N. Greene, M. Kass, G. Miller, "Hierarchical Z-buffer Visibility", SIGGRAPH 1993, section 3.2: the
// farthest depth of ever larger squares of samples, so that few numbers tell what lies behind all of them.
//
// Two things differ from the paper. A square has 8 x 8 of the next finer ones instead of 2 x 2, which saves a
// third of the memory and of the levels; the finest are the blocks that samples lie in. And nothing is propagated while
// drawing: depths only come nearer within a frame, so an outdated farthest depth errs towards the far side, and a
// square is updated when it is asked about.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <limits>
#include <vector>

#include "farfield/raster/samples/sample_blocks.hpp"

namespace farfield::detail {

/// Lies over blocks of samples that it does not own, which are its finest level. It has one number for 64 blocks, one
/// for 64 of those and so on.
class DepthPyramid {
  public:
    static constexpr int log2_side = SampleBlocks::log2_side, side = SampleBlocks::side;

    /// Nothing is drawn yet; the blocks must stay in their place until the next begin().
    void begin(SampleBlocks& blocks) {
        blocks_ = &blocks;
        std::size_t count = 0;
        int columns = blocks.columns(), rows = (blocks.height() + side - 1) >> log2_side;
        level_count_ = 1;
        while (columns > side || rows > side) {
            columns = (columns + side - 1) >> log2_side;
            rows = (rows + side - 1) >> log2_side;
            levels_[level_count_++] = {count, columns};
            count += std::size_t(columns) * std::size_t(rows);
        }
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
        if (!(blocks_->depth(middle_x, middle_y) > nearest(middle_x, middle_y, middle_x, middle_y))) return false;
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

    template <class Nearest>
    bool samples_nearer(int x0, int y0, int x1, int y1, const Nearest& nearest) const {
        for (int y = y0; y <= y1; ++y) {
            for (int x = x0; x <= x1; ++x) {
                if (!(blocks_->depth(x, y) > nearest(x, y, x, y))) return false;
            }
        }
        return true;
    }

    template <class Nearest>
    bool squares_nearer(int level, int x0, int y0, int x1, int y1, const Nearest& nearest) {
        if (level == 0) return blocks_nearer(x0, y0, x1, y1, nearest);
        const int shift = log2_side * (level + 1);
        for (int row = y0 >> shift; row <= y1 >> shift; ++row) {
            float* farthest = row_of(level, row);
            for (int column = x0 >> shift; column <= x1 >> shift; ++column) {
                const int left = column << shift, right = std::min(left + (1 << shift), blocks_->width()) - 1;
                const int top = row << shift, bottom = std::min(top + (1 << shift), blocks_->height()) - 1;
                const int from_x = std::max(x0, left), to_x = std::min(x1, right);
                const int from_y = std::max(y0, top), to_y = std::min(y1, bottom);
                if (farthest[column] > nearest(from_x, from_y, to_x, to_y)) continue;
                if (!squares_nearer(level - 1, from_x, from_y, to_x, to_y, nearest)) return false;
                const bool is_inside = x0 <= left && y0 <= top && x1 >= right && y1 >= bottom;
                if (is_inside) farthest[column] = farthest_square(level - 1, left, top, right, bottom);
            }
        }
        return true;
    }

    template <class Nearest>
    bool blocks_nearer(int x0, int y0, int x1, int y1, const Nearest& nearest) {
        for (int row = y0 >> log2_side; row <= y1 >> log2_side; ++row) {
            const int from_y = std::max(y0, row * side), to_y = std::min(y1, row * side + side - 1);
            for (int column = x0 >> log2_side; column <= x1 >> log2_side; ++column) {
                const int from_x = std::max(x0, column * side), to_x = std::min(x1, column * side + side - 1);
                const std::size_t at = blocks_->index(column, row);
                const float q = nearest(from_x, from_y, to_x, to_y);
                if (blocks_->farthest(at) > q || blocks_->exact_farthest(at) > q) continue;
                if (!samples_nearer(from_x, from_y, to_x, to_y, nearest)) return false;
            }
        }
        return true;
    }

    float farthest_square(int level, int left, int top, int right, int bottom) const {
        const int shift = log2_side * (level + 1);
        float least = std::numeric_limits<float>::infinity();
        for (int row = top >> shift; row <= bottom >> shift; ++row) {
            for (int column = left >> shift; column <= right >> shift; ++column) {
                least = std::min(
                    least, level == 0 ? blocks_->farthest(blocks_->index(column, row)) : row_of(level, row)[column]);
            }
        }
        return least;
    }

    float* row_of(int level, int row) {
        return farthest_.data() + levels_[level].first + std::size_t(row) * std::size_t(levels_[level].columns);
    }
    const float* row_of(int level, int row) const { return const_cast<DepthPyramid*>(this)->row_of(level, row); }

    SampleBlocks* blocks_ = nullptr;
    int level_count_ = 0;
    Level levels_[8]{};
    std::vector<float> farthest_;  ///< finest level first
};

}  // namespace farfield::detail
