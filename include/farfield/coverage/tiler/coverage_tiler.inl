// Tiling by listing 1 of Greene 1996; compiled once for each instruction set, see coverage_tiler.hpp. There are no
// include guards, here and in the parts; FARFIELD_LANES must be 1, 4, 8 or 16, and the including namespace is for them
// alone.

// Each part needs some of those before it.
// clang-format off
#include "farfield/coverage/tiler/mask_kernel.inl"     // sixty-four comparisons to a mask
#include "farfield/coverage/tiler/tile_edges.inl"      // a polygon's bounding box, its edges, and triage of cells by them
#include "farfield/coverage/tiler/cell_depths.inl"     // whether something lies behind all that is seen in a cell
#include "farfield/coverage/tiler/coverage_query.inl"  // whether anything of a bounding box or a silhouette may be seen
#include "farfield/coverage/tiler/mask_depths.inl"     // surfaces as the samples of a mask see them
#include "farfield/coverage/tiler/strict_masks.inl"    // what a polygon does to cells and masks front to back
#include "farfield/coverage/tiler/deep_masks.inl"      // colors in masks, and masks' z-buffers
#include "farfield/coverage/tiler/lazy_masks.inl"      // the same in any order
// clang-format on

template <class Target>
using Masks = std::conditional_t<Target::is_lazy, LazyMasks<Target>, StrictMasks<Target>>;

/// Recurses from the cells that enclose a polygon down to masks of samples.
template <class Target>
class Tiler : Masks<Target> {
    using Base = Masks<Target>;
    using Base::target_, Base::pyramid_, Base::surface_, Base::depths_, Base::block_;
    using Edges = typename TileEdges<Target>::Edges;
    using Triage = typename TileEdges<Target>::Triage;

  public:
    Tiler(Target& target, TilePolygon& polygon) : Base(target, polygon.surface), edges_(target, polygon, 0) {}

    bool tile() {
        if (Target::masks == MaskSource::exact && edges_.box.spans_two_masks_a_side()) {
            if (edges_.box.is_empty()) return false;
            const Outcome outcome = tile_tiny();
            if (outcome != Outcome::undecided) return outcome == Outcome::seen;
        }
        const bool is_small = Target::masks == MaskSource::exact && edges_.box.spans_few_masks();
        const StartCells<Target> start(target_, edges_.box, depths_, is_small);
        if (start.empty()) return false;
        ++target_.work.polygons_tiled;
        // About half of all polygons are hidden; delay this work.
        if constexpr (!Target::is_lazy) surface_.need_gradient();
        edges_.prepare(0);
        if (!is_small) edges_.tabulate();
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
        return drew;
    }

  private:
    // --- polygons of a pixel or two

    enum class Outcome { hidden, seen, undecided };

    /// Tiles two by two masks at most, by bounds of depth that are those of the corners. Undecided: a cell above was
    /// covered at once and has to be refined.
    Outcome tile_tiny() {
        const TileBox& box = edges_.box;
        const int x0 = box.x0 >> 3, y0 = box.y0 >> 3, x1 = box.x1 >> 3, y1 = box.y1 >> 3;
        std::uint64_t seen_in[4];
        bool is_seen = false;
        unsigned n = 0;
        for (int by = y0 >> 3; by <= y1 >> 3; ++by) {
            for (int bx = x0 >> 3; bx <= x1 >> 3; ++bx, ++n) {
                const CoveredAbove above = depths_.covered_above(1, bx, by);
                if (above.level != 0 && !above.is_hidden) return Outcome::undecided;
                const std::size_t block = pyramid_.index(1, bx, by);
                seen_in[n] = above.is_hidden ? no_subcells : box.subcells(1, bx, by);
                seen_in[n] &= ~(pyramid_[block].covered & depths_.corners_behind(seen_in[n], block));
                is_seen = is_seen || seen_in[n] != 0;
            }
        }
        if (!is_seen) return Outcome::hidden;
        ++target_.work.polygons_tiled;
        if constexpr (!Target::is_lazy) surface_.need_gradient();
        const auto edges = edges_.tiny_at(x0, y0);
        bool drew = false;
        n = 0;
        for (int by = y0 >> 3; by <= y1 >> 3; ++by) {
            for (int bx = x0 >> 3; bx <= x1 >> 3; ++bx, ++n) {
                if (seen_in[n] == 0) continue;
                target_.work.tiles(1, bx, by);
                target_.work.tiles_masks(bx, by, seen_in[n], MaskKernel::count(seen_in[n]));
                std::uint64_t inside[64], touched = 0;
                for (std::uint64_t left = seen_in[n]; left != 0; left &= left - 1) {
                    const auto k = unsigned(std::countr_zero(left));
                    inside[k] = edges_.samples_inside(edges, 8 * bx + int(k % 8) - x0, 8 * by + int(k / 8) - y0);
                    touched |= std::uint64_t(inside[k] != 0) << k;
                }
                if (touched == 0) continue;
                Base::open_block(target_.block_at(bx, by));
                Base::begin_masks();
                if (surface_.covers_some()) [[unlikely]] {
                    for (std::uint64_t left = touched; left != 0; left &= left - 1) {
                        const auto k = unsigned(std::countr_zero(left));
                        inside[k] &= hashed_samples(k);
                    }
                }
                Base::tile_masks(
                    touched, [&](unsigned k) { return inside[k]; }, [&](unsigned) { return Base::depths_of_all(); });
                if (!block_.drew) continue;
                drew = true;
                tell_parents(1, bx, by);
            }
        }
        return drew ? Outcome::seen : Outcome::hidden;
    }

    // --- cells

    bool tile_cell(int level, int x, int y, const Edges& in) {
        target_.work.tiles(level, x, y);
        Triage t;
        if (!edges_.triage(level, x, y, in, t)) return false;
        const std::size_t at = pyramid_.index(level, x, y);
        // A reference, because a copy of both words at once would wait for the two stores before it.
        const TriageMask& cell = pyramid_[at];
        Extremes extremes;
        const std::uint64_t hidden =
            cell.covered & depths_.behind(t.possible & ~cell.vacant, at, level, x, y, extremes);
        const std::uint64_t inside = surface_.covers_all() ? t.covered & t.possible & ~hidden : no_subcells;
        const std::uint64_t whole = inside != 0 ? Base::taken(inside, at, extremes) : no_subcells;
        if (whole != 0) Base::cover(at, level, x, y, whole, extremes);
        bool drew = whole != 0;
        for (std::uint64_t left = t.possible & ~(hidden | whole); left != 0; left &= left - 1) {
            const auto k = unsigned(std::countr_zero(left));
            const int child_x = 8 * x + int(k % 8), child_y = 8 * y + int(k / 8);
            Base::refine(at, k, level, child_x, child_y);
            const Edges edges = edges_.inside(t, k, level);
            if (!(level == 2 ? tile_block(child_x, child_y, edges) : tile_cell(level - 1, child_x, child_y, edges))) {
                continue;
            }
            drew = true;
            Base::drew_in(at, k, pyramid_.index(level - 1, child_x, child_y), extremes);
        }
        return drew;
    }

    /// "Whenever this occurs, we propagate coverage information to coarser levels" (section 3.1).
    void tell_parents(int level, int x, int y) {
        for (; level < pyramid_.top_level(); ++level, x >>= 3, y >>= 3) {
            const std::size_t cell = pyramid_.index(level, x, y), parent = pyramid_.index(level + 1, x >> 3, y >> 3);
            const auto k = unsigned((y & 7) * 8 + (x & 7));
            if (!Target::is_lazy && !pyramid_.is_covered(cell) && (pyramid_[parent].vacant & bit_of(k)) == 0) return;
            Base::drew_somewhere_in(parent, k, cell);
        }
    }

    // --- masks of samples

    bool tile_block(int x, int y, const Edges& in) {
        target_.work.tiles(1, x, y);
        Triage t;
        if (!edges_.triage(1, x, y, in, t)) return false;
        Base::open_block(target_.block_at(x, y));
        const TriageMask& cell = *block_.cell;
        const std::uint64_t possible =
            t.possible &
            ~(cell.covered & depths_.behind(t.possible & ~cell.vacant, block_.index, 1, x, y, block_.extremes));
        const std::uint64_t inside = surface_.covers_all() ? t.covered & possible : no_subcells;
        const std::uint64_t whole = inside != 0 ? Base::taken(inside, block_.index, block_.extremes) : no_subcells;
        if (possible == 0) return false;
        if (Base::cover_block(whole)) return true;
        Base::begin_masks();
        if (whole != 0) Base::cover_masks(whole);
        const std::uint64_t active = possible & ~whole;
        if (active != 0) tile_masks(t, active);
        return block_.drew;
    }

    /// Tiles all masks that the bounding box touches, each by all edges. The polygon is so small that 32 bits suffice.
    bool tile_few_masks(int x, int y) {
        target_.work.tiles(1, x, y);
        Base::open_block(target_.block_at(x, y));
        std::uint64_t active = edges_.box.subcells(1, x, y);
        active &= ~(block_.cell->covered & depths_.few_behind(active, block_.index, x, y, block_.extremes));
        if (active == 0) return false;
        Base::begin_masks();
        target_.work.tiles_masks(x, y, active, MaskKernel::count(active));
        const auto edges = edges_.few_masks_at(x, y);
        tile(active, [&](unsigned k) { return edges_.samples_inside(edges, k); });
        return block_.drew;
    }

    /// Groups masks by how many edges cross them: in large polygons nearly all have one, and in a mesh many have none.
    void tile_masks(const Triage& t, std::uint64_t active) {
        target_.work.tiles_masks(block_.x, block_.y, active, MaskKernel::count(active));
        std::uint64_t crossed = 0, several = 0;
        for (int n = 0; n < t.edges.count; ++n) {
            several |= crossed & t.crossed[std::size_t(n)];
            crossed |= t.crossed[std::size_t(n)];
        }
        tile(active & ~crossed, [](unsigned) { return all_subcells; });
        for (int n = 0; n < t.edges.count; ++n) {
            const std::uint64_t masks = active & t.crossed[std::size_t(n)] & ~several;
            if (masks != 0) tile(masks, edges_.samples_inside_one(t, n, block_.x, block_.y));
        }
        tile(active & several, [&](unsigned k) { return edges_.samples_inside(t, block_.x, block_.y, k); });
    }

    /// Tiles some masks: inside_of(k) tells which samples of mask k lie inside the polygon.
    template <class InsideOf>
    FARFIELD_INLINE void tile(std::uint64_t masks, InsideOf&& inside_of) {
        const auto depths_of = [&](unsigned k) { return Base::depths_in(k); };
        if (surface_.covers_some()) [[unlikely]] {
            return Base::tile_masks(
                masks, [&](unsigned k) { return inside_of(k) & hashed_samples(k); }, depths_of);
        }
        Base::tile_masks(masks, inside_of, depths_of);
    }

    std::uint64_t hashed_samples(unsigned k) {
        surface_.need_gradient();
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
