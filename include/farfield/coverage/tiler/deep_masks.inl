// Colors of surfaces in the masks of a block, and masks' z-buffers, sample by sample (Greene 1996, section 6.1).
// Compiled once for each instruction set: see coverage_tiler.inl.

/// Of the block that is being tiled; both are borrowed.
template <class Target>
class DeepMasks {
  public:
    DeepMasks(const Target& target, const OpenBlock& block) : target_(target), block_(block) {}

    /// The one color of a mask.
    Rgba8 color_of(const SeenSurface& surface, unsigned k) const {
        if (surface.is_flat()) return surface.color;
        surface.details->need_gradient();
        return surface.details->seen_color_of_pixel(block_.sample_x_of(k), block_.sample_y_of(k));
    }
    Rgba8 color_at(const SeenSurface& surface, unsigned k, unsigned sample) const {
        if (surface.is_flat()) return surface.color;
        return surface.details->seen_color_at(block_.sample_x_of(k) + int(sample % 8),
                                              block_.sample_y_of(k) + int(sample / 8));
    }

    /// Draws as ZBufferRenderer does: the nearer wins, of two at the same depth the larger color. Returns what it drew.
    std::uint64_t draw(DeepMask& deep, unsigned k, std::uint64_t inside, std::uint64_t covered,
                       const SeenSurface& surface) const {
        using EightFloats = MaskKernel::EightFloats;
        using EightInts = MaskKernel::EightInts;
        using EightWords = MaskKernel::EightWords;
        const int x = block_.sample_x_of(k), y = block_.sample_y_of(k);
        std::array<Rgba8, 8> colors;
        constexpr bool shades_samples = Target::samples_type::shades_samples;
        const bool has_deposits = (target_.samples.deposited(block_) >> k & 1) != 0;
        const Rgba8 of_pixel = shades_samples ? surface.color : color_of(surface, k);
        colors.fill(of_pixel);
        const MaskDepths depths_of_mask(surface, x, y);
        std::uint64_t drawn = 0;
        for (int j = 0; j < 8; ++j) {
            const auto wanted = unsigned(inside >> (8 * j) & 255);
            if (wanted == 0) continue;
            if (shades_samples && !surface.is_flat()) {
                for (unsigned i = 0; i < 8; ++i) colors[i] = color_at(surface, k, unsigned(8 * j) + i);
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
            depths_of_mask.set_row(x, y, j, q);
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

  private:
    const Target& target_;
    const OpenBlock& block_;
};
