// Listing 1 of Greene 1996, once for each instruction set: see coverage_tiler.hpp. No include guard; expects
// FARFIELD_LANES (1, 4, 8 or 16) and to stand inside a namespace of its own.
//
// An edge is an integer function E(i, j) = e + 256 (a i + b j) of samples, 0 or more inside, e at the first sample of
// the cell in question. Of a subcell of s x s samples, E is least and greatest in corners: with low = min(a, 0) +
// min(b, 0), it is covered iff e + 256 s (a i + b j) + 256 (s - 1) low >= 0, which is (a i + b j) + base >= 0 with base
// rounded down. So the 64 numbers a i + b j serve every level, and a mask is one comparison of them with a base. That
// is exact, where the paper's table of edges quantized to 64 intervals a side is not.

#include "farfield/coverage/mask_kernel.inl"

template <class Target>
class Tiler {
  public:
    /// With `grown_by`, as if grown by so many 1/256 samples.
    Tiler(Target& target, TilePolygon& polygon, int grown_by = 0)
        : target_(target), pyramid_(target.pyramid), polygon_(polygon), surface_(polygon.surface) {
        grown_by += Target::reach_of_samples;
        // Samples i with 256 i + 128 inside [lowest, highest].
        std::int32_t low_x = polygon.x[0], high_x = low_x, low_y = polygon.y[0], high_y = low_y;
        for (int c = 1; c < polygon.corners; ++c) {
            low_x = std::min(low_x, polygon.x[std::size_t(c)]);
            high_x = std::max(high_x, polygon.x[std::size_t(c)]);
            low_y = std::min(low_y, polygon.y[std::size_t(c)]);
            high_y = std::max(high_y, polygon.y[std::size_t(c)]);
        }
        span_ = std::max(high_x - low_x, high_y - low_y);
        x0_ = std::max(((low_x - grown_by + 127) >> 8) - target.first_x, 0);
        y0_ = std::max(((low_y - grown_by + 127) >> 8) - target.first_y, 0);
        x1_ = std::min(((high_x + grown_by - 128) >> 8) - target.first_x, pyramid_.width_samples() - 1);
        y1_ = std::min(((high_y + grown_by - 128) >> 8) - target.first_y, pyramid_.height_samples() - 1);
    }

    bool tile() {
        is_small_ = Target::masks == MaskSource::exact && spans_few_masks();
        if (!choose_cells()) return false;
        ++target_.work.polygons_tiled;
        // Not before: of two polygons one is hidden.
        if (!surface_.is_flat) surface_.find_gradient();
        prepare_edges(0, !is_small_);
        if constexpr (is_lazy) index_ = target_.lazy.add(surface_);
        bool drew = false;
        for (int c = 0; c < cell_count_; ++c) {
            const Start& s = cells_[std::size_t(c)];
            if (is_small_ && s.level == 1) {
                if (!tile_few_masks(s.x, s.y)) continue;
                tell_parents(1, s.x, s.y);
                drew = true;
                continue;
            }
            if (is_small_) tabulate_edges();
            const Edges edges = edges_at(s.level, s.x, s.y);
            if (!(s.level == 1 ? tile_block(s.x, s.y, edges) : tile_cell(s.level, s.x, s.y, edges))) continue;
            tell_parents(s.level, s.x, s.y);
            drew = true;
        }
        if constexpr (is_lazy) {
            if (!drew) target_.lazy.forget_last_surface();
        }
        return drew;
    }

    bool is_seen(const Silhouette& box, int grown_by) {
        box_ = &box;
        if (!choose_cells()) return false;
        prepare_edges(grown_by, true);
        for (int c = 0; c < cell_count_; ++c) {
            const Start& s = cells_[std::size_t(c)];
            if (sees_cell(s.level, s.x, s.y, edges_at(s.level, s.x, s.y))) return true;
        }
        return false;
    }

  private:
    static constexpr bool is_lazy = Target::is_lazy;
    static constexpr int most_edges = TilePolygon::most_corners;

    /// Those that cross a cell, and their values at its first sample.
    struct Edges {
        int count = 0;
        std::array<std::uint8_t, most_edges> edge;
        std::array<std::int64_t, most_edges> e;
    };
    struct Triage {
        std::uint64_t covered = all_subcells;   ///< by the polygon: samples all inside
        std::uint64_t possible = all_subcells;  ///< not wholly outside of one edge
        Edges edges;                            ///< that cross the cell, and the subcells that they cross
        std::array<std::uint64_t, most_edges> crossed;
    };
    struct Start {
        int level, x, y;
    };

    static std::uint64_t bit_of(unsigned k) { return std::uint64_t(1) << k; }
    std::int32_t low(unsigned edge) const { return std::min(a_[edge], 0) + std::min(b_[edge], 0); }
    std::int32_t high(unsigned edge) const { return std::max(a_[edge], 0) + std::max(b_[edge], 0); }

    // --- where to begin

    /// "We first determine whether its bounding box is visible. If this procedure fails to prove that the polygon is
    /// hidden, we then tile it into the smallest enclosing cell" (section 4.3): here the smallest cells of which two by
    /// two enclose it, so that lying on a large cell's border costs nothing. False: hidden, or no sample in its box.
    bool choose_cells() {
        if (x0_ > x1_ || y0_ > y1_) return false;
        int level = 1;
        while ((x1_ >> 3 * (level + 1)) - (x0_ >> 3 * (level + 1)) > 1 ||
               (y1_ >> 3 * (level + 1)) - (y0_ >> 3 * (level + 1)) > 1) {
            ++level;
        }
        level = std::min(level, pyramid_.top_level());
        while (true) {
            cell_count_ = 0;
            int wanted = level;
            const int shift = 3 * (level + 1);
            for (int y = y0_ >> shift; y <= y1_ >> shift; ++y) {
                for (int x = x0_ >> shift; x <= x1_ >> shift; ++x) wanted = std::max(wanted, choose_cell(level, x, y));
            }
            if (wanted == level) return cell_count_ != 0;
            level = wanted;
        }
    }

    /// Returns the level to begin at instead, if that is another.
    int choose_cell(int level, int x, int y) {
        const std::size_t cell = pyramid_.index(level, x, y);
        // A parent covered all at once has not told the cells below.
        const bool is_told = !is_covered_by_one(cell);
        for (int up = level + 1, px = x, py = y; !is_told && up <= pyramid_.top_level(); ++up, px >>= 3, py >>= 3) {
            const std::size_t parent = pyramid_.index(up, px >> 3, py >> 3);
            const auto k = unsigned((py & 7) * 8 + (px & 7));
            if ((pyramid_[parent].covered & bit_of(k)) == 0) continue;
            if constexpr (is_lazy) {
                if (!is_subcell_behind(up, px, py, target_.lazy.farthest(parent).q[k])) {
                    if (is_covered_by_one(pyramid_.index(up - 1, px, py))) return up;
                    continue;
                }
            }
            return level;
        }
        const std::uint64_t wanted = box_in(level, x, y);
        std::uint64_t hidden = wanted & pyramid_[cell].covered;
        if constexpr (is_lazy) {
            if (hidden != 0 && is_told)
                hidden = is_small_ && level == 1 ? behind_of_few(hidden, cell, x, y)
                                                 : hidden & all_behind(cell, level, x, y);
        }
        if (hidden != wanted) cells_[std::size_t(cell_count_++)] = {level, x, y};
        return level;
    }

    /// Subcells that the bounding box touches.
    std::uint64_t box_in(int level, int x, int y) const {
        const int shift = 3 * level;
        const int x0 = std::max((x0_ >> shift) - 8 * x, 0), x1 = std::min((x1_ >> shift) - 8 * x, 7);
        const int y0 = std::max((y0_ >> shift) - 8 * y, 0), y1 = std::min((y1_ >> shift) - 8 * y, 7);
        return x0 > x1 || y0 > y1 ? no_subcells : subcells_of_rect(x0, y0, x1, y1);
    }

    // --- edges

    void prepare_edges(int grown_by, bool tabulates) {
        for (int c = 0; c < polygon_.corners; ++c) {
            const auto from = std::size_t(c), to = std::size_t(c + 1 < polygon_.corners ? c + 1 : 0);
            const std::int32_t dx = polygon_.x[to] - polygon_.x[from], dy = polygon_.y[to] - polygon_.y[from];
            if (dx == 0 && dy == 0) continue;
            const auto n = std::size_t(edge_count_++);
            a_[n] = -dy;
            b_[n] = dx;
            // Samples on an edge belong to the polygon that has it at its top or left (raster/scan_conversion.hpp).
            const int bias = dy < 0 || (dy == 0 && dx > 0) ? 0 : -1;
            e_[n] = std::int64_t(dx) * (256 * std::int64_t(target_.first_y) + 128 - polygon_.y[from]) -
                    std::int64_t(dy) * (256 * std::int64_t(target_.first_x) + 128 - polygon_.x[from]) + bias +
                    std::int64_t(grown_by) * (std::abs(dx) + std::abs(dy));
        }
        if (tabulates) tabulate_edges();
    }
    void tabulate_edges() {
        for (int n = 0; n < edge_count_; ++n) {
            MaskKernel::tabulate(a_[std::size_t(n)], b_[std::size_t(n)], values_[n]);
        }
    }

    Edges edges_at(int level, int x, int y) const {
        // Where an edge of a huge polygon passes a small cell far away, its value only has to stay far from 0.
        const std::int64_t limit = std::int64_t(1) << (28 + 8 + 3 * level);
        Edges edges;
        edges.count = edge_count_;
        for (int n = 0; n < edge_count_; ++n) {
            const auto at = std::size_t(n);
            const std::int64_t e =
                e_[at] + ((std::int64_t(a_[at]) * x + std::int64_t(b_[at]) * y) << (8 + 3 * (level + 1)));
            edges.edge[at] = std::uint8_t(n);
            edges.e[at] = std::clamp(e, -limit, limit);
        }
        return edges;
    }

    /// The edges that cross subcell k, at its first sample.
    Edges edges_in(const Triage& t, unsigned k, int level) const {
        Edges edges;
        for (int n = 0; n < t.edges.count; ++n) {
            if ((t.crossed[std::size_t(n)] >> k & 1) == 0) continue;
            const std::uint8_t edge = t.edges.edge[std::size_t(n)];
            edges.edge[std::size_t(edges.count)] = edge;
            edges.e[std::size_t(edges.count++)] =
                t.edges.e[std::size_t(n)] + (std::int64_t(values_[edge][k]) << (8 + 3 * level));
        }
        return edges;
    }

    /// The polygon's mask in a cell; false: it lies outside. "Composite the edge masks" (section 3, operation 1).
    bool triage(int level, const Edges& in, Triage& out) const {
        for (int n = 0; n < in.count; ++n) {
            const std::uint8_t edge = in.edge[std::size_t(n)];
            const std::int64_t e = in.e[std::size_t(n)];
            std::uint64_t possible, covered;
            if constexpr (Target::masks == MaskSource::table) {
                const TriageMask mask = EdgeMaskTable::instance().triage(e, a_[edge], b_[edge], 3 * level);
                possible = ~mask.vacant;
                covered = mask.covered;
            } else {
                const int shift = 8 + 3 * level;
                const std::int64_t reach = (std::int64_t(256) << (3 * level)) - 256;
                const std::int64_t slack = Target::masks == MaskSource::jittered ? jitter_slack(a_[edge], b_[edge]) : 0;
                const auto most = std::int32_t((e + reach * high(edge) + slack) >> shift);
                const auto least = std::int32_t((e + reach * low(edge) - slack) >> shift);
                possible = MaskKernel::greater(values_[edge], ~most);
                covered = MaskKernel::greater(values_[edge], ~least);
            }
            if (possible == 0) return false;
            out.possible &= possible;
            if (covered == all_subcells) continue;
            out.covered &= covered;
            const auto at = std::size_t(out.edges.count++);
            out.edges.edge[at] = edge;
            out.edges.e[at] = e;
            out.crossed[at] = possible & ~covered;
        }
        return true;
    }

    /// Samples of mask k of block (x, y) that lie inside of an edge whose value at the block's first sample is e.
    std::uint64_t samples_inside(std::uint8_t edge, std::int64_t e, int x, int y, unsigned k) const {
        if constexpr (Target::masks == MaskSource::exact) {
            // The edge crosses the block: e is below 2^38, for |a| + |b| < 2^24.
            return MaskKernel::greater(values_[edge], ~(std::int32_t(e >> 8) + values_[edge][k] * 8));
        } else {
            const std::int64_t at_first = e + std::int64_t(values_[edge][k]) * 2048;
            if constexpr (Target::masks == MaskSource::table) {
                return EdgeMaskTable::instance().samples(at_first, a_[edge], b_[edge]);
            } else {
                return samples(target_.patterns.pattern_of(8 * x + int(k % 8), 8 * y + int(k / 8)), at_first, a_[edge],
                               b_[edge]);
            }
        }
    }

    // --- tiling

    bool tile_cell(int level, int x, int y, const Edges& in) {
        target_.work.tiles(level, x, y);
        Triage t;
        if (!triage(level, in, t)) return false;
        const std::size_t at = pyramid_.index(level, x, y);
        // By reference: a copy of both words at once would wait for the two stores before it.
        TriageMask& cell = pyramid_[at];
        t.possible &= box_in(level, x, y);
        Extremes extremes;
        const std::uint64_t hidden = cell.covered & behind(t.possible & ~cell.vacant, at, level, x, y, extremes);
        const std::uint64_t whole = surface_.is_solid ? cell.vacant & t.covered : no_subcells;
        cell.covered |= whole;
        cell.vacant &= ~whole;
        for (std::uint64_t left = whole; left != 0; left &= left - 1) {
            const auto k = unsigned(std::countr_zero(left));
            cover_cell(level - 1, 8 * x + int(k % 8), 8 * y + int(k / 8));
        }
        lower_farthest_of(at, whole, extremes);
        bool drew = whole != 0;
        for (std::uint64_t left = t.possible & ~(hidden | whole); left != 0; left &= left - 1) {
            const auto k = unsigned(std::countr_zero(left));
            const int child_x = 8 * x + int(k % 8), child_y = 8 * y + int(k / 8);
            if constexpr (is_lazy) {
                if ((cell.vacant >> k & 1) == 0) push_down(level - 1, child_x, child_y);
            }
            const Edges edges = edges_in(t, k, level);
            if (!(level == 2 ? tile_block(child_x, child_y, edges) : tile_cell(level - 1, child_x, child_y, edges))) {
                continue;
            }
            drew = true;
            cell.vacant &= ~bit_of(k);
            const std::size_t child = pyramid_.index(level - 1, child_x, child_y);
            if (pyramid_.is_covered(child)) cell.covered |= bit_of(k);
            lower_farthest_of(at, bit_of(k), extremes);
            if constexpr (is_lazy) raise_farthest(at, k, child);
        }
        return drew;
    }

    /// All samples of a vacant cell.
    void cover_cell(int level, int x, int y) {
        if constexpr (is_lazy) target_.lazy.block(pyramid_.index(level, x, y)).covered_by = index_;
        const int shift = 3 * (level - 1);
        const int end_x = std::min((x + 1) << shift, pyramid_.columns(1));
        const int end_y = std::min((y + 1) << shift, pyramid_.rows(1));
        for (int by = y << shift; by < end_y; ++by) {
            for (int bx = x << shift; bx < end_x; ++bx) {
                const MaskBlock block = block_at(bx, by);
                target_.samples.cover_block(block, pyramid_.inside(block.index), surface_);
            }
        }
    }

    bool tile_block(int x, int y, const Edges& in) {
        target_.work.tiles(1, x, y);
        Triage t;
        if (!triage(1, in, t)) return false;
        open_block(x, y);
        const std::size_t block = block_.index;
        if constexpr (is_lazy) {
            if (is_untouched_) target_.lazy.open(block);
        }
        t.possible &= box_in(1, x, y);
        behind_ = behind(t.possible & ~cell_->vacant, block, 1, x, y, extremes_);
        const std::uint64_t whole = surface_.is_solid ? cell_->vacant & t.covered : no_subcells;
        const std::uint64_t active = t.possible & ~(cell_->covered & behind_) & ~whole;
        if ((whole | active) == 0) return false;
        if (is_untouched_) {
            // A block that is all of the image has no parent that would know its depth.
            if (whole == cell_->vacant && (!is_lazy || pyramid_.top_level() > 1)) {
                cover_cell(1, x, y);
                pyramid_[block] = {all_subcells, no_subcells};
                return true;
            }
            target_.samples.open_block(block_);
        }
        if constexpr (is_lazy) target_.lazy.reserve_fragments(65);
        if (whole != 0) cover_masks(whole);
        if (active != 0) tile_masks(t, active);
        lower_farthest();
        return drew_;
    }

    void open_block(int x, int y) {
        block_ = block_at(x, y);
        cell_ = &pyramid_[block_.index];
        masks_ = pyramid_.samples_of_block(block_.index);
        is_untouched_ = pyramid_.is_untouched(block_.index);
        drew_ = false;
        lowered_ = no_subcells;
    }

    /// Triage pays where it saves looking at masks.
    bool spans_few_masks() const {
        return span_ < 1 << 16 && ((x1_ >> 3) - (x0_ >> 3) + 1) * ((y1_ >> 3) - (y0_ >> 3) + 1) <= 16;
    }

    /// All masks that the bounding box touches, each by all edges. The polygon is so small that 32 bits suffice.
    bool tile_few_masks(int x, int y) {
        target_.work.tiles(1, x, y);
        open_block(x, y);
        std::uint64_t active = box_in(1, x, y);
        if constexpr (is_lazy) {
            if (is_untouched_) target_.lazy.open(block_.index);
            const DepthPlane& d = surface_.depth;
            extremes_.find(d, block_.sample_x, block_.sample_y, 8);
            const float* farthest = target_.lazy.farthest(block_.index).q.data();
            behind_ = 0;
            for (std::uint64_t left = active; left != 0; left &= left - 1) {
                const auto k = unsigned(std::countr_zero(left));
                const float most = d.inside(extremes_.high_rows[k / 8] + extremes_.high_columns[k % 8]);
                behind_ |= std::uint64_t(most < farthest[k]) << k;
            }
            target_.lazy.reserve_fragments(65);
        }
        active &= ~(cell_->covered & behind_);
        if (active == 0) return false;
        if (is_untouched_) target_.samples.open_block(block_);
        target_.work.tiles_masks(x, y, active, MaskKernel::count(active));
        std::array<std::int32_t, most_edges> base;
        for (int n = 0; n < edge_count_; ++n) {
            const auto at = std::size_t(n);
            base[at] = std::int32_t((e_[at] + ((std::int64_t(a_[at]) * x + std::int64_t(b_[at]) * y) << 14)) >> 8);
        }
        for (std::uint64_t left = active; left != 0; left &= left - 1) {
            const auto k = unsigned(std::countr_zero(left));
            std::uint64_t inside = all_subcells;
            for (int n = 0; n < edge_count_; ++n) {
                const auto at = std::size_t(n);
                const std::int32_t to_mask = (a_[at] * std::int32_t(k % 8) + b_[at] * std::int32_t(k / 8)) * 8;
                inside &= MaskKernel::greater(a_[at], b_[at], ~(base[at] + to_mask));
            }
            if (inside != 0) tile_mask(k, inside);
        }
        lower_farthest();
        return drew_;
    }

    void cover_masks(std::uint64_t whole) {
        target_.samples.cover_masks(block_, whole, surface_);
        cell_->covered |= whole;
        cell_->vacant &= ~whole;
        drew_ = true;
        if constexpr (is_lazy) {
            target_.lazy.add_fragment(target_.lazy.block(block_.index).whole_masks, whole, index_);
            lowered_ |= whole;
        }
    }

    /// By how many edges cross them: for large polygons nearly all masks have one, and in a mesh many have none.
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
                tile_mask(k, samples_inside(edge, e, block_.x, block_.y, k));
            }
        }
        for (std::uint64_t left = active & several; left != 0; left &= left - 1) {
            const auto k = unsigned(std::countr_zero(left));
            std::uint64_t inside = all_subcells;
            for (int n = 0; n < t.edges.count; ++n) {
                if ((t.crossed[std::size_t(n)] >> k & 1) == 0) continue;
                inside &=
                    samples_inside(t.edges.edge[std::size_t(n)], t.edges.e[std::size_t(n)], block_.x, block_.y, k);
            }
            tile_mask(k, inside);
        }
    }

    /// "W = P & ~C; C' = C | P" (section 3).
    FARFIELD_INLINE void tile_mask(unsigned k, std::uint64_t inside) {
        if (!surface_.is_solid && !surface_.is_deposit) inside &= hashed_samples(k);
        const bool is_vacant = (cell_->vacant >> k & 1) != 0;
        std::uint64_t covered = is_vacant ? samples_outside(k) : masks_[k];
        if constexpr (is_lazy) {
            if ((cell_->covered >> k & 1) != 0) covered = all_subcells;
        }
        if constexpr (is_lazy) {
            if (inside == 0) return;
            if (surface_.is_deposit) return deposit(k, inside, covered);
            const std::uint64_t z_buffered = target_.lazy.block(block_.index).deep | target_.samples.deposited(block_);
            const bool may_meet = (inside & covered) != 0 && (behind_ >> k & 1) == 0;
            if ((may_meet || (z_buffered >> k & 1) != 0) && !is_vacant) {
                if ((z_buffered >> k & 1) != 0 || !is_behind_fragments(k, inside & covered)) {
                    return tile_deep_mask(k, inside, covered);
                }
            }
        }
        const std::uint64_t seen = inside & ~covered;
        if (seen == 0) return;
        drew_ = true;
        masks_[k] = covered | seen;
        cell_->vacant &= ~bit_of(k);
        if (masks_[k] == all_subcells) cell_->covered |= bit_of(k);
        target_.samples.add(block_, k, seen, MaskKernel::count(seen), surface_, is_vacant);
        if constexpr (is_lazy) {
            std::uint32_t& history = target_.lazy.history(64 * block_.index + k);
            if (is_vacant) history = LazyDepth::none;
            target_.lazy.add_fragment(history, seen, index_);
            lowered_ |= bit_of(k);
        }
    }

    MaskBlock block_at(int x, int y) const {
        return {pyramid_.index(1, x, y), x, y, 64 * x + target_.first_x, 64 * y + target_.first_y};
    }
    std::uint64_t samples_outside(unsigned k) const {
        return pyramid_.samples_outside(8 * block_.x + int(k % 8), 8 * block_.y + int(k / 8));
    }
    std::uint64_t hashed_samples(unsigned k) const {
        return surface_.hashed_samples(block_.sample_x_of(k), block_.sample_y_of(k),
                                       Target::samples_type::shades_samples);
    }

    /// "Whenever this occurs, we propagate coverage information to coarser levels" (section 3.1).
    void tell_parents(int level, int x, int y) {
        bool is_covered = pyramid_.is_covered(pyramid_.index(level, x, y));
        for (; level < pyramid_.top_level(); ++level, x >>= 3, y >>= 3) {
            const std::size_t parent = pyramid_.index(level + 1, x >> 3, y >> 3);
            const auto k = unsigned((y & 7) * 8 + (x & 7));
            const std::uint64_t bit = bit_of(k);
            TriageMask& mask = pyramid_[parent];
            if constexpr (is_lazy) {
                float& farthest = target_.lazy.farthest(parent).q[k];
                farthest = std::min(farthest, surface_.depth.lowest);
                raise_farthest(parent, k, pyramid_.index(level, x, y));
            } else {
                if (!is_covered && (mask.vacant & bit) == 0) return;
            }
            mask.vacant &= ~bit;
            if (is_covered) mask.covered |= bit;
            is_covered = mask.covered == all_subcells;
        }
    }

    // --- lazy z-buffering

    /// q of the polygon's plane over the samples of each subcell. Sums are monotonic, rounding included: so these are
    /// exactly the least and the greatest of what DepthPlane::at gives for those samples.
    struct Extremes {
        alignas(32) float low_columns[8], high_columns[8];
        float low_rows[8], high_rows[8];

        void find(const DepthPlane& d, int x0, int y0, int step) {
            const int low_x = d.by_x > 0 ? 0 : step - 1, low_y = d.by_y > 0 ? 0 : step - 1;
            // As DepthPlane's row() and column(), eight at a time.
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

    /// Of some subcells those of which the polygon lies behind all that is seen there; of others any answer. Finds the
    /// extremes in a cell, too.
    std::uint64_t behind(std::uint64_t subcells, std::size_t cell, int level, int x, int y, Extremes& extremes) const {
        if constexpr (is_lazy) {
            const DepthPlane& d = surface_.depth;
            find_extremes(d, level, x, y, extremes);
            if (subcells == 0) return all_subcells;
            return MaskKernel::plane_below(extremes.high_rows, extremes.high_columns, d.lowest, d.highest,
                                           target_.lazy.farthest(cell).q.data());
        } else {
            return static_cast<void>(subcells), static_cast<void>(cell), static_cast<void>(level), static_cast<void>(x),
                   static_cast<void>(y), static_cast<void>(extremes), all_subcells;
        }
    }
    void lower_farthest_of(std::size_t cell, std::uint64_t subcells, const Extremes& extremes) {
        if constexpr (is_lazy) {
            const DepthPlane& d = surface_.depth;
            MaskKernel::lower(subcells, extremes.low_rows, extremes.low_columns, d.lowest, d.highest,
                              target_.lazy.farthest(cell).q.data());
        } else {
            static_cast<void>(cell), static_cast<void>(subcells), static_cast<void>(extremes);
        }
    }
    void lower_farthest() { lower_farthest_of(block_.index, lowered_, extremes_); }

    /// Subcells of a cell of which the polygon, or the box that is asked for, lies behind all that is seen there.
    std::uint64_t all_behind(std::size_t cell, int level, int x, int y) const {
        if constexpr (is_lazy) {
            const float* farthest = target_.lazy.farthest(cell).q.data();
            return box_ != nullptr ? box_behind(level, x, y, farthest)
                                   : plane_behind(surface_.depth, level, x, y, farthest);
        } else {
            return static_cast<void>(cell), static_cast<void>(level), static_cast<void>(x), static_cast<void>(y),
                   all_subcells;
        }
    }

    /// Of one: (x, y) of all of its level, whose cells have 8^level samples a side.
    bool is_subcell_behind(int level, int x, int y, float farthest) const {
        const int step = 1 << 3 * level, first_x = x * step + target_.first_x, first_y = y * step + target_.first_y;
        const auto is_behind = [&](const DepthPlane& d) {
            const float row = d.row(d.by_y > 0 ? first_y + step - 1 : first_y);
            return d.at(row, d.by_x > 0 ? first_x + step - 1 : first_x) < farthest;
        };
        if (box_ == nullptr) return is_behind(surface_.depth);
        return std::any_of(box_->fronts.planes.begin(), box_->fronts.planes.begin() + box_->fronts.count, is_behind);
    }
    /// Those of a few masks of a block.
    std::uint64_t behind_of_few(std::uint64_t masks, std::size_t block, int x, int y) const {
        const float* farthest = target_.lazy.farthest(block).q.data();
        std::uint64_t behind = masks & MaskKernel::greater(farthest, surface_.depth.highest);
        for (std::uint64_t left = masks & ~behind; left != 0; left &= left - 1) {
            const auto k = unsigned(std::countr_zero(left));
            if (is_subcell_behind(1, 8 * x + int(k % 8), 8 * y + int(k / 8), farthest[k])) behind |= bit_of(k);
        }
        return behind;
    }
    std::uint64_t plane_behind(const DepthPlane& d, int level, int x, int y, const float* farthest) const {
        Extremes extremes;
        find_extremes(d, level, x, y, extremes);
        return MaskKernel::plane_below(extremes.high_rows, extremes.high_columns, d.lowest, d.highest, farthest);
    }
    /// A ray is in the box no earlier than behind the last of its fronts.
    std::uint64_t box_behind(int level, int x, int y, const float* farthest) const {
        std::uint64_t behind = 0;
        for (int i = 0; i < box_->fronts.count; ++i) {
            behind |= plane_behind(box_->fronts.planes[std::size_t(i)], level, x, y, farthest);
        }
        return behind;
    }
    void find_extremes(const DepthPlane& d, int level, int x, int y, Extremes& extremes) const {
        const int step = 1 << 3 * level;
        extremes.find(d, x * 8 * step + target_.first_x, y * 8 * step + target_.first_y, step);
    }

    /// What was farthest may have been hidden since: a covered cell knows better.
    void raise_farthest(std::size_t parent, unsigned k, std::size_t cell) {
        if (!pyramid_.is_covered(cell) || target_.lazy.block(cell).covered_by != LazyDepth::none) return;
        const auto& q = target_.lazy.farthest(cell).q;
        MaskKernel::EightFloats least, next;
        __builtin_memcpy(&least, q.data(), sizeof least);
        for (unsigned j = 1; j < 8; ++j) {
            __builtin_memcpy(&next, q.data() + 8 * j, sizeof next);
            least = next < least ? next : least;
        }
        float& farthest = target_.lazy.farthest(parent).q[k];
        farthest = least[0];
        for (int i = 1; i < 8; ++i) farthest = std::min(farthest, least[i]);
    }
    /// Of a covered cell: then it knows nothing but that. Of another: whether nothing has been drawn there.
    bool is_covered_by_one(std::size_t cell) const {
        if constexpr (is_lazy) {
            if (target_.lazy.block(cell).covered_by != LazyDepth::none) return true;
        }
        return pyramid_.is_untouched(cell);
    }

    /// What covered a cell all at once is said to the cells below.
    void push_down(int level, int x, int y) {
        const std::size_t cell = pyramid_.index(level, x, y);
        const std::uint32_t index = target_.lazy.block(cell).covered_by;
        if (index == LazyDepth::none) return;
        TilePolygon whole;
        whole.surface = target_.lazy.surface(index);
        Tiler below(target_, whole, index);
        below.cover_below(level, x, y);
    }
    Tiler(Target& target, TilePolygon& polygon, std::uint32_t index)
        : target_(target), pyramid_(target.pyramid), polygon_(polygon), surface_(polygon.surface), index_(index) {}

    void cover_below(int level, int x, int y) {
        const std::size_t cell = pyramid_.index(level, x, y);
        LazyDepth& lazy = target_.lazy;
        lazy.open(cell);
        pyramid_[cell] = {all_subcells, no_subcells};
        const std::uint64_t inside = pyramid_.inside(cell);
        find_extremes(surface_.depth, level, x, y, extremes_);
        lower_farthest_of(cell, inside, extremes_);
        for (std::uint64_t left = level > 1 ? inside : 0; left != 0; left &= left - 1) {
            const auto k = unsigned(std::countr_zero(left));
            lazy.block(pyramid_.index(level - 1, 8 * x + int(k % 8), 8 * y + int(k / 8))).covered_by = index_;
        }
        if (level == 1) {
            target_.samples.split_block(block_at(x, y), inside, surface_);
            lazy.reserve_fragments(1);
            lazy.add_fragment(lazy.block(cell).whole_masks, inside, index_);
        }
    }

    /// Where polygons overlap that do not come front to back a mask reverts to a z-buffer, for good.
    [[gnu::noinline]] void tile_deep_mask(unsigned k, std::uint64_t inside, std::uint64_t covered) {
        LazyDepth& lazy = target_.lazy;
        const std::size_t at = 64 * block_.index + k;
        if ((lazy.block(block_.index).deep >> k & 1) == 0) make_deep(k, covered);
        DeepMask& deep = lazy.deep(at);
        const std::uint64_t seen = draw_deep(deep, inside, covered, surface_, k);
        if (seen == 0) return;
        drew_ = true;
        masks_[k] = covered | seen;
        if (masks_[k] == all_subcells) cell_->covered |= bit_of(k);
        lazy.farthest(block_.index).q[k] = least_of(deep, masks_[k] & ~samples_outside(k));
    }

    /// Whether it lies behind all that those samples of a mask show. Bounds over a whole mask cannot tell where
    /// surfaces are steep.
    [[gnu::noinline]] bool is_behind_fragments(unsigned k, std::uint64_t samples) const {
        const LazyDepth& lazy = target_.lazy;
        for (std::uint32_t f = lazy.block(block_.index).whole_masks; f != LazyDepth::none; f = lazy.fragment(f).next) {
            if ((lazy.fragment(f).bits >> k & 1) != 0)
                return is_behind(lazy.depth(lazy.fragment(f).surface), k, samples);
        }
        for (std::uint32_t f = lazy.history(64 * block_.index + k); f != LazyDepth::none; f = lazy.fragment(f).next) {
            const std::uint64_t shared = lazy.fragment(f).bits & samples;
            if (shared != 0 && !is_behind(lazy.depth(lazy.fragment(f).surface), k, shared)) return false;
        }
        return true;
    }
    bool is_behind(const DepthPlane& other, unsigned k, std::uint64_t samples) const {
        if (surface_.depth.highest < other.lowest) return true;
        const int x = block_.sample_x_of(k), y = block_.sample_y_of(k);
        Extremes own, others;
        own.find(surface_.depth, x, y, 1);
        others.find(other, x, y, 1);
        return (MaskKernel::plane_below(own.low_rows, own.low_columns, surface_.depth, others.low_rows,
                                        others.low_columns, other) &
                samples) == samples;
    }

    void make_deep(unsigned k, std::uint64_t covered) {
        ++target_.work.masks_z_buffered;
        LazyDepth& lazy = target_.lazy;
        LazyDepth::Block& block = lazy.block(block_.index);
        const std::size_t at = 64 * block_.index + k;
        std::uint32_t list = lazy.history(at);
        DeepMask& deep = lazy.make_deep(at);
        block.deep |= bit_of(k);
        masks_[k] = covered;
        const auto replay = [&](const Surface& surface, std::uint64_t samples) {
            target_.samples.remove(block_, k, samples, surface);
            draw_deep(deep, samples, no_subcells, surface, k);
        };
        for (std::uint32_t f = block.whole_masks; f != LazyDepth::none; f = lazy.fragment(f).next) {
            if ((lazy.fragment(f).bits >> k & 1) == 0) continue;
            return replay(lazy.surface(lazy.fragment(f).surface), all_subcells);
        }
        for (; list != LazyDepth::none; list = lazy.fragment(list).next) {
            replay(lazy.surface(lazy.fragment(list).surface), lazy.fragment(list).bits);
        }
    }

    /// As ZBufferRenderer: the nearer wins, of two at the same depth the larger color. Returns what was drawn.
    std::uint64_t draw_deep(DeepMask& deep, std::uint64_t inside, std::uint64_t covered, const Surface& surface,
                            unsigned k) const {
        using EightFloats = MaskKernel::EightFloats;
        using EightInts = MaskKernel::EightInts;
        using EightWords = MaskKernel::EightWords;
        const int x = block_.sample_x_of(k), y = block_.sample_y_of(k);
        std::array<Rgba8, 8> colors;
        const EightFloats columns =
            surface.depth.by_x * (EightFloats{0, 1, 2, 3, 4, 5, 6, 7} + float(x) + surface.depth.base_x);
        constexpr bool shades_samples = Target::samples_type::shades_samples;
        const bool has_deposits = (target_.samples.deposited(block_) >> k & 1) != 0;
        const Rgba8 of_pixel = target_.samples.color_of(block_, k, surface);
        colors.fill(of_pixel);
        std::uint64_t drawn = 0;
        for (int j = 0; j < 8; ++j) {
            const auto wanted = unsigned(inside >> (8 * j) & 255);
            if (wanted == 0) continue;
            if (shades_samples && !surface.is_flat) {
                for (int i = 0; i < 8; ++i) colors[std::size_t(i)] = surface.seen_color_at(x + i, y + j);
            }
            if (has_deposits) {
                colors.fill(of_pixel);
                target_.samples.put_behind_deposits(block_, k, unsigned(8 * j), colors);
            }
            float* depths = deep.q.data() + 8 * j;
            Rgba8* seen = deep.color.data() + 8 * j;
            EightInts is_wanted, is_open;
            MaskKernel::lanes_of(wanted, is_wanted);
            MaskKernel::lanes_of(unsigned(~covered >> (8 * j) & 255), is_open);
            EightFloats depth;
            EightWords color, old;
            __builtin_memcpy(&depth, depths, sizeof depth);
            __builtin_memcpy(&color, colors.data(), sizeof color);
            __builtin_memcpy(&old, seen, sizeof old);
            EightFloats q = surface.depth.row(y + j) + columns;
            q = q < surface.depth.lowest ? MaskKernel::EightFloats{} + surface.depth.lowest : q;
            q = q > surface.depth.highest ? MaskKernel::EightFloats{} + surface.depth.highest : q;
            const EightInts takes = is_wanted & (is_open | (q > depth) | ((q == depth) & (color > old)));
            depth = takes ? q : depth;
            old = takes ? color : old;
            __builtin_memcpy(depths, &depth, sizeof depth);
            __builtin_memcpy(static_cast<void*>(seen), &old, sizeof old);
            drawn |= std::uint64_t(MaskKernel::byte_of(takes)) << (8 * j);
        }
        return drawn;
    }

    static float least_of(const DeepMask& deep, std::uint64_t covered) {
        MaskKernel::EightFloats least = MaskKernel::EightFloats{} + std::numeric_limits<float>::infinity();
        for (unsigned j = 0; j < 8; ++j) {
            MaskKernel::EightFloats q;
            MaskKernel::EightInts counts;
            __builtin_memcpy(&q, deep.q.data() + 8 * j, sizeof q);
            MaskKernel::lanes_of(unsigned(covered >> (8 * j) & 255), counts);
            least = (counts & (q < least)) ? q : least;
        }
        float result = least[0];
        for (int i = 1; i < 8; ++i) result = std::min(result, least[i]);
        return result;
    }

    /// What belongs to the far field covers nothing: it lets less through of what is drawn behind it from now on. A
    /// pixel that has both is z-buffered, so that what is nearer than a deposit stays as it is.
    [[gnu::noinline]] void deposit(unsigned k, std::uint64_t inside, std::uint64_t covered) {
        LazyDepth& lazy = target_.lazy;
        const std::size_t at = 64 * block_.index + k;
        const std::uint64_t outside = samples_outside(k);
        if ((inside & ~outside) == 0) return;
        const bool is_vacant = (cell_->vacant >> k & 1) != 0;
        const bool is_deep = !is_vacant && (lazy.block(block_.index).deep >> k & 1) != 0;
        const bool has_geometry = is_deep || (!is_vacant && (covered & ~outside) != 0);
        if (has_geometry && !is_deep) make_deep(k, covered);
        std::uint64_t farther = 0;  // geometry behind the deposit
        if (has_geometry) {
            const DepthPlane& d = surface_.depth;
            for (std::uint64_t left = inside & covered & ~outside; left != 0; left &= left - 1) {
                const auto s = unsigned(std::countr_zero(left));
                const float q = d.at(d.row(block_.sample_y_of(k) + int(s / 8)), block_.sample_x_of(k) + int(s % 8));
                if (q > lazy.deep(at).q[s]) farther |= bit_of(s);
            }
        }
        const std::uint64_t seen = (inside & ~covered) | farther;
        if (seen == 0) return;
        drew_ = true;
        if (is_vacant) {
            masks_[k] = outside;
            cell_->vacant &= ~bit_of(k);
            lazy.history(at) = LazyDepth::none;
        }
        const auto let_through = target_.samples.deposit(block_, k, inside, seen, surface_, is_vacant);
        for (; farther != 0; farther &= farther - 1) {
            const auto sample = unsigned(std::countr_zero(farther));
            Rgba8& c = lazy.deep(at).color[sample];
            c = FarPixels::attenuated(c, let_through[FarPixels::lane_of(sample)]);
        }
        if (!target_.samples.is_closed(block_, k) || (~covered & ~outside) == 0) return;
        // What the deposits have closed is covered: by nothing more, at their depth.
        if (has_geometry) return tile_deep_mask(k, ~covered, covered);
        masks_[k] = all_subcells;
        cell_->covered |= bit_of(k);
        lazy.add_fragment(lazy.history(at), ~covered, index_);
        lowered_ |= bit_of(k);
    }

    // --- asking

    /// "Returning TRUE whenever a polygon's mask indicates that it covers a vacant subcell or a vacant grid point"
    /// (section 5.2). A subcell that is covered, but not by something nearer throughout, counts as one where it is
    /// seen.
    bool sees_cell(int level, int x, int y, const Edges& in) {
        target_.work.asks(level, x, y);
        Triage t;
        if (!triage(level, in, t)) return false;
        const std::size_t at = pyramid_.index(level, x, y);
        const TriageMask cell = pyramid_[at];
        std::uint64_t behind = all_subcells;
        if constexpr (is_lazy) {
            if (!pyramid_.is_untouched(at)) {
                behind = all_behind(at, level, x, y);
            }
        }
        const std::uint64_t hidden = cell.covered & behind;
        const std::uint64_t possible = t.possible & box_in(level, x, y) & ~hidden;
        if (possible == 0) return false;
        // A subcell that is covered, but not by something nearer throughout, has to be looked into.
        if ((possible & t.covered & ~cell.covered) != 0) return true;
        if (level == 1 && (possible & cell.covered) != 0) return true;
        const std::uint64_t* masks = level == 1 ? pyramid_.samples_of_block(at) : nullptr;
        for (std::uint64_t left = possible; left != 0; left &= left - 1) {
            const auto k = unsigned(std::countr_zero(left));
            const int child_x = 8 * x + int(k % 8), child_y = 8 * y + int(k / 8);
            if (level > 1) {
                const Edges edges = edges_in(t, k, level);
                if constexpr (is_lazy) {
                    const std::uint32_t one =
                        target_.lazy.block(pyramid_.index(level - 1, child_x, child_y)).covered_by;
                    if ((cell.covered >> k & 1) != 0 && one != LazyDepth::none) {
                        if (sees_before(target_.lazy.depth(one), level - 1, child_x, child_y, edges)) return true;
                        continue;
                    }
                }
                if (sees_cell(level - 1, child_x, child_y, edges)) return true;
                continue;
            }
            target_.work.asks(0, child_x, child_y);
            const bool counts = (~cell.vacant & behind & bit_of(k)) != 0;
            std::uint64_t inside = ~(counts ? masks[k] : pyramid_.samples_outside(child_x, child_y));
            for (int n = 0; n < t.edges.count && inside != 0; ++n) {
                if ((t.crossed[std::size_t(n)] >> k & 1) == 0) continue;
                inside &= samples_inside(t.edges.edge[std::size_t(n)], t.edges.e[std::size_t(n)], x, y, k);
            }
            if (inside != 0) return true;
        }
        return false;
    }

    /// Of a cell that one surface covers all of. Down to masks: a little of one counts as seen.
    bool sees_before(const DepthPlane& one, int level, int x, int y, const Edges& in) {
        target_.work.asks(level, x, y);
        Triage t;
        if (!triage(level, in, t)) return false;
        Extremes extremes;
        find_extremes(one, level, x, y, extremes);
        SubcellDepths farthest;
        for (unsigned k = 0; k < 64; ++k) {
            farthest.q[k] = one.inside(extremes.low_rows[k / 8] + extremes.low_columns[k % 8]);
        }
        const std::uint64_t possible = t.possible & box_in(level, x, y) & ~box_behind(level, x, y, farthest.q.data());
        if (level == 1) return possible != 0;
        for (std::uint64_t left = possible; left != 0; left &= left - 1) {
            const auto k = unsigned(std::countr_zero(left));
            if (sees_before(one, level - 1, 8 * x + int(k % 8), 8 * y + int(k / 8), edges_in(t, k, level))) return true;
        }
        return false;
    }

    Target& target_;
    CoveragePyramid& pyramid_;
    TilePolygon& polygon_;
    Surface& surface_;
    std::int32_t span_ = 0;                    ///< of the bounding box, beyond the image too
    int x0_ = 0, y0_ = 0, x1_ = -1, y1_ = -1;  ///< samples of the bounding box inside the image, ends included

    int cell_count_ = 0;
    std::array<Start, 4> cells_;
    bool is_small_ = false;  ///< not worth triage
    int edge_count_ = 0;
    std::array<std::int32_t, most_edges> a_, b_;
    std::array<std::int64_t, most_edges> e_;           ///< at the image's first sample
    alignas(64) std::int32_t values_[most_edges][64];  ///< a i + b j

    // The block at work.
    TriageMask* cell_ = nullptr;
    MaskBlock block_;
    std::uint64_t* masks_ = nullptr;
    std::uint64_t behind_ = all_subcells;
    bool drew_ = false, is_untouched_ = false;
    std::uint64_t lowered_ = no_subcells;  ///< where the polygon may be the farthest that is seen

    // Lazy mode only.
    std::uint32_t index_ = 0;          ///< of the surface
    const Silhouette* box_ = nullptr;  ///< asked for
    Extremes extremes_;                ///< in the block at work
};

template <class Target>
bool tile(Target& target, TilePolygon& polygon) {
    return Tiler<Target>(target, polygon).tile();
}

template <class Target>
bool is_seen(Target& target, Silhouette& box, int grown_by) {
    return Tiler<Target>(target, box.outline, grown_by).is_seen(box, grown_by);
}
