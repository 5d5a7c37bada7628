// Masks of samples under lazy z-buffering (Greene 1996, section 6.1): a mask remembers which fragments it shows, and
// where polygons overlap that do not come front to back it reverts to a z-buffer, for good. Compiled once for each
// instruction set: see coverage_tiler.inl.

/// The block of 8 x 8 masks that is being tiled.
struct OpenBlock : MaskBlock {
    TriageMask* cell = nullptr;
    std::uint64_t* masks = nullptr;
    bool drew = false, is_untouched = false;
    std::uint64_t behind = all_subcells;  ///< where the polygon lies behind all that is seen
    // These are for lazy mode only.
    std::uint64_t lowered = no_subcells;  ///< where the polygon may be the farthest that is seen
    Extremes extremes;

    void open(CoveragePyramid& pyramid, const MaskBlock& at) {
        static_cast<MaskBlock&>(*this) = at;
        cell = &pyramid[index];
        masks = pyramid.samples_of_block(index);
        is_untouched = pyramid.is_untouched(index);
        drew = false;
        lowered = no_subcells;
    }
    std::uint64_t samples_outside(const CoveragePyramid& pyramid, unsigned k) const {
        return pyramid.samples_outside(8 * x + int(k % 8), 8 * y + int(k / 8));
    }
};

/// The masks of a block in strict mode: front to back, they tell all.
template <class Target>
class StrictMasks {
  protected:
    StrictMasks(Target& target, Surface& surface)
        : target_(target),
          pyramid_(target.pyramid),
          surface_(surface),
          depths_(target, &surface.depth, 1, surface.fold.thickness) {}

    std::uint64_t covered(unsigned k) const { return block_.masks[k]; }
    bool tile_overlap(unsigned, std::uint64_t, std::uint64_t, bool) { return false; }
    void add_fragment(unsigned, std::uint64_t, bool) {}
    void add_whole(std::uint64_t) {}
    void reserve_fragments() {}

    Target& target_;
    CoveragePyramid& pyramid_;
    Surface& surface_;
    CellDepths<Target> depths_;
    OpenBlock block_;
};

/// The masks of a block in lazy mode, for polygons in any order.
template <class Target>
class LazyMasks : protected StrictMasks<Target> {
  protected:
    using Base = StrictMasks<Target>;
    using Base::target_, Base::surface_, Base::depths_, Base::block_;

    using Base::Base;

    /// The samples of mask k that are covered. Masks that were covered together with others are not written.
    std::uint64_t covered(unsigned k) const {
        return (block_.cell->covered >> k & 1) != 0 ? all_subcells : block_.masks[k];
    }

    /// Takes care of mask k if the polygon is deposited or may lie before anything the mask shows. Otherwise returns
    /// false: the mask alone then tells what is seen, as in strict order.
    FARFIELD_INLINE bool tile_overlap(unsigned k, std::uint64_t inside, std::uint64_t covered, bool is_vacant) {
        if (inside == 0) return true;
        if (surface_.is_deposit()) return deposit(k, inside, covered), true;
        const std::uint64_t z_buffered = target_.lazy.block(block_.index).deep | target_.samples.deposited(block_);
        const bool is_z_buffered = (z_buffered >> k & 1) != 0;
        const bool may_meet = (inside & covered) != 0 && (block_.behind >> k & 1) == 0;
        if (is_vacant || !(may_meet || is_z_buffered)) return false;
        if (!is_z_buffered && is_behind_fragments(k, inside & covered)) return false;
        tile_deep(k, inside, covered);
        return true;
    }

    /// Records what was drawn into a mask that is not z-buffered; reserve_fragments() has made room.
    void add_fragment(unsigned k, std::uint64_t seen, bool is_vacant) {
        std::uint32_t& history = target_.lazy.history(64 * block_.index + k);
        if (is_vacant) history = LazyDepth::none;
        target_.lazy.add_fragment(history, seen, depths_.surface_index());
        block_.lowered |= bit_of(k);
    }
    void add_whole(std::uint64_t whole) {
        target_.lazy.add_fragment(target_.lazy.block(block_.index).whole_masks, whole, depths_.surface_index());
        block_.lowered |= whole;
    }
    void reserve_fragments() { target_.lazy.reserve_fragments(65); }

  private:
    /// Whether the polygon lies behind everything that these samples of a mask show. Bounds over a whole mask cannot
    /// tell that where surfaces are steep.
    [[gnu::noinline]] bool is_behind_fragments(unsigned k, std::uint64_t samples) const {
        const LazyDepth& lazy = target_.lazy;
        for (std::uint32_t f = lazy.block(block_.index).whole_masks; f != LazyDepth::none; f = lazy.fragment(f).next) {
            if ((lazy.fragment(f).bits >> k & 1) != 0)
                return is_behind(k, lazy.depth(lazy.fragment(f).surface), samples);
        }
        for (std::uint32_t f = lazy.history(64 * block_.index + k); f != LazyDepth::none; f = lazy.fragment(f).next) {
            const std::uint64_t shared = lazy.fragment(f).bits & samples;
            if (shared != 0 && !is_behind(k, lazy.depth(lazy.fragment(f).surface), shared)) return false;
        }
        return true;
    }
    bool is_behind(unsigned k, const DepthPlane& other, std::uint64_t samples) const {
        if (surface_.depth.highest < other.lowest) return true;
        const int x = block_.sample_x_of(k), y = block_.sample_y_of(k);
        Extremes own, others;
        own.find(surface_.depth, x, y, 1);
        others.find(other, x, y, 1);
        return (MaskKernel::plane_below(own.low_rows, own.low_columns, surface_.depth, others.low_rows,
                                        others.low_columns, other) &
                samples) == samples;
    }

    // --- z-buffers

    /// Draws into a mask's z-buffer, to which the mask reverts first if it has none.
    [[gnu::noinline]] void tile_deep(unsigned k, std::uint64_t inside, std::uint64_t covered) {
        const std::size_t at = 64 * block_.index + k;
        if ((target_.lazy.block(block_.index).deep >> k & 1) == 0) make_deep(k, covered);
        DeepMask& deep = target_.lazy.deep(at);
        const std::uint64_t seen = draw_deep(deep, k, inside, covered, surface_);
        if (seen == 0) return;
        block_.drew = true;
        block_.masks[k] = covered | seen;
        if (block_.masks[k] == all_subcells) block_.cell->covered |= bit_of(k);
        target_.lazy.farthest(block_.index).q[k] =
            least_of(deep, block_.masks[k] & ~block_.samples_outside(target_.pyramid, k));
    }

    void make_deep(unsigned k, std::uint64_t covered) {
        ++target_.work.masks_z_buffered;
        LazyDepth::Block& of_block = target_.lazy.block(block_.index);
        const std::size_t at = 64 * block_.index + k;
        std::uint32_t list = target_.lazy.history(at);
        DeepMask& deep = target_.lazy.make_deep(at);
        of_block.deep |= bit_of(k);
        block_.masks[k] = covered;
        const auto replay = [&](const Surface& surface, std::uint64_t samples) {
            target_.samples.remove(block_, k, samples, surface);
            draw_deep(deep, k, samples, no_subcells, surface);
        };
        for (std::uint32_t f = of_block.whole_masks; f != LazyDepth::none; f = target_.lazy.fragment(f).next) {
            if ((target_.lazy.fragment(f).bits >> k & 1) == 0) continue;
            return replay(target_.lazy.surface(target_.lazy.fragment(f).surface), all_subcells);
        }
        for (; list != LazyDepth::none; list = target_.lazy.fragment(list).next) {
            replay(target_.lazy.surface(target_.lazy.fragment(list).surface), target_.lazy.fragment(list).bits);
        }
    }

    /// Draws as ZBufferRenderer does: the nearer wins, of two at the same depth the larger color. Returns what it drew.
    std::uint64_t draw_deep(DeepMask& deep, unsigned k, std::uint64_t inside, std::uint64_t covered,
                            const Surface& surface) const {
        using EightFloats = MaskKernel::EightFloats;
        using EightInts = MaskKernel::EightInts;
        using EightWords = MaskKernel::EightWords;
        const int x = block_.sample_x_of(k), y = block_.sample_y_of(k);
        std::array<Rgba8, 8> colors;
        constexpr bool shades_samples = Target::samples_type::shades_samples;
        const bool has_deposits = (target_.samples.deposited(block_) >> k & 1) != 0;
        const Rgba8 of_pixel = target_.samples.color_of(block_, k, surface);
        colors.fill(of_pixel);
        const MaskDepths depths_of_mask(surface, x, y);
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
            EightFloats q;
            depths_of_mask.set_row(j, q);
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
        return MaskKernel::least_of(least);
    }

    // --- the far field

    /// Deposits a surface of the far field, which covers nothing: it attenuates what is drawn behind it from now on. A
    /// pixel that has geometry too is z-buffered, so that anything nearer than a deposit stays as it is.
    [[gnu::noinline]] void deposit(unsigned k, std::uint64_t inside, std::uint64_t covered) {
        const std::size_t at = 64 * block_.index + k;
        const std::uint64_t outside = block_.samples_outside(target_.pyramid, k);
        if ((inside & ~outside) == 0) return;
        const bool is_vacant = (block_.cell->vacant >> k & 1) != 0;
        const bool is_deep = !is_vacant && (target_.lazy.block(block_.index).deep >> k & 1) != 0;
        const bool has_geometry = is_deep || (!is_vacant && (covered & ~outside) != 0);
        if (has_geometry && !is_deep) make_deep(k, covered);
        std::uint64_t farther = 0;  // geometry behind the deposit
        if (has_geometry) {
            const DepthPlane& d = surface_.depth;
            for (std::uint64_t left = inside & covered & ~outside; left != 0; left &= left - 1) {
                const auto s = unsigned(std::countr_zero(left));
                const float q = d.at(d.row(block_.sample_y_of(k) + int(s / 8)), block_.sample_x_of(k) + int(s % 8));
                if (q > target_.lazy.deep(at).q[s]) farther |= bit_of(s);
            }
        }
        const std::uint64_t seen = (inside & ~covered) | farther;
        if (seen == 0) return;
        block_.drew = true;
        if (is_vacant) {
            block_.masks[k] = outside;
            block_.cell->vacant &= ~bit_of(k);
            target_.lazy.history(at) = LazyDepth::none;
        }
        const auto let_through = target_.samples.deposit(block_, k, inside, seen, surface_, is_vacant);
        for (; farther != 0; farther &= farther - 1) {
            const auto sample = unsigned(std::countr_zero(farther));
            Rgba8& c = target_.lazy.deep(at).color[sample];
            c = FarPixels::attenuated(c, let_through[FarPixels::lane_of(sample)]);
        }
        if (!target_.samples.is_closed(block_, k) || (~covered & ~outside) == 0) return;
        // A pixel that deposits have closed counts as covered, at their depth, by samples that add no color.
        if (has_geometry) return tile_deep(k, ~covered, covered);
        block_.masks[k] = all_subcells;
        block_.cell->covered |= bit_of(k);
        target_.lazy.add_fragment(target_.lazy.history(at), ~covered, depths_.surface_index());
        block_.lowered |= bit_of(k);
    }
};
