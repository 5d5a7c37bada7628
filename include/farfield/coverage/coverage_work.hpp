// Measures the work of tiling: cells of the pyramid visited, as a number or as a picture.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "farfield/coverage/coverage_pyramid.hpp"

namespace farfield {

/// Counts one frame's work. Cells are those of the pyramid, masks of samples included; samples and the background's
/// visits are not counted.
struct CoverageWork {
    std::uint64_t polygons_tiled = 0;    ///< neither hidden by their bounding box nor without a sample
    std::uint64_t cells_tiled = 0;       ///< visited for polygons
    std::uint64_t cells_asked = 0;       ///< visited to find whether a box is hidden
    std::uint64_t masks_z_buffered = 0;  ///< because polygons did not come front to back

    CoverageWork& operator+=(const CoverageWork& other) {
        polygons_tiled += other.polygons_tiled;
        cells_tiled += other.cells_tiled;
        cells_asked += other.cells_asked;
        masks_z_buffered += other.masks_z_buffered;
        return *this;
    }

    void begin(const CoveragePyramid&) { *this = {}; }
    void tiles(int, int, int) { ++cells_tiled; }
    void asks(int, int, int) { ++cells_asked; }
    void tiles_masks(int, int, std::uint64_t, int count) { cells_tiled += std::uint64_t(count); }
};

/// Also keeps "work images that show the number of times during frame generation that each cell in the
/// coverage pyramid is visited, with an access to a coarser-than-pixel cell being amortized over the corresponding
/// window of the screen" (Greene 1996, section 9 and figure 3).
class CoverageWorkImage : public CoverageWork {
  public:
    void begin(const CoveragePyramid& pyramid) {
        CoverageWork::begin(pyramid);
        columns_ = std::size_t(pyramid.columns(0));
        rows_ = std::size_t(pyramid.rows(0));
        for (auto& kind : visits_) kind.assign(columns_ * rows_, 0.0f);
    }
    void tiles(int level, int x, int y) {
        CoverageWork::tiles(level, x, y);
        amortize(visits_[0], level, x, y);
    }
    void asks(int level, int x, int y) {
        CoverageWork::asks(level, x, y);
        amortize(visits_[1], level, x, y);
    }
    /// Adds masks of block (x, y) of level 1.
    void tiles_masks(int x, int y, std::uint64_t masks, int count) {
        CoverageWork::tiles_masks(x, y, masks, count);
        for (; masks != 0; masks &= masks - 1) {
            const int k = std::countr_zero(masks);
            amortize(visits_[0], 0, 8 * x + k % 8, 8 * y + k / 8);
        }
    }

    /// Visits by mask of samples, row by row; with 64 samples a pixel, by pixel. Sums are cells_tiled and cells_asked.
    const std::vector<float>& tiled() const { return visits_[0]; }
    const std::vector<float>& asked() const { return visits_[1]; }
    int columns() const { return int(columns_); }
    int rows() const { return int(rows_); }

  private:
    void amortize(std::vector<float>& visits, int level, int x, int y) const {
        const auto x0 = std::size_t(x) << 3 * level, y0 = std::size_t(y) << 3 * level;
        const std::size_t x1 = std::min(columns_, x0 + (std::size_t(1) << 3 * level));
        const std::size_t y1 = std::min(rows_, y0 + (std::size_t(1) << 3 * level));
        const float share = 1.0f / (float(x1 - x0) * float(y1 - y0));
        for (std::size_t j = y0; j < y1; ++j) {
            for (std::size_t i = x0; i < x1; ++i) visits[j * columns_ + i] += share;
        }
    }

    std::size_t columns_ = 0, rows_ = 0;
    std::array<std::vector<float>, 2> visits_;
};

}  // namespace farfield
