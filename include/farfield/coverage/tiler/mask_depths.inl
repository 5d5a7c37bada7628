// Surfaces as the samples of one mask see them: depths, bit by bit those of a z-buffer, and colors. Compiled once for
// each instruction set: see coverage_tiler.inl.

/// A surface at work or of the A-buffer; neither is copied.
struct SeenSurface {
    const DepthPlane& depth;  ///< of one without a fold
    Surface* details;         ///< null for one that is flat and plane
    Rgba8 color;              ///< of one that is flat

    bool is_flat() const { return details == nullptr || details->is_flat; }
    bool is_folded() const { return details != nullptr && details->fold.thickness != 0; }
};

/// The depths of a mask's samples. Quadrilaterals need not be plane: they have the depths of the two triangles that a
/// z-buffer makes of them.
class MaskDepths {
    using EightFloats = MaskKernel::EightFloats;
    using EightInts = MaskKernel::EightInts;

  public:
    FARFIELD_INLINE MaskDepths(const SeenSurface& surface, int x, int y) : planes_{&surface.depth, nullptr} {
        if (surface.is_folded()) unfold(*surface.details, x, y);
    }

    /// Calls f(plane, samples) for the planes of one or two triangles, and the samples that lie on them.
    template <class F>
    FARFIELD_INLINE void for_planes(F&& f) const {
        f(*planes_[0], first_);
        if (first_ != all_subcells) f(*planes_[1], ~first_);
    }

    /// Sets q to row j of samples at (x, y). It is set in place: where vectors are wider than the target's, g++ warns
    /// of functions that return them.
    FARFIELD_INLINE void set_row(int x, int y, int j, EightFloats& q) const {
        set_row(*planes_[0], x, y + j, q);
        if (first_ == all_subcells) return;
        EightInts is_first;
        MaskKernel::lanes_of(unsigned(first_ >> (8 * j) & 255), is_first);
        EightFloats other;
        set_row(*planes_[1], x, y + j, other);
        q = is_first ? q : other;
    }

  private:
    FARFIELD_INLINE static void set_row(const DepthPlane& d, int x, int y, EightFloats& q) {
        q = d.row(y) + d.by_x * (EightFloats{0, 1, 2, 3, 4, 5, 6, 7} + float(x) + d.base_x);
        q = q < d.lowest ? EightFloats{} + d.lowest : q;
        q = q > d.highest ? EightFloats{} + d.highest : q;
    }

    /// Finds the planes on either side of a fold, and the samples that lie on the first one's.
    FARFIELD_INLINE void unfold(const Surface& surface, int x, int y) {
        const auto fold = surface.fold.edge(x, y);
        const std::int64_t across = 7 * fold.by_x, down = 7 * fold.by_y;
        const std::int64_t most = fold.value + std::max<std::int64_t>(across, 0) + std::max<std::int64_t>(down, 0),
                           least = fold.value + std::min<std::int64_t>(across, 0) + std::min<std::int64_t>(down, 0);
        planes_[0] = &surface.fold.planes[most >= 0 ? 0 : 1];
        if (most < 0 || least >= 0) return;
        planes_[1] = &surface.fold.planes[1];
        // The fold crosses the mask, and its value is small.
        first_ = MaskKernel::greater(std::int32_t(fold.by_x >> 8), std::int32_t(fold.by_y >> 8),
                                     ~std::int32_t(fold.value >> 8));
    }

    const DepthPlane* planes_[2];
    std::uint64_t first_ = all_subcells;
};
