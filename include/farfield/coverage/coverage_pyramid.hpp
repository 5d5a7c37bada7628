// The image-space hierarchy that remembers what has been tiled: "a hierarchical representation of the screen with the
// C and V bits for each subcell in the triage masks" (Greene 1996, section 4.1 and figure 2).
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "farfield/coverage/triage_mask.hpp"
#include "farfield/raster/made_for.hpp"

namespace farfield {

/// Level 0 has one conventional mask of 8 x 8 samples a cell, level k > 0 one triage mask of 8 x 8 cells of level
/// k - 1, and the last level is one cell. Images may have any size: subcells beyond the border are covered from the
/// start. This takes 1 2/63 bits a sample where sides are powers of 8; borders are padded to 8 x 8 masks.
///
/// Clearing is lazy: begin() sets triage masks alone, one bit in 32; a mask of samples is ignored as long as the triage
/// mask above it says vacant.
class CoveragePyramid {
  public:
    /// Sides must be 1 sample or more.
    void begin(int width_samples, int height_samples) {
        made_for_({width_samples, height_samples}, [&] { resize(width_samples, height_samples); });
        cells_ = initial_;
    }

    int width_samples() const { return width_; }
    int height_samples() const { return height_; }
    /// The level that is one cell; 1 or more.
    int top_level() const { return int(levels_.size()); }
    /// The columns and rows of cells of a level.
    int columns(int level) const { return int((unsigned(width_) + (8u << 3 * level) - 1) >> 3 * (level + 1)); }
    int rows(int level) const { return int((unsigned(height_) + (8u << 3 * level) - 1) >> 3 * (level + 1)); }

    /// The index of a cell of level 1 or above; cells that adjoin in a row have consecutive ones.
    std::size_t index(int level, int x, int y) const {
        const Level& l = levels_[std::size_t(level - 1)];
        return l.first + std::size_t(y) * l.columns + std::size_t(x);
    }
    TriageMask& operator[](std::size_t cell) { return cells_[cell]; }
    const TriageMask& operator[](std::size_t cell) const { return cells_[cell]; }
    /// The number of cells of levels 1 and above.
    std::size_t size() const { return cells_.size(); }
    /// The number of cells of level 1, which come first: the *blocks* of 8 x 8 masks of samples.
    std::size_t block_count() const { return levels_.empty() ? 0 : levels_[0].columns * levels_[0].rows; }

    /// The 64 masks of samples of a block, valid where the block does not say vacant.
    std::uint64_t* samples_of_block(std::size_t block) { return samples_.data() + 64 * block; }
    const std::uint64_t* samples_of_block(std::size_t block) const { return samples_.data() + 64 * block; }
    /// The initial value of the mask of samples (x, y) of level 0: samples beyond the border are set.
    std::uint64_t samples_outside(int x, int y) const { return is_ragged_ ? outside(0, x, y) : no_subcells; }

    /// Whether the cell's subcells are unchanged in this frame.
    bool is_untouched(std::size_t cell) const {
        return cells_[cell].vacant == all_subcells || cells_[cell] == initial_[cell];
    }
    /// The subcells inside the image.
    std::uint64_t inside(std::size_t cell) const { return initial_[cell].vacant; }
    bool is_covered(std::size_t cell) const { return cells_[cell].covered == all_subcells; }
    std::size_t bytes() const { return cells_.size() * sizeof(TriageMask) + samples_.size() * sizeof(std::uint64_t); }

  private:
    struct Level {
        std::size_t first, columns, rows;
    };

    void resize(int width, int height) {
        width_ = width;
        height_ = height;
        is_ragged_ = width % 8 != 0 || height % 8 != 0;
        levels_.clear();
        initial_.clear();
        for (int level = 1; levels_.empty() || levels_.back().columns * levels_.back().rows > 1; ++level) {
            levels_.push_back({initial_.size(), std::size_t(columns(level)), std::size_t(rows(level))});
            for (int y = 0; y < rows(level); ++y) {
                for (int x = 0; x < columns(level); ++x) {
                    const std::uint64_t beyond = outside(level, x, y);
                    initial_.push_back({beyond, ~beyond});
                }
            }
        }
        samples_.assign(64 * block_count(), no_subcells);
    }

    /// The subcells of a cell that lie entirely beyond the border.
    std::uint64_t outside(int level, int x, int y) const {
        const int columns_inside = (level == 0 ? width_ : columns(level - 1)) - 8 * x;
        const int rows_inside = (level == 0 ? height_ : rows(level - 1)) - 8 * y;
        if (columns_inside <= 0 || rows_inside <= 0) return all_subcells;
        return ~subcells_of_rect(0, 0, std::min(columns_inside, 8) - 1, std::min(rows_inside, 8) - 1);
    }

    detail::MadeFor<detail::BufferSize> made_for_;
    int width_ = 0, height_ = 0;
    bool is_ragged_ = false;
    std::vector<Level> levels_;  ///< from level 1 on
    std::vector<TriageMask> cells_, initial_;
    std::vector<std::uint64_t> samples_;
};

}  // namespace farfield
