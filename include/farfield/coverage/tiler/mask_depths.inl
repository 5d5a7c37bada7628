// Depths of the samples of one mask. Quadrilaterals need not be plane: they have the depths of the two triangles that a
// z-buffer makes of them. Compiled once for each instruction set: see coverage_tiler.inl.

/// The depths of a mask's samples, eight in a row, bit by bit those of a z-buffer. They are set in place: where
/// vectors are wider than the target's, g++ warns of functions that return them.
class MaskDepths {
    using EightFloats = MaskKernel::EightFloats;
    using EightInts = MaskKernel::EightInts;

  public:
    MaskDepths(const Surface& surface, int x, int y) : y_(y), planes_{surface.depth, {}} {
        if (surface.fold.thickness != 0) [[unlikely]]
            unfold(surface, x, y);
        const auto set_columns = [&](unsigned plane) {
            const DepthPlane& d = planes_[plane];
            columns_[plane] = d.by_x * (EightFloats{0, 1, 2, 3, 4, 5, 6, 7} + float(x) + d.base_x);
        };
        set_columns(0);
        if (first_ != all_subcells) set_columns(1);
    }
    void set_row(int j, EightFloats& q) const {
        set_row(0, j, q);
        if (first_ == all_subcells) return;
        EightInts is_first;
        MaskKernel::lanes_of(unsigned(first_ >> (8 * j) & 255), is_first);
        EightFloats other;
        set_row(1, j, other);
        q = is_first ? q : other;
    }

  private:
    void set_row(std::size_t plane, int j, EightFloats& q) const {
        const DepthPlane& d = planes_[plane];
        q = d.row(y_ + j) + columns_[plane];
        q = q < d.lowest ? EightFloats{} + d.lowest : q;
        q = q > d.highest ? EightFloats{} + d.highest : q;
    }

    /// Finds the planes on either side of a fold, and the samples that lie on the first one's.
    [[gnu::noinline]] void unfold(const Surface& surface, int x, int y) {
        const SnappedTriangle& t = surface.triangle;
        const auto fold = surface.fold.edge(t, x, y);
        const std::int64_t across = 7 * fold.by_x, down = 7 * fold.by_y;
        const bool has_first =
                       std::max({fold.value, fold.value + across, fold.value + down, fold.value + across + down}) >= 0,
                   has_other =
                       std::min({fold.value, fold.value + across, fold.value + down, fold.value + across + down}) < 0;
        const SnappedTriangle other = surface.fold.beyond(t);
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
