// Surfaces as the samples of one mask see them: depths, bit by bit those of a z-buffer, and colors. Compiled once for each
// instruction set: see coverage_tiler.inl.

/// A surface at work or of the A-buffer; neither is copied.
struct SeenSurface {
    const DepthPlane& depth;  ///< of one without a fold
    Surface* details;         ///< null for one that is flat and plane
    Rgba8 color;              ///< of one that is flat

    bool is_flat() const { return details == nullptr || details->is_flat; }
    bool is_folded() const { return details != nullptr && details->fold.thickness != 0; }
};

/// The depths of a mask's samples, eight in a row. Quadrilaterals need not be plane: they have the depths of the two
/// triangles that a z-buffer makes of them. Depths are set in place: where vectors are wider than the target's, g++
/// warns of functions that return them.
class MaskDepths {
    using EightFloats = MaskKernel::EightFloats;
    using EightInts = MaskKernel::EightInts;

  public:
    FARFIELD_INLINE MaskDepths(const SeenSurface& surface, int x, int y) : y_(y), planes_{surface.depth, {}} {
        if (surface.is_folded()) [[unlikely]]
            unfold(*surface.details, x, y);
        set_columns(0, x);
        if (first_ != all_subcells) set_columns(1, x);
    }
    FARFIELD_INLINE void set_row(int j, EightFloats& q) const {
        set_row(0, j, q);
        if (first_ == all_subcells) return;
        EightInts is_first;
        MaskKernel::lanes_of(unsigned(first_ >> (8 * j) & 255), is_first);
        EightFloats other;
        set_row(1, j, other);
        q = is_first ? q : other;
    }

  private:
    FARFIELD_INLINE void set_columns(std::size_t plane, int x) {
        const DepthPlane& d = planes_[plane];
        columns_[plane] = d.by_x * (EightFloats{0, 1, 2, 3, 4, 5, 6, 7} + float(x) + d.base_x);
    }
    FARFIELD_INLINE void set_row(std::size_t plane, int j, EightFloats& q) const {
        const DepthPlane& d = planes_[plane];
        q = d.row(y_ + j) + columns_[plane];
        q = q < d.lowest ? EightFloats{} + d.lowest : q;
        q = q > d.highest ? EightFloats{} + d.highest : q;
    }

    /// Finds the planes on either side of a fold, and the samples that lie on the first one's.
    [[gnu::noinline]] void unfold(const Surface& surface, int x, int y) {
        const SnappedTriangle& t = surface.triangle;
        const auto fold = surface.fold.edge(x, y);
        const std::int64_t across = 7 * fold.by_x, down = 7 * fold.by_y;
        const bool has_first =
                       std::max({fold.value, fold.value + across, fold.value + down, fold.value + across + down}) >= 0,
                   has_other =
                       std::min({fold.value, fold.value + across, fold.value + down, fold.value + across + down}) < 0;
        const SnappedTriangle& other = surface.fold.other;
        if (has_first) planes_[0] = DepthPlane(t, t.doubled_area());
        if (has_other) planes_[has_first ? 1 : 0] = DepthPlane(other, other.doubled_area());
        if (!(has_first && has_other)) return;
        for (unsigned k = 0; k < 64; ++k) {
            if (fold.value + fold.by_x * int(k % 8) + fold.by_y * int(k / 8) < 0) first_ &= ~bit_of(k);
        }
    }

    int y_;
    std::array<DepthPlane, 2> planes_;
    EightFloats columns_[2];
    std::uint64_t first_ = all_subcells;
};
