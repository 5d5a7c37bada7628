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
    void raise_highest(float by) {
        for (float& row : high_rows) row += by;
    }
};

/// The cell above another one that was covered all at once, so that nothing below it is told.
struct CoveredAbove {
    int level = 0;  ///< 0: there is none
    bool is_hidden = false;
};

/// Lazy mode, for something whose q is, at each sample, at most that of any of its planes: a polygon has one plane, a
/// box its fronts.
template <class Target>
class LazyCells {
  public:
    /// `thickness`: how much less than the one plane's its q may be.
    LazyCells(Target& target, const DepthPlane* planes, int plane_count, float thickness = 0)
        : target_(target), planes_(planes), plane_count_(plane_count), thickness_(thickness) {}

    // --- whether it lies behind all that is seen

    /// The subcells of a cell in which it does. Bits of vacant subcells mean nothing.
    std::uint64_t behind(std::size_t cell, int level, int x, int y) const {
        return behind(level, x, y, target_.fragments.farthest(cell).q.data());
    }
    /// The same for one plane and some subcells; also finds the plane's extremes in the cell.
    std::uint64_t behind(std::uint64_t subcells, std::size_t cell, int level, int x, int y, Extremes& extremes) const {
        find_own_extremes(level, x, y, extremes);
        if (subcells == 0) return all_subcells;
        return MaskKernel::plane_below(extremes.high_rows, extremes.high_columns, planes_->lowest, planes_->highest,
                                       target_.fragments.farthest(cell).q.data());
    }
    /// The same for a few masks of a block.
    std::uint64_t few_behind(std::uint64_t masks, std::size_t block, int x, int y, Extremes& extremes) const {
        const DepthPlane& d = *planes_;
        find_own_extremes(1, x, y, extremes);
        const float* farthest = target_.fragments.farthest(block).q.data();
        std::uint64_t behind = 0;
        for (std::uint64_t left = masks; left != 0; left &= left - 1) {
            const auto k = unsigned(std::countr_zero(left));
            const float most = d.inside(extremes.high_rows[k / 8] + extremes.high_columns[k % 8]);
            behind |= std::uint64_t(most < farthest[k]) << k;
        }
        return behind;
    }
    std::uint64_t few_behind(std::uint64_t masks, std::size_t block, int x, int y) const {
        const float* farthest = target_.fragments.farthest(block).q.data();
        std::uint64_t behind = masks & MaskKernel::greater(farthest, planes_->highest);
        for (std::uint64_t left = masks & ~behind; left != 0; left &= left - 1) {
            const auto k = unsigned(std::countr_zero(left));
            if (is_behind(1, 8 * x + int(k % 8), 8 * y + int(k / 8), farthest[k])) behind |= bit_of(k);
        }
        return behind;
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

    // --- what covers cells at once

    /// The topmost one above a cell, and whether something lies behind it there.
    CoveredAbove covered_above(int level, int x, int y) const {
        const CoveragePyramid& pyramid = target_.pyramid;
        for (int up = pyramid.top_level(); up > level; --up) {
            const int px = x >> 3 * (up - level - 1), py = y >> 3 * (up - level - 1);
            const std::size_t parent = pyramid.index(up, px >> 3, py >> 3);
            const auto k = unsigned((py & 7) * 8 + (px & 7));
            if (is_whole(parent, k)) return {up, is_behind(up, px, py, target_.fragments.farthest(parent).q[k])};
        }
        return {};
    }
    /// Those of a few masks of a block in which all corners lie behind what is seen.
    std::uint64_t corners_behind(std::uint64_t masks, std::size_t block) const {
        const float* farthest = target_.fragments.farthest(block).q.data();
        std::uint64_t behind = 0;
        for (std::uint64_t left = masks; left != 0; left &= left - 1) {
            const auto k = unsigned(std::countr_zero(left));
            behind |= std::uint64_t(planes_->highest < farthest[k]) << k;
        }
        return behind;
    }

    /// Whether one surface covers subcell k of a cell, so that nothing below is told.
    bool is_whole(std::size_t cell, unsigned k) const { return (target_.fragments.cell(cell).whole >> k & 1) != 0; }
    /// That surface's plane.
    const DepthPlane& cover_of(std::size_t cell, unsigned k) const {
        return target_.fragments.record(target_.fragments.surface_of_whole(cell, k)).depth;
    }

    /// The range of a plane's q in a cell.
    void find_extremes(const DepthPlane& d, int level, int x, int y, Extremes& extremes) const {
        const int step = 1 << 3 * level;
        extremes.find(d, x * 8 * step + target_.first_x, y * 8 * step + target_.first_y, step);
    }

  private:
    /// The same for a subcell of a cell, which is (x, y) among all of its level, 8^level samples a side.
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
    void find_own_extremes(int level, int x, int y, Extremes& extremes) const {
        find_extremes(*planes_, level, x, y, extremes);
        if (thickness_ == 0) return;
        for (float& row : extremes.low_rows) row -= thickness_;
    }

    Target& target_;
    const DepthPlane* planes_;
    int plane_count_;
    float thickness_;
};

/// Strict mode: front to back, covered subcells hide whatever comes, and nothing else is known.
template <class Target>
class StrictCells {
  public:
    StrictCells(Target& target, const DepthPlane*, int, float = 0) : target_(target) {}

    std::uint64_t behind(std::size_t, int, int, int) const { return all_subcells; }
    std::uint64_t behind(std::uint64_t, std::size_t, int, int, int, Extremes&) const { return all_subcells; }
    std::uint64_t few_behind(std::uint64_t, std::size_t, int, int, Extremes&) const { return all_subcells; }
    std::uint64_t few_behind(std::uint64_t, std::size_t, int, int) const { return all_subcells; }
    std::uint64_t behind_surface(const DepthPlane&, int, int, int) const { return all_subcells; }
    CoveredAbove covered_above(int level, int x, int y) const {
        for (int up = level + 1; up <= target_.pyramid.top_level(); ++up, x >>= 3, y >>= 3) {
            const TriageMask& parent = target_.pyramid[target_.pyramid.index(up, x >> 3, y >> 3)];
            if ((parent.covered & bit_of(unsigned((y & 7) * 8 + (x & 7)))) != 0) return {up, true};
        }
        return {};
    }
    std::uint64_t corners_behind(std::uint64_t, std::size_t) const { return all_subcells; }

  private:
    const Target& target_;
};

template <class Target>
using CellDepths = std::conditional_t<Target::is_lazy, LazyCells<Target>, StrictCells<Target>>;
