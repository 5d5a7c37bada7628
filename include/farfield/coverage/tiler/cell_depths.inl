// Depth in cells of the pyramid: q of the farthest thing that is seen in each subcell, and whether a polygon or a box
// lies behind that. Lazy z-buffering needs it (Greene 1996, section 6.1), because covered things may still turn out to
// be hidden. Compiled once for each instruction set: see coverage_tiler.inl.

/// The range of a plane's q over the samples of each subcell. Sums are monotonic, rounding included, so these are
/// exactly the least and the greatest value that DepthPlane::at gives for those samples.
struct Extremes {
    alignas(32) float low_columns[8], high_columns[8];
    float low_rows[8], high_rows[8];

    void find(const DepthPlane& d, int x0, int y0, int step) {
        const int low_x = d.by_x > 0 ? 0 : step - 1, low_y = d.by_y > 0 ? 0 : step - 1;
        // The same as DepthPlane's row() and column(), eight at a time.
        const auto at = MaskKernel::EightFloats{0, 1, 2, 3, 4, 5, 6, 7} * float(step);
        auto q = d.by_x * (at + float(x0 + low_x) + d.base_x);
        __builtin_memcpy(low_columns, &q, sizeof q);
        q = d.by_x * (at + float(x0 + step - 1 - low_x) + d.base_x);
        __builtin_memcpy(high_columns, &q, sizeof q);
        q = d.at_corner + d.by_y * (at + float(y0 + low_y) + d.base_y);
        __builtin_memcpy(low_rows, &q, sizeof q);
        q = d.at_corner + d.by_y * (at + float(y0 + step - 1 - low_y) + d.base_y);
        __builtin_memcpy(high_rows, &q, sizeof q);
    }
};

/// Lazy mode, for something whose q is, at each sample, at most that of any of its planes: a polygon has one plane, a
/// box its fronts.
template <class Target>
class LazyCells {
  public:
    /// `thickness`: how much less than the one plane's its q may be.
    LazyCells(Target& target, const DepthPlane* planes, int plane_count, float thickness = 0)
        : target_(target),
          pyramid_(target.pyramid),
          planes_(planes),
          plane_count_(plane_count),
          thickness_(thickness) {}

    /// Keeps the surface, which is about to be drawn; forget() takes that back if nothing of it was.
    void add(const Surface& surface) { index_ = target_.lazy.add(surface); }
    void forget() { target_.lazy.forget_last_surface(); }
    std::uint32_t surface_index() const { return index_; }

    // --- whether it lies behind all that is seen

    /// The subcells of a cell in which it does. Bits of vacant subcells mean nothing.
    std::uint64_t behind(std::size_t cell, int level, int x, int y) const {
        return behind(level, x, y, target_.lazy.farthest(cell).q.data());
    }
    /// The same for one plane and some subcells; also finds the plane's extremes in the cell.
    std::uint64_t behind(std::uint64_t subcells, std::size_t cell, int level, int x, int y, Extremes& extremes) const {
        find_own_extremes(level, x, y, extremes);
        if (subcells == 0) return all_subcells;
        return MaskKernel::plane_below(extremes.high_rows, extremes.high_columns, planes_->lowest, planes_->highest,
                                       target_.lazy.farthest(cell).q.data());
    }
    /// The same for a few masks of a block.
    std::uint64_t few_behind(std::uint64_t masks, std::size_t block, int x, int y, Extremes& extremes) const {
        const DepthPlane& d = *planes_;
        find_own_extremes(1, x, y, extremes);
        const float* farthest = target_.lazy.farthest(block).q.data();
        std::uint64_t behind = 0;
        for (std::uint64_t left = masks; left != 0; left &= left - 1) {
            const auto k = unsigned(std::countr_zero(left));
            const float most = d.inside(extremes.high_rows[k / 8] + extremes.high_columns[k % 8]);
            behind |= std::uint64_t(most < farthest[k]) << k;
        }
        return behind;
    }
    std::uint64_t few_behind(std::uint64_t masks, std::size_t block, int x, int y) const {
        const float* farthest = target_.lazy.farthest(block).q.data();
        std::uint64_t behind = masks & MaskKernel::greater(farthest, planes_->highest);
        for (std::uint64_t left = masks & ~behind; left != 0; left &= left - 1) {
            const auto k = unsigned(std::countr_zero(left));
            if (is_behind(1, 8 * x + int(k % 8), 8 * y + int(k / 8), farthest[k])) behind |= bit_of(k);
        }
        return behind;
    }
    /// The same for subcell k of a cell, which is (x, y) among all of its level, 8^level samples a side.
    bool is_behind(std::size_t cell, unsigned k, int level, int x, int y) const {
        return is_behind(level, x, y, target_.lazy.farthest(cell).q[k]);
    }
    /// The subcells of a cell in which it lies behind one surface that covers the whole cell.
    std::uint64_t behind_surface(const DepthPlane& one, int level, int x, int y) const {
        Extremes extremes;
        find_extremes(one, level, x, y, extremes);
        SubcellDepths farthest;
        for (unsigned k = 0; k < 64; ++k) {
            farthest.q[k] = one.inside(extremes.low_rows[k / 8] + extremes.low_columns[k % 8]);
        }
        return behind(level, x, y, farthest.q.data());
    }

    // --- what is known

    /// Resets a block into which nothing has been drawn.
    void open(std::size_t block) { target_.lazy.open(block); }
    /// Records that its one plane is seen in some subcells.
    void lower(std::size_t cell, std::uint64_t subcells, const Extremes& extremes) {
        lower(*planes_, cell, subcells, extremes);
    }
    /// Records that it is seen somewhere in subcell k, not known where.
    void lower_somewhere(std::size_t cell, unsigned k) {
        float& farthest = target_.lazy.farthest(cell).q[k];
        farthest = std::min(farthest, planes_->lowest);
    }
    /// The farthest thing of a subcell may have been hidden since; if its cell is covered, that knows the depth better.
    void raise(std::size_t parent, unsigned k, std::size_t cell) {
        if (!pyramid_.is_covered(cell) || target_.lazy.block(cell).covered_by != LazyDepth::none) return;
        const auto& q = target_.lazy.farthest(cell).q;
        MaskKernel::EightFloats least, next;
        __builtin_memcpy(&least, q.data(), sizeof least);
        for (unsigned j = 1; j < 8; ++j) {
            __builtin_memcpy(&next, q.data() + 8 * j, sizeof next);
            least = next < least ? next : least;
        }
        target_.lazy.farthest(parent).q[k] = MaskKernel::least_of(least);
    }

    // --- cells that one surface has covered all at once

    /// Records that this surface covers the cell.
    void cover(std::size_t cell) { target_.lazy.block(cell).covered_by = index_; }
    /// The plane of the surface that covered the cell, or null if none has.
    const DepthPlane* cover_of(std::size_t cell) const {
        const std::uint32_t index = target_.lazy.block(cell).covered_by;
        return index == LazyDepth::none ? nullptr : &target_.lazy.depth(index);
    }
    /// Whether the cell has no record of its own: one surface covered it at once, or nothing has been drawn there.
    bool is_covered_by_one(std::size_t cell) const {
        return target_.lazy.block(cell).covered_by != LazyDepth::none || pyramid_.is_untouched(cell);
    }
    /// Passes the surface that covered a cell all at once to the cells below.
    void push_down(int level, int x, int y) {
        const std::size_t cell = pyramid_.index(level, x, y);
        const std::uint32_t index = target_.lazy.block(cell).covered_by;
        if (index != LazyDepth::none) push_down(cell, level, x, y, index);
    }

  private:
    [[gnu::noinline]] void push_down(std::size_t cell, int level, int x, int y, std::uint32_t index) {
        target_.lazy.open(cell);
        pyramid_[cell] = {all_subcells, no_subcells};
        const std::uint64_t inside = pyramid_.inside(cell);
        Extremes extremes;
        find_extremes(target_.lazy.depth(index), level, x, y, extremes);
        lower(target_.lazy.depth(index), cell, inside, extremes);
        for (std::uint64_t left = level > 1 ? inside : 0; left != 0; left &= left - 1) {
            const auto k = unsigned(std::countr_zero(left));
            target_.lazy.block(pyramid_.index(level - 1, 8 * x + int(k % 8), 8 * y + int(k / 8))).covered_by = index;
        }
        if (level == 1) {
            target_.samples.split_block(target_.block_at(x, y), inside, target_.lazy.surface(index));
            target_.lazy.reserve_fragments(1);
            target_.lazy.add_fragment(target_.lazy.block(cell).whole_masks, inside, index);
        }
    }

    bool is_behind(int level, int x, int y, float farthest) const {
        const int step = 1 << 3 * level, first_x = x * step + target_.first_x, first_y = y * step + target_.first_y;
        for (const DepthPlane* d = planes_; d != planes_ + plane_count_; ++d) {
            const float row = d->row(d->by_y > 0 ? first_y + step - 1 : first_y);
            if (d->at(row, d->by_x > 0 ? first_x + step - 1 : first_x) < farthest) return true;
        }
        return false;
    }
    /// A ray enters a box only behind the last of its fronts, so any front may hide it.
    std::uint64_t behind(int level, int x, int y, const float* farthest) const {
        std::uint64_t behind = 0;
        for (const DepthPlane* d = planes_; d != planes_ + plane_count_; ++d) {
            Extremes extremes;
            find_extremes(*d, level, x, y, extremes);
            behind |=
                MaskKernel::plane_below(extremes.high_rows, extremes.high_columns, d->lowest, d->highest, farthest);
        }
        return behind;
    }
    void find_extremes(const DepthPlane& d, int level, int x, int y, Extremes& extremes) const {
        const int step = 1 << 3 * level;
        extremes.find(d, x * 8 * step + target_.first_x, y * 8 * step + target_.first_y, step);
    }
    void find_own_extremes(int level, int x, int y, Extremes& extremes) const {
        find_extremes(*planes_, level, x, y, extremes);
        if (thickness_ == 0) return;
        for (float& row : extremes.low_rows) row -= thickness_;
    }
    void lower(const DepthPlane& d, std::size_t cell, std::uint64_t subcells, const Extremes& extremes) {
        MaskKernel::lower(subcells, extremes.low_rows, extremes.low_columns, d.lowest, d.highest,
                          target_.lazy.farthest(cell).q.data());
    }

    Target& target_;
    CoveragePyramid& pyramid_;
    const DepthPlane* planes_;
    int plane_count_;
    float thickness_;
    std::uint32_t index_ = 0;  ///< the surface's
};

/// Strict mode: front to back, covered subcells hide whatever comes, and nothing else is known.
template <class Target>
class StrictCells {
  public:
    StrictCells(Target& target, const DepthPlane*, int, float = 0) : pyramid_(target.pyramid) {}

    void add(const Surface&) {}
    void forget() {}
    std::uint64_t behind(std::size_t, int, int, int) const { return all_subcells; }
    std::uint64_t behind(std::uint64_t, std::size_t, int, int, int, Extremes&) const { return all_subcells; }
    std::uint64_t few_behind(std::uint64_t, std::size_t, int, int, Extremes&) const { return all_subcells; }
    std::uint64_t few_behind(std::uint64_t, std::size_t, int, int) const { return all_subcells; }
    bool is_behind(std::size_t, unsigned, int, int, int) const { return true; }
    std::uint64_t behind_surface(const DepthPlane&, int, int, int) const { return all_subcells; }
    void open(std::size_t) {}
    void lower(std::size_t, std::uint64_t, const Extremes&) {}
    void lower_somewhere(std::size_t, unsigned) {}
    void raise(std::size_t, unsigned, std::size_t) {}
    void cover(std::size_t) {}
    const DepthPlane* cover_of(std::size_t) const { return nullptr; }
    bool is_covered_by_one(std::size_t cell) const { return pyramid_.is_untouched(cell); }
    void push_down(int, int, int) {}

  private:
    const CoveragePyramid& pyramid_;
};

template <class Target>
using CellDepths = std::conditional_t<Target::is_lazy, LazyCells<Target>, StrictCells<Target>>;
