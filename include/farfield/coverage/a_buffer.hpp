// What lazy masks remember within a frame: the fragments of surfaces that each cell and each mask shows (L. Carpenter,
// "The A-buffer, an Antialiased Hidden Surface Method", SIGGRAPH 1984), between which depths everything seen in a cell
// lies (Greene 1996, section 6.1), and, for masks that show too many surfaces, depth and color of every sample.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <utility>
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

/// A q for each subcell.
struct alignas(64) SubcellDepths {
    std::array<float, 64> q;
};

/// Nothing of a frame is read before it was written in it, so that begin() clears little. Fragments and deep masks that
/// are no longer seen are used again.
class ABuffer {
  public:
    static constexpr std::uint32_t none = 0xffffffffu;

    /// Subcells of a cell, or samples of a mask, that show one surface. Fragments of one list do not overlap.
    struct Fragment {
        std::uint64_t bits;  ///< never 0
        std::uint32_t surface;
        std::uint32_t next;     ///< or none
        float lowest, highest;  ///< of a mask: bounds of the surface's q over all of its samples
    };

    /// What lies in a cell of level 1 or above. A subcell is vacant, or *whole*: it shows one surface, and whatever is
    /// recorded below is out of date, or refined: the cell, or mask, below knows.
    struct Cell {
        std::uint64_t whole = no_subcells;  ///< the bits of all fragments of the list
        std::uint64_t deep = no_subcells;   ///< of a block: masks that are z-buffered
        std::uint32_t list = none;          ///< the fragments of its whole subcells
    };

    /// The depth of a surface, as it is read most often, and how to see it: flat surfaces, which most are, have nothing
    /// else.
    struct Record {
        DepthPlane depth;  ///< no sample is farther
        std::uint32_t details = none;
    };

    void begin(const CoveragePyramid& pyramid) {
        farthest_.resize(pyramid.size());
        nearest_.resize(pyramid.size());
        cells_.resize(pyramid.size());
        lists_.resize(64 * pyramid.block_count());
        const bool is_one_block = pyramid.size() == 1;
        for (std::size_t cell = is_one_block ? 0 : pyramid.block_count(); cell < pyramid.size(); ++cell) {
            open(cell, pyramid.inside(cell));
        }
        surface_count_ = details_count_ = fragment_count_ = deep_count_ = 0;
        free_fragments_ = free_deep_ = none;
    }

    /// Resets a cell of level 1 or above, into which nothing has been drawn. `inside`: its subcells inside the image.
    void open(std::size_t cell, std::uint64_t inside) {
        cells_[cell] = {};
        if (inside != all_subcells) farthest_[cell].q.fill(std::numeric_limits<float>::infinity());
    }
    /// Bounds of q over all that is seen in each subcell of a cell. Where it is vacant they are not valid, and where it
    /// lies beyond the image the farthest is infinity.
    SubcellDepths& farthest(std::size_t cell) { return farthest_[cell]; }
    SubcellDepths& nearest(std::size_t cell) { return nearest_[cell]; }

    Cell& cell(std::size_t cell) { return cells_[cell]; }
    const Cell& cell(std::size_t cell) const { return cells_[cell]; }
    /// The fragments of mask `at` of samples, 64 * block + subcell, or its DeepMask if z-buffered. Valid where the
    /// block says that the mask is refined.
    std::uint32_t& list(std::size_t at) { return lists_[at]; }
    std::uint32_t list(std::size_t at) const { return lists_[at]; }

    // --- surfaces

    std::uint32_t add(const Surface& surface) {
        if (surface_count_ == colors_.size()) {
            const std::size_t more = 2 * colors_.size() + 64;
            records_.resize(more);
            colors_.resize(more);  // last: it tells for how many there is room
        }
        std::uint32_t details = none;
        if (!surface.is_flat || surface.fold.thickness != 0) {
            if (details_count_ == details_.size()) details_.resize(2 * details_.size() + 64);
            details_[details_count_] = surface;
            details = details_count_++;
        }
        records_[surface_count_] = {surface.farthest_depth(), details};
        // What deposits cover once they are closed adds no color.
        colors_[surface_count_] = surface.is_deposit() ? Rgba8{0, 0, 0, 0} : surface.seen_color();
        return surface_count_++;
    }
    const Record& record(std::uint32_t surface) const { return records_[surface]; }
    /// What a surface that is flat looks like.
    Rgba8 color(std::uint32_t surface) const { return colors_[surface]; }
    /// The surface that was added; null for one that is flat and plane.
    Surface* details(std::uint32_t surface) {
        const std::uint32_t index = records_[surface].details;
        return index == none ? nullptr : &details_[index];
    }

    // --- fragments

    /// Makes room for this many more calls of add_fragment().
    void reserve_fragments(std::uint32_t count) {
        if (fragment_count_ + count > fragments_.size()) [[unlikely]]
            grow_fragments(count);
    }
    /// Adds a fragment at the head of a list.
    void add_fragment(std::uint32_t& list, const Fragment& fragment) {
        std::uint32_t at = free_fragments_;
        if (at != none) {
            free_fragments_ = fragments_[at].next;
        } else {
            at = fragment_count_++;
        }
        fragments_[at] = fragment;
        fragments_[at].next = list;
        list = at;
    }
    Fragment& fragment(std::uint32_t index) { return fragments_[index]; }
    const Fragment& fragment(std::uint32_t index) const { return fragments_[index]; }
    /// Takes the fragment away that `link`, the head of a list or the `next` of another one, leads to.
    void unlink(std::uint32_t& link) {
        const std::uint32_t at = link;
        link = fragments_[at].next;
        fragments_[at].next = free_fragments_;
        free_fragments_ = at;
    }
    /// Takes bits away from all fragments of a list, and calls left(fragment) for those that keep some.
    template <class Left>
    void take(std::uint32_t& list, std::uint64_t bits, Left&& left) {
        for (std::uint32_t* link = &list; *link != none;) {
            Fragment& f = fragments_[*link];
            f.bits &= ~bits;
            if (f.bits == 0) {
                unlink(*link);
                continue;
            }
            left(std::as_const(f));
            link = &f.next;
        }
    }
    /// The surface that is seen in subcell k of a cell, which is whole.
    std::uint32_t surface_of_whole(std::size_t cell, unsigned k) const {
        std::uint32_t at = cells_[cell].list;
        while ((fragments_[at].bits >> k & 1) == 0) at = fragments_[at].next;
        return fragments_[at].surface;
    }
    /// Makes subcell k, which is whole, so no longer. Returns the surface that was seen there.
    std::uint32_t part_of_whole(std::size_t cell, unsigned k) {
        const std::uint64_t bit = std::uint64_t(1) << k;
        std::uint32_t* link = &cells_[cell].list;
        while ((fragments_[*link].bits & bit) == 0) link = &fragments_[*link].next;
        Fragment& f = fragments_[*link];
        const std::uint32_t surface = f.surface;
        f.bits &= ~bit;
        if (f.bits == 0) unlink(*link);
        cells_[cell].whole &= ~bit;
        return surface;
    }

    // --- z-buffered masks

    DeepMask& deep(std::size_t at) { return deep_[lists_[at] / chunk][lists_[at] % chunk]; }
    /// Makes a mask one, not filled in. What its list was is lost.
    DeepMask& make_deep(std::size_t at) {
        std::uint32_t index = free_deep_;
        if (index != none) {
            free_deep_ = deep_next_[index];
        } else {
            index = deep_count_;
            if (index == deep_next_.size()) {
                deep_.push_back(std::make_unique<DeepMask[]>(chunk));
                deep_next_.resize(deep_.size() * chunk);
            }
            ++deep_count_;
        }
        lists_[at] = index;
        return deep(at);
    }
    /// Gives back what make_deep() took.
    void release_deep(std::size_t at) {
        deep_next_[lists_[at]] = free_deep_;
        free_deep_ = lists_[at];
    }

  private:
    static constexpr std::uint32_t chunk = 256;

    [[gnu::noinline]] void grow_fragments(std::uint32_t count) { fragments_.resize(2 * fragments_.size() + count); }

    std::vector<SubcellDepths> farthest_, nearest_;
    std::vector<Cell> cells_;
    std::vector<std::uint32_t> lists_;
    std::vector<Record> records_;  ///< by surface
    std::vector<Rgba8> colors_;    ///< by surface
    std::vector<Surface> details_;
    std::vector<Fragment> fragments_;
    std::uint32_t surface_count_ = 0, details_count_ = 0, fragment_count_ = 0, deep_count_ = 0;  ///< in use
    std::uint32_t free_fragments_ = none, free_deep_ = none;
    std::vector<std::unique_ptr<DeepMask[]>> deep_;
    std::vector<std::uint32_t> deep_next_;  ///< of those that were given back
};

}  // namespace farfield::detail
