// Tiling by listing 1 of Greene 1996; compiled once for each instruction set, see coverage_tiler.hpp. There are no
// include guards, here and in the parts; FARFIELD_LANES must be 1, 4, 8 or 16, and the including namespace is for them
// alone.

// Each part needs some of those before it.
// clang-format off
#include "farfield/coverage/tiler/mask_kernel.inl"     // sixty-four comparisons to a mask
#include "farfield/coverage/tiler/tile_edges.inl"      // a polygon's bounding box, its edges, and triage of cells by them
#include "farfield/coverage/tiler/cell_depths.inl"     // whether something lies behind all that is seen in a cell
#include "farfield/coverage/tiler/coverage_query.inl"  // whether anything of a bounding box or a silhouette may be seen
#include "farfield/coverage/tiler/mask_depths.inl"     // depths of the samples of a mask
#include "farfield/coverage/tiler/lazy_masks.inl"      // masks of samples where polygons do not come front to back
// clang-format on

template <class Target>
using BlockMasks = std::conditional_t<Target::is_lazy, LazyMasks<Target>, StrictMasks<Target>>;

/// Recurses from the cells that enclose a polygon down to masks of samples.
template <class Target>
class Tiler : BlockMasks<Target> {
    using Masks = BlockMasks<Target>;
    using Masks::target_, Masks::pyramid_, Masks::surface_, Masks::depths_, Masks::block_;
    using Edges = typename TileEdges<Target>::Edges;
    using Triage = typename TileEdges<Target>::Triage;

  public:
    Tiler(Target& target, TilePolygon& polygon) : Masks(target, polygon.surface), edges_(target, polygon, 0) {}

    bool tile() {
        const bool is_small = Target::masks == MaskSource::exact && edges_.box.spans_few_masks();
        const StartCells<Target> start(target_, edges_.box, depths_, is_small);
        if (start.empty()) return false;
        ++target_.work.polygons_tiled;
        // About half of all polygons are hidden; delay this work.
        if (!surface_.is_flat) surface_.find_gradient();
        edges_.prepare(0);
        if (!is_small) edges_.tabulate();
        depths_.add(surface_);
        bool drew = false;
        for (const StartCell& s : start) {
            if (is_small && s.level == 1) {
                if (!tile_few_masks(s.x, s.y)) continue;
            } else {
                if (is_small) edges_.tabulate();
                const Edges edges = edges_.at(s.level, s.x, s.y);
                if (!(s.level == 1 ? tile_block(s.x, s.y, edges) : tile_cell(s.level, s.x, s.y, edges))) continue;
            }
            tell_parents(s.level, s.x, s.y);
            drew = true;
        }
        if (!drew) depths_.forget();
        return drew;
    }

  private:
    // --- cells

    bool tile_cell(int level, int x, int y, const Edges& in) {
        target_.work.tiles(level, x, y);
        Triage t;
        if (!edges_.triage(level, x, y, in, t)) return false;
        const std::size_t at = pyramid_.index(level, x, y);
        // A reference, because a copy of both words at once would wait for the two stores before it.
        TriageMask& cell = pyramid_[at];
        Extremes extremes;
        const std::uint64_t hidden =
            cell.covered & depths_.behind(t.possible & ~cell.vacant, at, level, x, y, extremes);
        const std::uint64_t whole = surface_.covers_all() ? cell.vacant & t.covered : no_subcells;
        cell.covered |= whole;
        cell.vacant &= ~whole;
        for (std::uint64_t left = whole; left != 0; left &= left - 1) {
            const auto k = unsigned(std::countr_zero(left));
            cover_cell(level - 1, 8 * x + int(k % 8), 8 * y + int(k / 8));
        }
        depths_.lower(at, whole, extremes);
        bool drew = whole != 0;
        for (std::uint64_t left = t.possible & ~(hidden | whole); left != 0; left &= left - 1) {
            const auto k = unsigned(std::countr_zero(left));
            const int child_x = 8 * x + int(k % 8), child_y = 8 * y + int(k / 8);
            if ((cell.vacant >> k & 1) == 0) depths_.push_down(level - 1, child_x, child_y);
            const Edges edges = edges_.inside(t, k, level);
            if (!(level == 2 ? tile_block(child_x, child_y, edges) : tile_cell(level - 1, child_x, child_y, edges))) {
                continue;
            }
            drew = true;
            cell.vacant &= ~bit_of(k);
            const std::size_t child = pyramid_.index(level - 1, child_x, child_y);
            if (pyramid_.is_covered(child)) cell.covered |= bit_of(k);
            depths_.lower(at, bit_of(k), extremes);
            depths_.raise(at, k, child);
        }
        return drew;
    }

    /// Covers all samples of a vacant cell.
    void cover_cell(int level, int x, int y) {
        depths_.cover(pyramid_.index(level, x, y));
        const int shift = 3 * (level - 1);
        const int end_x = std::min((x + 1) << shift, pyramid_.columns(1));
        const int end_y = std::min((y + 1) << shift, pyramid_.rows(1));
        for (int by = y << shift; by < end_y; ++by) {
            for (int bx = x << shift; bx < end_x; ++bx) {
                const MaskBlock block = target_.block_at(bx, by);
                target_.samples.cover_block(block, pyramid_.inside(block.index), surface_);
            }
        }
    }

    /// "Whenever this occurs, we propagate coverage information to coarser levels" (section 3.1).
    void tell_parents(int level, int x, int y) {
        bool is_covered = pyramid_.is_covered(pyramid_.index(level, x, y));
        for (; level < pyramid_.top_level(); ++level, x >>= 3, y >>= 3) {
            const std::size_t parent = pyramid_.index(level + 1, x >> 3, y >> 3);
            const auto k = unsigned((y & 7) * 8 + (x & 7));
            TriageMask& mask = pyramid_[parent];
            if (!Target::is_lazy && !is_covered && (mask.vacant & bit_of(k)) == 0) return;
            depths_.lower_somewhere(parent, k);
            depths_.raise(parent, k, pyramid_.index(level, x, y));
            mask.vacant &= ~bit_of(k);
            if (is_covered) mask.covered |= bit_of(k);
            is_covered = mask.covered == all_subcells;
        }
    }

    // --- masks of samples

    bool tile_block(int x, int y, const Edges& in) {
        target_.work.tiles(1, x, y);
        Triage t;
        if (!edges_.triage(1, x, y, in, t)) return false;
        open_block(x, y);
        TriageMask& cell = *block_.cell;
        block_.behind = depths_.behind(t.possible & ~cell.vacant, block_.index, 1, x, y, block_.extremes);
        const std::uint64_t whole = surface_.covers_all() ? cell.vacant & t.covered : no_subcells;
        const std::uint64_t active = t.possible & ~(cell.covered & block_.behind) & ~whole;
        if ((whole | active) == 0) return false;
        if (block_.is_untouched) {
            // A block that is the whole image has no parent that would know its depth.
            if (whole == cell.vacant && (!Target::is_lazy || pyramid_.top_level() > 1)) {
                cover_cell(1, x, y);
                cell = {all_subcells, no_subcells};
                return true;
            }
            target_.samples.open_block(block_);
        }
        Masks::reserve_fragments();
        if (whole != 0) cover_masks(whole);
        if (active != 0) tile_masks(t, active);
        depths_.lower(block_.index, block_.lowered, block_.extremes);
        return block_.drew;
    }

    /// Tiles all masks that the bounding box touches, each by all edges. The polygon is so small that 32 bits suffice.
    bool tile_few_masks(int x, int y) {
        target_.work.tiles(1, x, y);
        open_block(x, y);
        std::uint64_t active = edges_.box.subcells(1, x, y);
        block_.behind = depths_.few_behind(active, block_.index, x, y, block_.extremes);
        active &= ~(block_.cell->covered & block_.behind);
        if (active == 0) return false;
        if (block_.is_untouched) target_.samples.open_block(block_);
        Masks::reserve_fragments();
        target_.work.tiles_masks(x, y, active, MaskKernel::count(active));
        const auto edges = edges_.few_masks_at(x, y);
        for (std::uint64_t left = active; left != 0; left &= left - 1) {
            const auto k = unsigned(std::countr_zero(left));
            const std::uint64_t inside = edges_.samples_inside(edges, k);
            if (inside != 0) tile_mask(k, inside);
        }
        depths_.lower(block_.index, block_.lowered, block_.extremes);
        return block_.drew;
    }

    void open_block(int x, int y) {
        block_.open(pyramid_, target_.block_at(x, y));
        if (block_.is_untouched) depths_.open(block_.index);
    }

    void cover_masks(std::uint64_t whole) {
        target_.samples.cover_masks(block_, whole, surface_);
        block_.cell->covered |= whole;
        block_.cell->vacant &= ~whole;
        block_.drew = true;
        Masks::add_whole(whole);
    }

    /// Groups masks by how many edges cross them: in large polygons nearly all have one, and in a mesh many have none.
    void tile_masks(const Triage& t, std::uint64_t active) {
        target_.work.tiles_masks(block_.x, block_.y, active, MaskKernel::count(active));
        std::uint64_t crossed = 0, several = 0;
        for (int n = 0; n < t.edges.count; ++n) {
            several |= crossed & t.crossed[std::size_t(n)];
            crossed |= t.crossed[std::size_t(n)];
        }
        for (std::uint64_t left = active & ~crossed; left != 0; left &= left - 1) {
            tile_mask(unsigned(std::countr_zero(left)), all_subcells);
        }
        for (int n = 0; n < t.edges.count; ++n) {
            const std::uint8_t edge = t.edges.edge[std::size_t(n)];
            const std::int64_t e = t.edges.e[std::size_t(n)];
            for (std::uint64_t left = active & t.crossed[std::size_t(n)] & ~several; left != 0; left &= left - 1) {
                const auto k = unsigned(std::countr_zero(left));
                tile_mask(k, edges_.samples_inside(edge, e, block_.x, block_.y, k));
            }
        }
        for (std::uint64_t left = active & several; left != 0; left &= left - 1) {
            const auto k = unsigned(std::countr_zero(left));
            tile_mask(k, edges_.samples_inside(t, block_.x, block_.y, k));
        }
    }

    /// "W = P & ~C; C' = C | P" (section 3).
    FARFIELD_INLINE void tile_mask(unsigned k, std::uint64_t inside) {
        if (surface_.covers_some()) inside &= hashed_samples(k);
        const bool is_vacant = (block_.cell->vacant >> k & 1) != 0;
        const std::uint64_t covered = is_vacant ? block_.samples_outside(pyramid_, k) : Masks::covered(k);
        if (Masks::tile_overlap(k, inside, covered, is_vacant)) return;
        const std::uint64_t seen = inside & ~covered;
        if (seen == 0) return;
        block_.drew = true;
        block_.masks[k] = covered | seen;
        block_.cell->vacant &= ~bit_of(k);
        if (block_.masks[k] == all_subcells) block_.cell->covered |= bit_of(k);
        target_.samples.add(block_, k, seen, MaskKernel::count(seen), surface_, is_vacant);
        Masks::add_fragment(k, seen, is_vacant);
    }

    std::uint64_t hashed_samples(unsigned k) const {
        return surface_.hashed_samples(block_.sample_x_of(k), block_.sample_y_of(k),
                                       Target::samples_type::shades_samples);
    }

    TileEdges<Target> edges_;
};

template <class Target>
bool tile(Target& target, TilePolygon& polygon) {
    return Tiler<Target>(target, polygon).tile();
}

template <class Target>
bool is_seen(Target& target, const Silhouette& box, int grown_by) {
    return CoverageQuery<Target>(target, box, grown_by).is_seen(grown_by);
}
