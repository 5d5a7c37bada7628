// What a polygon does to cells and to masks of samples where polygons come in any order (Greene 1996, section 6.1):
// they are an A-buffer, and a polygon takes the subcells and samples where it is nearer from the fragments that showed
// there. Compiled once for each instruction set: see coverage_tiler.inl.

/// Bounds of a polygon's q in a mask.
struct DepthRange {
    float lowest, highest;
};

/// Lazy mode, for polygons in any order. Colors are found when the picture is made.
template <class Target>
class LazyMasks {
  protected:
    LazyMasks(Target& target, Surface& surface)
        : target_(target),
          pyramid_(target.pyramid),
          fragments_(target.fragments),
          surface_(surface),
          depths_(target, &surface.depth, 1, surface.fold.thickness) {}

    // --- cells

    /// Vacant ones, and those in which it lies before all that is seen.
    std::uint64_t taken(std::uint64_t inside, std::size_t cell, const Extremes& extremes) const {
        const std::uint64_t vacant = inside & pyramid_[cell].vacant;
        if (vacant == inside) return inside;
        return vacant |
               (inside & MaskKernel::plane_above(extremes.low_rows, extremes.low_columns, surface_.depth.lowest,
                                                 surface_.depth.highest, fragments_.nearest(cell).q.data()));
    }
    void cover(std::size_t cell, int, int, int, std::uint64_t subcells, const Extremes& extremes) {
        fragments_.reserve_fragments(1);
        cover(cell, subcells, surface_index(), surface_.depth, extremes);
    }
    /// Prepares subcell k of a cell for being tiled: what was covered at once is passed on.
    void refine(std::size_t cell, unsigned k, int level, int x, int y) {
        if (!depths_.is_whole(cell, k)) return;
        fragments_.reserve_fragments(1);
        const std::uint32_t surface = fragments_.part_of_whole(cell, k);
        const std::size_t child = pyramid_.index(level - 1, x, y);
        const std::uint64_t inside = pyramid_.inside(child);
        fragments_.open(child, inside);
        pyramid_[child] = {~inside, inside};
        const DepthPlane& depth = fragments_.record(surface).depth;
        Extremes extremes;
        depths_.find_extremes(depth, level - 1, x, y, extremes);
        if (const Surface* details = fragments_.details(surface)) extremes.raise_highest(details->fold.thickness);
        cover(child, inside, surface, depth, extremes);
    }
    void drew_in(std::size_t parent, unsigned k, std::size_t cell, const Extremes& extremes) {
        const DepthPlane& d = surface_.depth;
        bound(parent, k, cell, d.inside(extremes.low_rows[k / 8] + extremes.low_columns[k % 8]),
              bound_of_nearest(d.inside(extremes.high_rows[k / 8] + extremes.high_columns[k % 8])));
    }
    void drew_somewhere_in(std::size_t parent, unsigned k, std::size_t cell) {
        bound(parent, k, cell, surface_.depth.lowest, bound_of_nearest(surface_.depth.highest));
    }

    // --- masks

    void open_block(const MaskBlock& at) {
        block_.open(pyramid_, at);
        if (pyramid_.is_untouched(at.index)) fragments_.open(at.index, pyramid_.inside(at.index));
    }
    bool cover_block(std::uint64_t) { return false; }
    void begin_masks() { fragments_.reserve_fragments(2 * 64 + 1); }
    void cover_masks(std::uint64_t whole) {
        cover(block_.index, whole, surface_index(), surface_.depth, block_.extremes);
        block_.drew = true;
    }

    DepthRange depths_in(unsigned k) const {
        const DepthPlane& d = surface_.depth;
        const Extremes& e = block_.extremes;
        return {d.inside(e.low_rows[k / 8] + e.low_columns[k % 8]),
                d.inside(e.high_rows[k / 8] + e.high_columns[k % 8])};
    }
    DepthRange depths_of_all() const { return {surface_.depth.lowest, surface_.depth.highest}; }

    /// Tiles some masks: of mask k, inside_of(k) is the polygon's, and depths_of(k) the range of its depths there.
    template <class InsideOf, class DepthsOf>
    FARFIELD_INLINE void tile_masks(std::uint64_t masks, InsideOf&& inside_of, DepthsOf&& depths_of) {
        for (; masks != 0; masks &= masks - 1) {
            const auto k = unsigned(std::countr_zero(masks));
            tile_mask(k, inside_of(k), depths_of(k));
        }
    }
    FARFIELD_INLINE void tile_mask(unsigned k, std::uint64_t inside, DepthRange range) {
        if (inside == 0) return;
        const std::size_t at = 64 * block_.index + k;
        const bool is_vacant = (block_.cell->vacant >> k & 1) != 0;
        const bool is_whole = (fragments_.cell(block_.index).whole >> k & 1) != 0;
        const std::uint64_t covered = is_vacant  ? block_.samples_outside(pyramid_, k)
                                      : is_whole ? all_subcells
                                                 : block_.masks[k];
        if (surface_.is_deposit()) [[unlikely]]
            return deposit(k, inside, covered, range);
        float& farthest = fragments_.farthest(block_.index).q[k];
        float& nearest = fragments_.nearest(block_.index).q[k];
        const auto [lowest, highest] = range;
        if (is_vacant) {
            inside &= ~covered;
            if (inside == 0) return;
            fragments_.list(at) = ABuffer::none;
            fragments_.add_fragment(fragments_.list(at), {inside, surface_index(), ABuffer::none, lowest, highest});
            farthest = lowest;
            nearest = highest;
            block_.masks[k] = covered | inside;
            block_.cell->vacant &= ~bit_of(k);
            if (block_.masks[k] == all_subcells) block_.cell->covered |= bit_of(k);
            block_.drew = true;
            return;
        }
        const std::uint64_t z_buffered = fragments_.cell(block_.index).deep | target_.samples.deposited(block_);
        if ((z_buffered >> k & 1) != 0) return tile_deep(k, inside, covered, range);
        const std::uint64_t meets = highest < farthest ? no_subcells : inside & covered;
        std::uint64_t taken = meets;
        if (meets != 0 && !(lowest > nearest)) {
            taken = is_whole ? nearer_than(fragments_.surface_of_whole(block_.index, k), k, meets)
                             : nearer_in_list(fragments_.list(at), k, meets, lowest, highest);
        }
        const std::uint64_t seen = (inside & ~covered) | taken;
        if (seen == 0) return;
        block_.drew = true;
        if (is_whole) open_mask(k);
        const std::uint32_t surface = surface_index();
        if (taken != 0) {
            farthest = std::numeric_limits<float>::infinity();
            int left = 0;
            fragments_.take(fragments_.list(at), taken, [&](const ABuffer::Fragment& f) {
                farthest = std::min(farthest, f.lowest);
                ++left;
            });
            if (left >= most_fragments) {
                // Shows too many surfaces.
                return tile_deep(k, inside, covered & ~taken, range);
            }
        }
        fragments_.add_fragment(fragments_.list(at), {seen, surface, ABuffer::none, lowest, highest});
        farthest = std::min(farthest, lowest);
        nearest = std::max(nearest, highest);
        block_.masks[k] = covered | seen;
        if (block_.masks[k] == all_subcells) block_.cell->covered |= bit_of(k);
    }

    Target& target_;
    CoveragePyramid& pyramid_;
    ABuffer& fragments_;
    Surface& surface_;
    CellDepths<Target> depths_;
    OpenBlock block_;

  private:
    /// A mask that shows more surfaces is z-buffered: then a list costs more to compare with than 64 samples.
    static constexpr int most_fragments = 16;

    /// The surface's number; it is kept once something of it is seen.
    std::uint32_t surface_index() {
        if (index_ == ABuffer::none) index_ = fragments_.add(surface_);
        return index_;
    }
    SeenSurface own() const {
        return {surface_.depth, surface_.is_flat && surface_.fold.thickness == 0 ? nullptr : &surface_,
                surface_.seen_color()};
    }
    SeenSurface seen_surface(std::uint32_t index) const {
        return {fragments_.record(index).depth, fragments_.details(index), fragments_.color(index)};
    }

    // --- cells

    /// Nothing takes a cell with deposits at once: they attenuate what comes after them.
    float bound_of_nearest(float highest) const {
        return surface_.is_deposit() ? std::numeric_limits<float>::infinity() : highest;
    }
    /// Covers subcells of a cell at once, whatever they showed.
    void cover(std::size_t at, std::uint64_t subcells, std::uint32_t surface, const DepthPlane& depth,
               const Extremes& extremes) {
        ABuffer::Cell& cell = fragments_.cell(at);
        if ((cell.whole & subcells) != 0) fragments_.take(cell.list, subcells, [](const ABuffer::Fragment&) {});
        for (std::uint64_t left = cell.deep & subcells; left != 0; left &= left - 1) {
            fragments_.release_deep(64 * at + unsigned(std::countr_zero(left)));
        }
        cell.deep &= ~subcells;
        cell.whole |= subcells;
        fragments_.add_fragment(cell.list, {subcells, surface, ABuffer::none, 0, 0});
        pyramid_[at].covered |= subcells;
        pyramid_[at].vacant &= ~subcells;
        MaskKernel::update<MaskKernel::Update::assign>(subcells, extremes.low_rows, extremes.low_columns, depth.lowest,
                                                       depth.highest, fragments_.farthest(at).q.data());
        MaskKernel::update<MaskKernel::Update::assign>(subcells, extremes.high_rows, extremes.high_columns,
                                                       depth.lowest, depth.highest, fragments_.nearest(at).q.data());
    }
    /// Records that something between these depths was drawn into subcell k, which is this cell.
    void bound(std::size_t parent, unsigned k, std::size_t cell, float lowest, float highest) {
        TriageMask& mask = pyramid_[parent];
        float& farthest = fragments_.farthest(parent).q[k];
        float& nearest = fragments_.nearest(parent).q[k];
        const bool is_vacant = (mask.vacant & bit_of(k)) != 0;
        mask.vacant &= ~bit_of(k);
        nearest = is_vacant ? highest : std::max(nearest, highest);
        if (!pyramid_.is_covered(cell)) {
            farthest = is_vacant ? lowest : std::min(farthest, lowest);
            return;
        }
        // The farthest thing of it may have been hidden since: it knows the depth better.
        mask.covered |= bit_of(k);
        farthest = MaskKernel::least(fragments_.farthest(cell).q.data());
    }

    // --- masks

    /// Turns mask k, which one surface covers at once, into a list.
    void open_mask(unsigned k) {
        const std::size_t at = 64 * block_.index + k;
        const std::uint32_t surface = fragments_.part_of_whole(block_.index, k);
        fragments_.list(at) = ABuffer::none;
        fragments_.add_fragment(fragments_.list(at),
                                {all_subcells, surface, ABuffer::none, fragments_.farthest(block_.index).q[k],
                                 fragments_.nearest(block_.index).q[k]});
        block_.masks[k] = all_subcells;
    }
    /// Those of some samples where the polygon wins over what a mask shows.
    [[gnu::noinline]] std::uint64_t nearer_in_list(std::uint32_t list, unsigned k, std::uint64_t samples, float lowest,
                                                   float highest) {
        std::uint64_t nearer = 0;
        for (; list != ABuffer::none; list = fragments_.fragment(list).next) {
            const ABuffer::Fragment& f = fragments_.fragment(list);
            const std::uint64_t shared = samples & f.bits;
            if (shared == 0 || highest < f.lowest) continue;
            nearer |= lowest > f.highest ? shared : nearer_than(f.surface, k, shared);
        }
        return nearer;
    }
    /// The same for one surface. The nearer wins, of two at the same depth the larger color. The difference of two
    /// planes is one too, and only where it all but vanishes does rounding decide.
    [[gnu::noinline]] std::uint64_t nearer_than(std::uint32_t other_surface, unsigned k, std::uint64_t samples) {
        const ABuffer::Record& record = fragments_.record(other_surface);
        const DepthPlane &d = surface_.depth, &o = record.depth;
        const float x = float(block_.sample_x_of(k)), y = float(block_.sample_y_of(k));
        const float d_x = d.by_x * (x + d.base_x), d_y = d.by_y * (y + d.base_y);
        const float o_x = o.by_x * (x + o.base_x), o_y = o.by_y * (y + o.base_y);
        const float difference = (d.at_corner - o.at_corner) + (d_x - o_x) + (d_y - o_y);
        const float slopes = std::abs(d.by_x) + std::abs(d.by_y) + std::abs(o.by_x) + std::abs(o.by_y);
        // Centers of samples that are not there may lie beyond the corners, where depths are clamped.
        constexpr float beyond = Target::reach_of_samples != 0 ? 1.0f : 0.0f;
        const float slack = 0x1p-20f * (std::abs(d.at_corner) + std::abs(o.at_corner) + std::abs(d_x) + std::abs(d_y) +
                                        std::abs(o_x) + std::abs(o_y) + 8 * slopes) +
                            beyond * slopes;
        float thickness = surface_.fold.thickness;
        if (record.details != ABuffer::none) thickness += fragments_.details(other_surface)->fold.thickness;
        std::uint64_t below, above;
        MaskKernel::split(difference, d.by_x - o.by_x, d.by_y - o.by_y, -slack, slack + thickness, below, above);
        const std::uint64_t open = samples & ~(below | above);
        const std::uint64_t nearer = samples & above;
        return open == 0 ? nearer : nearer | nearer_samples(other_surface, k, open);
    }
    [[gnu::noinline]] std::uint64_t nearer_samples(std::uint32_t other_surface, unsigned k, std::uint64_t samples) {
        const int x = block_.sample_x_of(k), y = block_.sample_y_of(k);
        const SeenSurface one = own(), other = seen_surface(other_surface);
        const MaskDepths one_depths(one, x, y), other_depths(other, x, y);
        std::uint64_t nearer = 0, equal = 0;
        one_depths.for_planes([&](const DepthPlane& d, std::uint64_t on_d) {
            other_depths.for_planes([&](const DepthPlane& o, std::uint64_t on_o) {
                std::uint64_t above, same;
                MaskKernel::compare(d, o, x, y, above, same);
                nearer |= above & on_d & on_o;
                equal |= same & on_d & on_o;
            });
        });
        equal &= samples;
        if (equal != 0) [[unlikely]]
            nearer |= wins_ties(one, other, k, equal);
        return nearer & samples;
    }
    [[gnu::noinline]] std::uint64_t wins_ties(const SeenSurface& one, const SeenSurface& other, unsigned k,
                                              std::uint64_t samples) {
        if (!Target::samples_type::shades_samples || (one.is_flat() && other.is_flat()))
            return std::bit_cast<std::uint32_t>(z_buffers_.color_of(one, k)) >
                           std::bit_cast<std::uint32_t>(z_buffers_.color_of(other, k))
                       ? samples
                       : no_subcells;
        std::uint64_t wins = 0;
        for (; samples != 0; samples &= samples - 1) {
            const auto s = unsigned(std::countr_zero(samples));
            if (std::bit_cast<std::uint32_t>(z_buffers_.color_at(one, k, s)) >
                std::bit_cast<std::uint32_t>(z_buffers_.color_at(other, k, s)))
                wins |= bit_of(s);
        }
        return wins;
    }

    // --- z-buffers

    /// Draws into a mask's z-buffer, to which the mask reverts first if it has none.
    [[gnu::noinline]] void tile_deep(unsigned k, std::uint64_t inside, std::uint64_t covered, DepthRange range) {
        const std::size_t at = 64 * block_.index + k;
        if ((fragments_.cell(block_.index).deep >> k & 1) == 0) make_deep(k, covered);
        DeepMask& deep = fragments_.deep(at);
        const std::uint64_t seen = z_buffers_.draw(deep, k, inside, covered, own());
        if (seen == 0) return;
        block_.drew = true;
        block_.masks[k] = covered | seen;
        block_.cell->vacant &= ~bit_of(k);
        if (block_.masks[k] == all_subcells) block_.cell->covered |= bit_of(k);
        fragments_.farthest(block_.index).q[k] =
            DeepMasks<Target>::least_of(deep, block_.masks[k] & ~block_.samples_outside(pyramid_, k));
        float& nearest = fragments_.nearest(block_.index).q[k];
        nearest = std::max(nearest, range.highest);
    }

    /// A mask that is vacant becomes one without samples.
    void make_deep(unsigned k, std::uint64_t covered) {
        ++target_.work.masks_z_buffered;
        const std::size_t at = 64 * block_.index + k;
        const bool is_vacant = (block_.cell->vacant >> k & 1) != 0;
        if ((fragments_.cell(block_.index).whole >> k & 1) != 0) open_mask(k);
        std::uint32_t list = is_vacant ? ABuffer::none : fragments_.list(at);
        DeepMask& deep = fragments_.make_deep(at);
        fragments_.cell(block_.index).deep |= bit_of(k);
        block_.masks[k] = covered;
        while (list != ABuffer::none) {
            const ABuffer::Fragment& f = fragments_.fragment(list);
            z_buffers_.draw(deep, k, f.bits, no_subcells, seen_surface(f.surface));
            fragments_.unlink(list);
        }
    }

    // --- the far field

    /// Deposits a surface of the far field, which covers nothing: it attenuates what is drawn behind it from now on. A
    /// pixel that has geometry too is z-buffered, so that anything nearer than a deposit stays as it is.
    [[gnu::noinline]] void deposit(unsigned k, std::uint64_t inside, std::uint64_t covered, DepthRange range) {
        const std::size_t at = 64 * block_.index + k;
        const std::uint64_t outside = block_.samples_outside(pyramid_, k);
        if ((inside & ~outside) == 0) return;
        const bool is_vacant = (block_.cell->vacant >> k & 1) != 0;
        const bool is_deep = !is_vacant && (fragments_.cell(block_.index).deep >> k & 1) != 0;
        const bool has_geometry = is_deep || (!is_vacant && (covered & ~outside) != 0);
        if (has_geometry && !is_deep) make_deep(k, covered);
        std::uint64_t farther = 0;  // geometry behind the deposit
        if (has_geometry) {
            const DepthPlane& d = surface_.depth;
            for (std::uint64_t left = inside & covered & ~outside; left != 0; left &= left - 1) {
                const auto s = unsigned(std::countr_zero(left));
                const float q = d.at(d.row(block_.sample_y_of(k) + int(s / 8)), block_.sample_x_of(k) + int(s % 8));
                if (q > fragments_.deep(at).q[s]) farther |= bit_of(s);
            }
        }
        const std::uint64_t seen = (inside & ~covered) | farther;
        if (seen == 0) return;
        block_.drew = true;
        if (is_vacant) {
            block_.masks[k] = outside;
            block_.cell->vacant &= ~bit_of(k);
            fragments_.list(at) = ABuffer::none;
            fragments_.farthest(block_.index).q[k] = std::numeric_limits<float>::infinity();
        }
        fragments_.nearest(block_.index).q[k] = std::numeric_limits<float>::infinity();
        const auto let_through = target_.samples.deposit(block_, k, inside, seen, surface_);
        for (; farther != 0; farther &= farther - 1) {
            const auto sample = unsigned(std::countr_zero(farther));
            Rgba8& c = fragments_.deep(at).color[sample];
            c = FarPixels::attenuated(c, let_through[FarPixels::lane_of(sample)]);
        }
        if (!target_.samples.is_closed(block_, k) || (~covered & ~outside) == 0) return;
        // A pixel that deposits have closed counts as covered, at their depth, by samples that add no color.
        if (has_geometry) return tile_deep(k, ~covered, covered, range);
        fragments_.add_fragment(fragments_.list(at),
                                {~covered, surface_index(), ABuffer::none, range.lowest, range.highest});
        fragments_.farthest(block_.index).q[k] = range.lowest;
        block_.masks[k] = all_subcells;
        block_.cell->covered |= bit_of(k);
    }

    DeepMasks<Target> z_buffers_{target_, block_};
    std::uint32_t index_ = ABuffer::none;
};
