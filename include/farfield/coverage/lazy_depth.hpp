// The memory of lazy z-buffering within a frame (Greene 1996, section 6.1): the farthest depth drawn in each cell, the
// fragments that make up each pixel, and depth and color of every sample of those pixels where polygons did not come
// front to back.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "farfield/coverage/coverage_pyramid.hpp"
#include "farfield/coverage/polygons/surface.hpp"

namespace farfield {

/// "Reverting to ordinary z-buffering, allocating the memory required for storing color and depth at each subpixel
/// sample": 512 bytes. Valid for samples that are covered.
struct alignas(64) DeepMask {
    std::array<float, 64> q;
    std::array<Rgba8, 64> color;
};

}  // namespace farfield

namespace farfield::detail {

/// A q for each subcell; infinity where there is nothing.
struct alignas(64) SubcellDepths {
    std::array<float, 64> q;
    void clear() { q.fill(std::numeric_limits<float>::infinity()); }
};

class LazyDepth {
  public:
    static constexpr std::uint32_t none = 0xffffffffu;

    /// Some samples of a mask, or some masks of a block, that show one surface. Fragments of one list do not overlap.
    struct Fragment {
        std::uint64_t bits;
        std::uint32_t surface;
        std::uint32_t next;  ///< or none
    };

    /// The record of what was drawn into a block once it is opened.
    struct Block {
        std::uint64_t deep = no_subcells;  ///< masks that are z-buffered
        std::uint32_t whole_masks = none;  ///< fragments of surfaces that covered masks all at once
        std::uint32_t covered_by = none;   ///< surface that covered all of the cell at once; the rest is then not valid
    };

    void begin(const CoveragePyramid& pyramid) {
        farthest_.resize(pyramid.size());
        cells_.resize(pyramid.size());
        histories_.resize(64 * pyramid.block_count());
        const bool is_one_block = pyramid.size() == 1;
        for (std::size_t cell = is_one_block ? 0 : pyramid.block_count(); cell < pyramid.size(); ++cell) open(cell);
        surface_count_ = 0;
        fragment_count_ = 0;
        deep_places_.clear();
    }

    /// Resets a cell of level 1 or above, into which nothing has been drawn.
    void open(std::size_t cell) {
        farthest_[cell].clear();
        cells_[cell] = {};
    }
    /// A lower bound of q over all that is seen in each subcell of a cell.
    SubcellDepths& farthest(std::size_t cell) { return farthest_[cell]; }
    /// The record of a cell; above blocks only covered_by is used.
    Block& block(std::size_t cell) { return cells_[cell]; }
    const Block& block(std::size_t cell) const { return cells_[cell]; }
    /// The first fragment of mask `at` of samples, 64 * block + subcell, or its DeepMask if z-buffered.
    std::uint32_t& history(std::size_t at) { return histories_[at]; }
    std::uint32_t history(std::size_t at) const { return histories_[at]; }

    std::uint32_t add(const Surface& surface) {
        if (surface_count_ == surfaces_.size()) {
            const std::size_t more = 2 * surfaces_.size() + 64;
            depths_.resize(more);
            surfaces_.resize(more);  // last: it tells for how many there is room
        }
        surfaces_[surface_count_] = surface;
        depths_[surface_count_] = surface.farthest_depth();
        return surface_count_++;
    }
    void forget_last_surface() { --surface_count_; }
    const Surface& surface(std::uint32_t index) const { return surfaces_[index]; }
    /// The farthest depth of a surface, kept apart: it is read far more often and is an eighth of the size.
    const DepthPlane& depth(std::uint32_t index) const { return depths_[index]; }

    /// Makes room for this many more calls of add_fragment().
    void reserve_fragments(std::uint32_t count) {
        if (fragment_count_ + count > fragments_.size()) [[unlikely]]
            grow_fragments(count);
    }
    /// Adds a fragment at the head of a list.
    void add_fragment(std::uint32_t& list, std::uint64_t bits, std::uint32_t surface) {
        fragments_[fragment_count_] = {bits, surface, list};
        list = fragment_count_++;
    }
    const Fragment& fragment(std::uint32_t index) const { return fragments_[index]; }

    DeepMask& deep(std::size_t at) { return deep_[histories_[at] / chunk][histories_[at] % chunk]; }
    /// Makes a new mask, not filled in. Its history is lost.
    DeepMask& make_deep(std::size_t at) {
        const std::size_t index = deep_places_.size();
        if (index / chunk == deep_.size()) deep_.push_back(std::make_unique<DeepMask[]>(chunk));
        histories_[at] = std::uint32_t(index);
        deep_places_.push_back(at);
        return deep(at);
    }
    /// The masks that are z-buffered, as history() takes them.
    const std::vector<std::size_t>& deep_places() const { return deep_places_; }

  private:
    static constexpr std::uint32_t chunk = 256;

    [[gnu::noinline]] void grow_fragments(std::uint32_t count) { fragments_.resize(2 * fragments_.size() + count); }

    std::vector<SubcellDepths> farthest_;
    std::vector<Block> cells_;
    std::vector<std::uint32_t> histories_;
    std::vector<Surface> surfaces_;
    std::vector<DepthPlane> depths_;  ///< by surface
    std::vector<Fragment> fragments_;
    std::uint32_t surface_count_ = 0, fragment_count_ = 0;  ///< in use
    std::vector<std::unique_ptr<DeepMask[]>> deep_;
    std::vector<std::size_t> deep_places_;
};

}  // namespace farfield::detail
