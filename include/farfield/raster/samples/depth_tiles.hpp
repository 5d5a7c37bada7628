// The farthest depth of each 8 x 8 samples, so that a cell behind all of them is recognized without looking at samples:
// two levels of the z-pyramid of N. Greene, M. Kass, G. Miller, "Hierarchical Z-buffer Visibility", SIGGRAPH 1993.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

#include "farfield/raster/sample_rect.hpp"

namespace farfield::detail {

/// Depths only come nearer within a frame, so an outdated farthest depth errs towards the far side. A tile is updated
/// when it is asked about, never while drawing.
class DepthTiles {
  public:
    static constexpr int side = 8;

    /// Starts with nothing drawn.
    void begin(int width, int height) {
        columns_ = (width + side - 1) / side;
        farthest_.assign(std::size_t(columns_) * std::size_t((height + side - 1) / side), nothing);
    }

    /// The same again, where nothing was drawn but in a rectangle.
    void clear(const SampleRect& drawn) {
        if (drawn.is_empty()) return;
        for (int row = drawn.y0 / side; row <= (drawn.y1 - 1) / side; ++row) {
            float* tile = farthest_.data() + std::size_t(row) * std::size_t(columns_);
            std::fill(tile + drawn.x0 / side, tile + (drawn.x1 - 1) / side + 1, nothing);
        }
    }

    /// Is every sample of the tiles that touch a rectangle (ends included, inside the picture) nearer than q?
    /// farthest(left, top, right, bottom), half open and possibly beyond the picture, gives the least q of its samples,
    /// or the first that is not larger than q: most queries fail there.
    template <class Farthest>
    bool all_nearer(int x0, int y0, int x1, int y1, float q, Farthest&& farthest) {
        for (int row = y0 / side; row <= y1 / side; ++row) {
            float* tile = farthest_.data() + std::size_t(row) * std::size_t(columns_);
            for (int column = x0 / side; column <= x1 / side; ++column) {
                if (tile[column] > q) continue;
                const int left = column * side, top = row * side;
                const float least = farthest(left, top, left + side, top + side);
                if (!(least > q)) return false;
                tile[column] = least;
            }
        }
        return true;
    }

  private:
    static constexpr float nothing = -std::numeric_limits<float>::infinity();

    int columns_ = 0;
    std::vector<float> farthest_;  ///< least q
};

}  // namespace farfield::detail
