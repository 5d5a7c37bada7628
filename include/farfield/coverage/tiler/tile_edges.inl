// A polygon over cells of the pyramid: its bounding box, its edges, and the masks that they composite to (Greene 1996,
// sections 3 and 4.3). Compiled once for each instruction set: see coverage_tiler.inl.
//
// An edge is an integer function E(i, j) = e + 256 (a i + b j) of samples, 0 or more inside, e at the first sample of
// the cell in question. Of a subcell of s x s samples, E is least and greatest in corners: with low = min(a, 0) +
// min(b, 0), it is covered iff e + 256 s (a i + b j) + 256 (s - 1) low >= 0, which is (a i + b j) + base >= 0 with base
// rounded down. So the 64 numbers a i + b j serve every level, and a mask is one comparison of them with a base. That
// is exact, where the paper's table of edges quantized to 64 intervals a side is not.

inline std::uint64_t bit_of(unsigned k) {
    return std::uint64_t(1) << k;
}

/// The samples of a polygon's bounding box inside the image, ends included.
struct TileBox {
    int x0 = 0, y0 = 0, x1 = -1, y1 = -1;
    std::int32_t span = 0;  ///< the larger side, even beyond the image, in 1/256 sample

    template <class Target>
    TileBox(const Target& target, const TilePolygon& polygon, int grown_by) {
        grown_by += Target::reach_of_samples;
        // A sample i is inside if 256 i + 128 is in [lowest, highest].
        std::int32_t low_x = polygon.x[0], high_x = low_x, low_y = polygon.y[0], high_y = low_y;
        for (int c = 1; c < polygon.corners; ++c) {
            low_x = std::min(low_x, polygon.x[std::size_t(c)]);
            high_x = std::max(high_x, polygon.x[std::size_t(c)]);
            low_y = std::min(low_y, polygon.y[std::size_t(c)]);
            high_y = std::max(high_y, polygon.y[std::size_t(c)]);
        }
        span = std::max(high_x - low_x, high_y - low_y);
        x0 = std::max(((low_x - grown_by + 127) >> 8) - target.first_x, 0);
        y0 = std::max(((low_y - grown_by + 127) >> 8) - target.first_y, 0);
        x1 = std::min(((high_x + grown_by - 128) >> 8) - target.first_x, target.pyramid.width_samples() - 1);
        y1 = std::min(((high_y + grown_by - 128) >> 8) - target.first_y, target.pyramid.height_samples() - 1);
    }

    /// The subcells of a cell that the box touches.
    std::uint64_t subcells(int level, int x, int y) const {
        const int shift = 3 * level;
        const int left = std::max((x0 >> shift) - 8 * x, 0), right = std::min((x1 >> shift) - 8 * x, 7);
        const int top = std::max((y0 >> shift) - 8 * y, 0), bottom = std::min((y1 >> shift) - 8 * y, 7);
        return left > right || top > bottom ? no_subcells : subcells_of_rect(left, top, right, bottom);
    }
    bool is_empty() const { return x0 > x1 || y0 > y1; }
    bool spans_two_masks_a_side() const {
        return span < 1 << 13 && (x1 >> 3) - (x0 >> 3) <= 1 && (y1 >> 3) - (y0 >> 3) <= 1;
    }
    /// Triage pays only if it saves looking at many masks.
    bool spans_few_masks() const {
        return span < 1 << 16 && ((x1 >> 3) - (x0 >> 3) + 1) * ((y1 >> 3) - (y0 >> 3) + 1) <= 16;
    }
};

template <class Target>
class TileEdges {
    static constexpr int most_edges = TilePolygon::most_corners;

  public:
    /// The edges that cross a cell, and their values at its first sample.
    struct Edges {
        int count = 0;
        std::array<std::uint8_t, most_edges> edge;
        std::array<std::int64_t, most_edges> e;
    };
    struct Triage {
        std::uint64_t covered = all_subcells;   ///< by the polygon: samples all inside
        std::uint64_t possible = all_subcells;  ///< in the bounding box and not wholly outside one edge
        Edges edges;                            ///< that cross the cell, and the subcells that they cross
        std::array<std::uint64_t, most_edges> crossed;
    };
    /// The edges' values at a block's first sample, in 32 bits.
    using FewMasks = std::array<std::int32_t, most_edges>;

    TileEdges(const Target& target, const TilePolygon& polygon, int grown_by)
        : box(target, polygon, grown_by), target_(target), polygon_(polygon) {}

    const TileBox box;

    /// Call this before anything below, and tabulate() too unless the polygon spans few masks.
    void prepare(int grown_by) {
        for_edges([&](std::size_t from, std::int32_t dx, std::int32_t dy, int bias) {
            const auto n = std::size_t(count_++);
            a_[n] = -dy;
            b_[n] = dx;
            e_[n] = std::int64_t(dx) * (256 * std::int64_t(target_.first_y) + 128 - polygon_.y[from]) -
                    std::int64_t(dy) * (256 * std::int64_t(target_.first_x) + 128 - polygon_.x[from]) + bias +
                    std::int64_t(grown_by) * (std::abs(dx) + std::abs(dy));
        });
    }
    void tabulate() {
        for (int n = 0; n < count_; ++n) MaskKernel::tabulate(a_[std::size_t(n)], b_[std::size_t(n)], values_[n]);
    }

    Edges at(int level, int x, int y) const {
        // If an edge of a huge polygon passes far from a small cell, its value only has to stay far from 0.
        const std::int64_t limit = std::int64_t(1) << (28 + 8 + 3 * level);
        Edges edges;
        edges.count = count_;
        for (int n = 0; n < count_; ++n) {
            const auto at = std::size_t(n);
            const std::int64_t e =
                e_[at] + ((std::int64_t(a_[at]) * x + std::int64_t(b_[at]) * y) << (8 + 3 * (level + 1)));
            edges.edge[at] = std::uint8_t(n);
            edges.e[at] = std::clamp(e, -limit, limit);
        }
        return edges;
    }

    /// The edges that cross subcell k, at its first sample.
    Edges inside(const Triage& t, unsigned k, int level) const {
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

    /// "Composite the edge masks" (section 3, operation 1) to the polygon's mask in a cell; false if it lies outside.
    FARFIELD_INLINE bool triage(int level, int x, int y, const Edges& in, Triage& out) const {
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
        out.possible &= box.subcells(level, x, y);
        return true;
    }

    /// The samples of mask k of block (x, y) that lie inside an edge whose value at the block's first sample is e.
    std::uint64_t samples_inside(std::uint8_t edge, std::int64_t e, int x, int y, unsigned k) const {
        if constexpr (Target::masks == MaskSource::exact) {
            // The edge crosses the block: e is below 2^38, for |a| + |b| < 2^24.
            return MaskKernel::greater(values_[edge], ~(std::int32_t(e >> 8) + values_[edge][k] * 8));
        } else {
            const std::int64_t at_first = e + std::int64_t(values_[edge][k]) * 2048;
            if constexpr (Target::masks == MaskSource::table) {
                return EdgeMaskTable::instance().samples(at_first, a_[edge], b_[edge]);
            } else {
                return samples(target_.patterns.pattern_of(target_.left_px + 8 * x + int(k % 8),
                                                           target_.top_px + 8 * y + int(k / 8)),
                               at_first, a_[edge], b_[edge]);
            }
        }
    }
    /// The same for the n-th edge of a block that it crosses, as a function of k: where masks are exact, what all masks
    /// share is found once.
    FARFIELD_INLINE auto samples_inside_one(const Triage& t, int n, int x, int y) const {
        const std::uint8_t edge = t.edges.edge[std::size_t(n)];
        const std::int64_t e = t.edges.e[std::size_t(n)];
        if constexpr (Target::masks == MaskSource::exact) {
            return [numbers = MaskKernel::Numbers(values_[edge]), v = values_[edge],
                    base = std::int32_t(e >> 8)](unsigned k) { return numbers.greater(~(base + v[k] * 8)); };
        } else {
            return [=, this](unsigned k) { return samples_inside(edge, e, x, y, k); };
        }
    }
    /// The samples that lie inside all edges.
    std::uint64_t samples_inside(const Triage& t, int x, int y, unsigned k) const {
        std::uint64_t inside = all_subcells;
        for (int n = 0; n < t.edges.count; ++n) {
            if ((t.crossed[std::size_t(n)] >> k & 1) == 0) continue;
            inside &= samples_inside(t.edges.edge[std::size_t(n)], t.edges.e[std::size_t(n)], x, y, k);
        }
        return inside;
    }

    /// For polygons that span few masks: needs no triage and no table.
    FewMasks few_masks_at(int x, int y) const {
        FewMasks base;
        for (int n = 0; n < count_; ++n) {
            const auto at = std::size_t(n);
            base[at] = std::int32_t((e_[at] + ((std::int64_t(a_[at]) * x + std::int64_t(b_[at]) * y) << 14)) >> 8);
        }
        return base;
    }
    std::uint64_t samples_inside(const FewMasks& base, unsigned k) const {
        FewMasks e;
        for (int n = 0; n < count_; ++n) {
            const auto at = std::size_t(n);
            e[at] = base[at] + (a_[at] * std::int32_t(k % 8) + b_[at] * std::int32_t(k / 8)) * 8;
        }
        return MaskKernel::inside_all(a_.data(), b_.data(), e.data(), count_);
    }

    /// The edges of a polygon that spans two by two masks at most, from mask (x, y) of the image on.
    struct TinyEdges {
        int count = 0;
        std::array<std::int32_t, most_edges> a, b, e;
    };
    TinyEdges tiny_at(int x, int y) const {
        TinyEdges edges;
        const std::int32_t first_x = 256 * (8 * x + target_.first_x) + 128,
                           first_y = 256 * (8 * y + target_.first_y) + 128;
        for_edges([&](std::size_t from, std::int32_t dx, std::int32_t dy, int bias) {
            const auto n = std::size_t(edges.count++);
            edges.a[n] = -dy;
            edges.b[n] = dx;
            edges.e[n] = (dx * (first_y - polygon_.y[from]) - dy * (first_x - polygon_.x[from]) + bias) >> 8;
        });
        return edges;
    }
    /// The samples of mask (x, y) from there on.
    static std::uint64_t samples_inside(const TinyEdges& edges, int x, int y) {
        std::array<std::int32_t, most_edges> e;
        for (int n = 0; n < edges.count; ++n) {
            const auto at = std::size_t(n);
            e[at] = edges.e[at] + (edges.a[at] * x + edges.b[at] * y) * 8;
        }
        return MaskKernel::inside_all(edges.a.data(), edges.b.data(), e.data(), edges.count);
    }

  private:
    /// Calls f(corner, dx, dy, bias) for the edges from each corner to the next.
    template <class F>
    FARFIELD_INLINE void for_edges(F&& f) const {
        for (int c = 0; c < polygon_.corners; ++c) {
            const auto from = std::size_t(c), to = std::size_t(c + 1 < polygon_.corners ? c + 1 : 0);
            const std::int32_t dx = polygon_.x[to] - polygon_.x[from], dy = polygon_.y[to] - polygon_.y[from];
            if (dx == 0 && dy == 0) continue;
            // Samples on an edge belong to the polygon that has it at its top or left (raster/scan_conversion.hpp).
            f(from, dx, dy, dy < 0 || (dy == 0 && dx > 0) ? 0 : -1);
        }
    }
    std::int32_t low(unsigned edge) const { return std::min(a_[edge], 0) + std::min(b_[edge], 0); }
    std::int32_t high(unsigned edge) const { return std::max(a_[edge], 0) + std::max(b_[edge], 0); }

    const Target& target_;
    const TilePolygon& polygon_;
    int count_ = 0;
    std::array<std::int32_t, most_edges> a_, b_;
    std::array<std::int64_t, most_edges> e_;           ///< at the image's first sample
    alignas(64) std::int32_t values_[most_edges][64];  ///< a i + b j
};
