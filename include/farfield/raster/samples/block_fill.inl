// Fills blocks of samples with a triangle; compiled once for each width of vectors, see block_fill.hpp. There is no
// include guard; FARFIELD_LANES must be 1, 4 or 8, and the including namespace is for this file alone.

#include "farfield/raster/triangles/row_lanes.inl"

class TriangleInBlocks {
  public:
    TriangleInBlocks(SampleBlocks& blocks, const SnappedTriangle& t, std::int64_t doubled_area,
                     const SampleProjection& image, TriangleShade& shade)
        : blocks_(blocks), t_(t), doubled_area_(doubled_area), image_(image), shade_(shade) {}

    void fill() {
        const auto low = [](const std::int32_t(&v)[3]) { return std::min(std::min(v[0], v[1]), v[2]); };
        const auto high = [](const std::int32_t(&v)[3]) { return std::max(std::max(v[0], v[1]), v[2]); };
        const int left = image_.first_x, top = image_.first_y;
        x0_ = std::max((low(t_.x) + 127) >> 8, left) - left;
        y0_ = std::max((low(t_.y) + 127) >> 8, top) - top;
        x1_ = std::min((high(t_.x) - 128) >> 8, image_.end_x - 1) - left;
        y1_ = std::min((high(t_.y) - 128) >> 8, image_.end_y - 1) - top;
        if (x0_ > x1_ || y0_ > y1_) return;
        highest_ = std::max(std::max(t_.q[0], t_.q[1]), t_.q[2]);
        const int column0 = x0_ >> SampleBlocks::log2_side, column1 = x1_ >> SampleBlocks::log2_side;
        const int row0 = y0_ >> SampleBlocks::log2_side, row1 = y1_ >> SampleBlocks::log2_side;
        if (column1 - column0 < 4 && row1 - row0 < 4 && is_hidden(column0, row0, column1, row1)) return;
        if (x1_ - x0_ < few && y1_ - y0_ < few) return fill_few();
        set_edges(column0 * side, row0 * side);
        for (int e = 0; e < 3; ++e) {
            largest_[e] = (side - 1) * (std::max(by_x_[e], 0) + std::max(by_y_[e], 0));
            least_[e] = (side - 1) * (std::min(by_x_[e], 0) + std::min(by_y_[e], 0));
            for (int v = 0; v < vectors; ++v) across_[e][v] = numbered_from(v * FARFIELD_LANES) * by_x_[e];
        }
        is_small_ = x1_ - x0_ < 2 * side && y1_ - y0_ < 2 * side;
        for (int row = row0; row <= row1; ++row) {
            fill_blocks(row, column0, column1 - column0 + 1);
            for (int e = 0; e < 3; ++e) value_[e] += std::int64_t(by_y_[e]) * side;
        }
    }

  private:
    static constexpr int side = SampleBlocks::side, vectors = side / FARFIELD_LANES;
    static constexpr int few = 4;  ///< samples on a side

    /// In a crowd most triangles are, and the blocks tell before anything is set up.
    bool is_hidden(int column0, int row0, int column1, int row1) const {
        for (int row = row0; row <= row1; ++row) {
            for (int column = column0; column <= column1; ++column) {
                if (!(highest_ < blocks_.farthest(blocks_.index(column, row)))) return false;
            }
        }
        return true;
    }

    /// The commonest triangles far away hold one sample, if any: vectors would be set up for nothing.
    void fill_few() {
        set_edges(x0_, y0_);
        for (int y = y0_; y <= y1_; ++y) {
            std::int64_t a = value_[0], b = value_[1], c = value_[2];
            for (int x = x0_; x <= x1_; ++x, a += by_x_[0], b += by_x_[1], c += by_x_[2]) {
                if ((a | b | c) >= 0) fill_sample(x, y);
            }
            for (int e = 0; e < 3; ++e) value_[e] += by_y_[e];
        }
    }

    void fill_sample(int x, int y) {
        const int column = x >> SampleBlocks::log2_side, row = y >> SampleBlocks::log2_side;
        const std::size_t at = blocks_.index(column, row);
        if (highest_ < blocks_.farthest(at)) return;
        prepare();
        const int i = (y & (side - 1)) * side + (x & (side - 1));
        x += image_.first_x, y += image_.first_y;
        const float q = plane_.at(plane_.row(y), x);
        SampleBlocks::Samples& samples = blocks_.opened(at, column, row);
        if (q < samples.depth[i]) return;
        merge(samples.depth[i], samples.color[i], q, shade_.is_one_color ? color_ : shade_.at(shade_, x, y));
        blocks_.filled(at, q);
    }

    /// Sets edges to their values at a sample, relative to the upper left one.
    ///
    /// From sample to sample an edge changes by multiples of 256, so 1/256 of it, rounded down, has its sign: within
    /// blocks, 32 bits are then enough for the largest triangles.
    void set_edges(int x, int y) {
        for (int e = 0; e < 3; ++e) {
            const int a = e, b = (e + 1) % 3;
            const std::int32_t dx = t_.x[b] - t_.x[a], dy = t_.y[b] - t_.y[a];
            const Edge<std::int64_t> edge(t_.x[a], t_.y[a], t_.x[b], t_.y[b], x + image_.first_x, y + image_.first_y);
            value_[e] = edge.value >> 8;
            by_x_[e] = -dy;
            by_y_[e] = dx;
        }
    }

    /// Plane and color are wanted by few triangles in a crowd: most are hidden, or lie between samples.
    void prepare() {
        if (is_prepared_) return;
        is_prepared_ = true;
        plane_ = DepthPlane(t_, doubled_area_);
        // Overflow would make NaN, which no bound bounds.
        has_bounds_ = std::abs(plane_.by_x) < 1e30f && std::abs(plane_.by_y) < 1e30f;
        shade_.prepare(shade_);
        color_ = shade_.corners[0];
        blocks_.add_drawn(x0_, y0_, x1_ + 1, y1_ + 1);
    }

    void fill_blocks(int row, int column0, int count) {
        int first = 0, last = count - 1, first_full = 0, last_full = -1;
        const bool is_wide = count > 6;
        if (is_wide) {
            std::int64_t begin = 0, end = count - 1, full_begin = 0, full_end = count - 1;
            for (int e = 0; e < 3; ++e) {
                Edge<std::int64_t> edge(0, 0, 0, 0, 0, 0);
                edge.by_x = std::int64_t(by_x_[e]) * side;
                edge.narrow(value_[e] + largest_[e], begin, end);
                edge.narrow(value_[e] + least_[e], full_begin, full_end);
            }
            first = int(begin), last = int(end), first_full = int(full_begin), last_full = int(full_end);
        }
        std::int64_t value[3];
        for (int e = 0; e < 3; ++e) value[e] = value_[e] + std::int64_t(by_x_[e]) * side * first;
        for (int i = first; i <= last; ++i, step(value)) {
            bool is_full = i >= first_full && i <= last_full;
            if (!is_wide) {
                if (((value[0] + largest_[0]) | (value[1] + largest_[1]) | (value[2] + largest_[2])) < 0) continue;
                is_full = ((value[0] + least_[0]) | (value[1] + least_[1]) | (value[2] + least_[2])) >= 0;
            }
            const int column = column0 + i;
            const std::size_t at = blocks_.index(column, row);
            const float farthest = blocks_.farthest(at);
            if (highest_ < farthest) continue;
            if (is_full) {
                fill_full(at, column, row, farthest);
            } else {
                fill_part(at, column, row, farthest, value);
            }
        }
    }

    void step(std::int64_t (&value)[3]) const {
        for (int e = 0; e < 3; ++e) value[e] += std::int64_t(by_x_[e]) * side;
    }

    struct Bounds {
        float lower, upper;
    };
    /// Of q over samples. All steps of DepthPlane::at are monotone, roundings included, so corners tell.
    Bounds bounds(int x0, int y0, int x1, int y1) const {
        if (!has_bounds_) return {-std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity()};
        x0 += image_.first_x, x1 += image_.first_x, y0 += image_.first_y, y1 += image_.first_y;
        if (plane_.by_x < 0) std::swap(x0, x1);
        if (plane_.by_y < 0) std::swap(y0, y1);
        return {plane_.at(plane_.row(y0), x0), plane_.at(plane_.row(y1), x1)};
    }

    void fill_full(std::size_t at, int column, int row, float farthest) {
        prepare();
        const int x = column * side, y = row * side;
        const Bounds q = bounds(x, y, x + side - 1, y + side - 1);
        if (q.upper < farthest) return;
        if (shade_.is_one_color && has_bounds_) {
            const SampleBlocks::Block& b = blocks_.block(at);
            if (!blocks_.is_drawn(b) || q.lower > b.nearest) {
                return blocks_.set_surface(at, plane_, color_, q.lower, q.upper);
            }
        }
        Ints outside[side][vectors]{};
        merge_rows(blocks_.opened(at, column, row), x, y, 0, side - 1, outside);
        blocks_.filled(at, q.upper);
    }

    void fill_part(std::size_t at, int column, int row, float farthest, const std::int64_t (&value)[3]) {
        const int x = column * side, y = row * side;
        const int first = std::max(y0_ - y, 0), last = std::min(y1_ - y, side - 1);
        std::int32_t start[3];
        for (int e = 0; e < 3; ++e) {
            // Beyond this an edge keeps its sign all over the block.
            const std::int64_t most = std::int64_t(1) << 28;
            start[e] = std::int32_t(std::clamp(value[e], -most, most)) + by_y_[e] * first;
        }
        Ints outside[side][vectors];
        Ints nowhere = ~Ints{};
        for (int j = first; j <= last; ++j) {
            for (int v = 0; v < vectors; ++v) {
                outside[j][v] = (across_[0][v] + start[0]) | (across_[1][v] + start[1]) | (across_[2][v] + start[2]);
                nowhere &= outside[j][v];
            }
            for (int e = 0; e < 3; ++e) start[e] += by_y_[e];
        }
        if (!any(~nowhere)) return;
        prepare();
        float nearest = highest_;
        if (!is_small_) {
            nearest = bounds(std::max(x, x0_), y + first, std::min(x + side - 1, x1_), y + last).upper;
            if (nearest < farthest) return;
        }
        merge_rows(blocks_.opened(at, column, row), x, y, first, last, outside);
        blocks_.filled(at, nearest);
    }

    /// Writes rows [first, last] of the block at (x, y). The lanes whose sign bit `outside` has keep their samples.
    FARFIELD_INLINE void merge_rows(SampleBlocks::Samples& samples, int x, int y, int first, int last,
                                    const Ints (&outside)[side][vectors]) {
        x += image_.first_x, y += image_.first_y;
        // Copies, as the compiler has to expect that writing samples changes the originals.
        const DepthPlane plane = plane_;
        Floats columns[vectors], depths[vectors];
        float rows[side];
        for (int v = 0; v < vectors; ++v) {
            columns[v] = __builtin_convertvector(numbered_from(x + v * FARFIELD_LANES), Floats);
            depths[v] = plane.by_x * (columns[v] + plane.base_x);
            const Floats lines = __builtin_convertvector(numbered_from(y + v * FARFIELD_LANES), Floats);
            store(rows + v * FARFIELD_LANES, plane.at_corner + plane.by_y * (lines + plane.base_y));
        }
        const Floats lowest = Floats{} + plane.lowest, highest = Floats{} + plane.highest;
        const Words one = Words{} + std::bit_cast<std::uint32_t>(color_);
        const bool is_one_color = shade_.is_one_color;
        for (int j = first; j <= last; ++j) {
            for (int v = 0; v < vectors; ++v) {
                float* depth = samples.depth + j * side + v * FARFIELD_LANES;
                Rgba8* color = samples.color + j * side + v * FARFIELD_LANES;
                const Floats along = rows[j] + depths[v];
                const Floats q = along < lowest ? lowest : along > highest ? highest : along;
                const Floats old_q = load<Floats>(depth);
                Ints wins = ~(q < old_q) & (outside[j][v] >= 0);
                // Testing whether any wins in rows of one color costs more than writing what was there.
                if (!is_one_color && !any(wins)) continue;
                Words c = one;
                if (!is_one_color && !colors_of_row(y + j, columns[v], wins, c)) {
                    merge_each(depth, color, q, columns[v], y + j, wins);
                    continue;
                }
                const Words old_c = load<Words>(color);
                wins &= ~(q == old_q) | (c > old_c);
                store(depth, wins ? q : old_q);
                const Words replaced = reinterpret_cast<Words>(wins);
                store(color, (replaced & c) | (~replaced & old_c));
            }
        }
    }

    [[gnu::noinline]] void merge_each(float* depth, Rgba8* color, Floats q, Floats columns, int y, Ints wins) const {
        for (int lane = 0; lane < FARFIELD_LANES; ++lane) {
            if (wins[lane] != 0) merge(depth[lane], color[lane], q[lane], shade_.at(shade_, int(columns[lane]), y));
        }
    }

    [[gnu::noinline]] bool colors_of_row(int y, Floats columns, Ints wanted, Words& c) const {
        if (!shade_.is_opaque || FARFIELD_LANES == 1 || std::endian::native != std::endian::little) return false;
        return colors_at(columns, ColorsOfRow(*shade_.plane, shade_.corners, y), wanted, c);
    }

    /// Two at the same depth do not depend on their order.
    static void merge(float& depth, Rgba8& color, float q, Rgba8 c) {
        if (c.a == 0) return;
        c.a = 255;
        if (q == depth && std::bit_cast<std::uint32_t>(c) <= std::bit_cast<std::uint32_t>(color)) return;
        depth = q;
        color = c;
    }

    SampleBlocks& blocks_;
    const SnappedTriangle& t_;
    const std::int64_t doubled_area_;
    const SampleProjection& image_;
    TriangleShade& shade_;
    int x0_ = 0, y0_ = 0, x1_ = 0, y1_ = 0;  ///< its box in samples, ends included, relative to the upper left one
    float highest_ = 0;
    std::int64_t value_[3]{};  ///< of edges at the first block of a row
    std::int32_t by_x_[3]{}, by_y_[3]{}, largest_[3]{},
        least_[3]{};           ///< the last two over a block, from its first sample
    Ints across_[3][vectors];  ///< from the first column of a block
    bool is_small_ = false;    ///< all its q are then as good as one
    bool is_prepared_ = false, has_bounds_ = false;
    DepthPlane plane_;
    Rgba8 color_{0, 0, 0, 0};
};

inline void fill_blocks(SampleBlocks& blocks, const SnappedTriangle& t, std::int64_t doubled_area,
                        const SampleProjection& image, TriangleShade& shade) {
    TriangleInBlocks(blocks, t, doubled_area, image, shade).fill();
}
