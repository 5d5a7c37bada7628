// What a polygon does to cells and to masks of samples where polygons come front to back. Compiled once for each
// instruction set: see coverage_tiler.inl.

/// The block of 8 x 8 masks that is being tiled.
struct OpenBlock : MaskBlock {
    TriageMask* cell = nullptr;
    std::uint64_t* masks = nullptr;
    bool drew = false;
    Extremes extremes;  ///< of the polygon, in lazy mode

    void open(CoveragePyramid& pyramid, const MaskBlock& at) {
        static_cast<MaskBlock&>(*this) = at;
        cell = &pyramid[index];
        masks = pyramid.samples_of_block(index);
        drew = false;
    }
    std::uint64_t samples_outside(const CoveragePyramid& pyramid, unsigned k) const {
        return pyramid.samples_outside(8 * x + int(k % 8), 8 * y + int(k / 8));
    }
};

/// Stands for bounds of depth, which strict masks do not need.
struct NoDepthRange {};

/// Strict mode: front to back, masks tell all, and colors are final.
template <class Target>
class StrictMasks {
  protected:
    StrictMasks(Target& target, Surface& surface)
        : target_(target),
          pyramid_(target.pyramid),
          surface_(surface),
          depths_(target, &surface.depth, 1, surface.fold.thickness) {}

    // --- cells

    /// Those subcells of a cell, all inside the polygon, that it covers at once.
    std::uint64_t taken(std::uint64_t inside, std::size_t cell, const Extremes&) const {
        return inside & pyramid_[cell].vacant;
    }
    void cover(std::size_t cell, int level, int x, int y, std::uint64_t subcells, const Extremes&) {
        pyramid_[cell].covered |= subcells;
        pyramid_[cell].vacant &= ~subcells;
        for (; subcells != 0; subcells &= subcells - 1) {
            const auto k = unsigned(std::countr_zero(subcells));
            cover_cell(level - 1, 8 * x + int(k % 8), 8 * y + int(k / 8));
        }
    }
    /// Prepares subcell k for being tiled.
    void refine(std::size_t, unsigned, int, int, int) {}
    /// Records that something was drawn into subcell k, which is this cell.
    void drew_in(std::size_t parent, unsigned k, std::size_t cell, const Extremes&) { tell(parent, k, cell); }
    void drew_somewhere_in(std::size_t parent, unsigned k, std::size_t cell) { tell(parent, k, cell); }

    // --- masks

    void open_block(const MaskBlock& at) {
        block_.open(pyramid_, at);
        is_untouched_ = pyramid_.is_untouched(at.index);
    }
    /// Covers an untouched block, if all its masks are `whole`.
    bool cover_block(std::uint64_t whole) {
        if (!is_untouched_ || whole != block_.cell->vacant) return false;
        cover_cell(1, block_.x, block_.y);
        *block_.cell = {all_subcells, no_subcells};
        return true;
    }
    void begin_masks() {
        if (is_untouched_) target_.samples.open_block(block_);
    }
    void cover_masks(std::uint64_t whole) {
        target_.samples.template cover_masks<MaskKernel>(block_, whole, surface_);
        block_.cell->covered |= whole;
        block_.cell->vacant &= ~whole;
        block_.drew = true;
    }
    /// What of depth a mask needs to know.
    NoDepthRange depths_in(unsigned) const { return {}; }
    NoDepthRange depths_of_all() const { return {}; }
    /// "W = P & ~C; C' = C | P" (section 3), for some masks: of mask k, inside_of(k) is P. Each is tiled only once.
    template <class InsideOf, class Depths>
    FARFIELD_INLINE void tile_masks(std::uint64_t masks, InsideOf&& inside_of, Depths&&) {
        const std::uint64_t vacant = block_.cell->vacant;
        std::uint64_t touched = 0, full = 0;
        const auto tile = [&](unsigned k, std::uint64_t covered, bool is_vacant) {
            const std::uint64_t seen = inside_of(k) & ~covered;
            if (seen == 0) return;
            touched |= bit_of(k);
            block_.masks[k] = covered | seen;
            full |= std::uint64_t((covered | seen) == all_subcells) << k;
            target_.samples.template add<MaskKernel>(block_, k, seen, MaskKernel::count(seen), surface_, is_vacant);
        };
        // Vacant ones apart: what they hold is not read, and neither branches on it.
        for (std::uint64_t left = masks & vacant; left != 0; left &= left - 1) {
            const auto k = unsigned(std::countr_zero(left));
            tile(k, block_.samples_outside(pyramid_, k), true);
        }
        for (std::uint64_t left = masks & ~vacant; left != 0; left &= left - 1) {
            const auto k = unsigned(std::countr_zero(left));
            tile(k, block_.masks[k], false);
        }
        if (touched == 0) return;
        block_.drew = true;
        block_.cell->vacant = vacant & ~touched;
        block_.cell->covered |= full;
    }

    Target& target_;
    CoveragePyramid& pyramid_;
    Surface& surface_;
    CellDepths<Target> depths_;
    OpenBlock block_;

  private:
    void tell(std::size_t parent, unsigned k, std::size_t cell) {
        pyramid_[parent].vacant &= ~bit_of(k);
        if (pyramid_.is_covered(cell)) pyramid_[parent].covered |= bit_of(k);
    }
    /// Covers all samples of a vacant cell.
    void cover_cell(int level, int x, int y) {
        target_.for_blocks(level, x, y, [&](const MaskBlock& block) {
            target_.samples.template cover_block<MaskKernel>(block, pyramid_.inside(block.index), surface_);
        });
    }

    bool is_untouched_ = false;
};
