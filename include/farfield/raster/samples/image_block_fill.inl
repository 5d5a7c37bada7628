// Fills a block of samples from an image that is kept; compiled once for each width of vectors, see
// image_block_fill.hpp. There is no include guard; FARFIELD_LANES must be 1, 4 or 8, and the including namespace is for
// this file alone.

#include "farfield/raster/triangles/row_lanes.inl"

typedef std::uint16_t Halves __attribute__((vector_size(4 * FARFIELD_LANES)));

/// Four bytes mixed at once: (256 - part) of a and `part` of b, in 1/256. Both weights come twice, in each half.
FARFIELD_INLINE Words mixed_bytes(Words a, Words b, Halves rest, Halves part) {
    constexpr std::uint32_t even = 0x00ff00ff;
    const Halves low_a = reinterpret_cast<Halves>(a & even), low_b = reinterpret_cast<Halves>(b & even);
    const Halves high_a = reinterpret_cast<Halves>(a) >> 8, high_b = reinterpret_cast<Halves>(b) >> 8;
    const Halves low = (low_a * rest + low_b * part + std::uint16_t(0x80)) >> 8;
    const Halves high = (high_a * rest + high_b * part + std::uint16_t(0x80)) & std::uint16_t(0xff00);
    return reinterpret_cast<Words>(low | high);
}

/// Something premultiplied that is to be opaque; where alpha is 0 the color means nothing.
FARFIELD_INLINE Words made_opaque(Words color) {
    const Floats factor = 255.0f / __builtin_convertvector(reinterpret_cast<Ints>(color >> 24), Floats);
    Words out = Words{} + 0xff000000u;
    for (unsigned channel = 0; channel < 3; ++channel) {
        const Ints byte = reinterpret_cast<Ints>(color >> (8 * channel) & 255u);
        const Floats lit = __builtin_convertvector(byte, Floats) * factor + 0.5f;
        const Ints whole = __builtin_convertvector(lit < 255.0f ? lit : Floats{} + 255.0f, Ints);
        out |= reinterpret_cast<Words>(whole) << (8 * channel);
    }
    return out;
}

/// Texels and their neighbors to the right.
FARFIELD_INLINE void load_pairs(const Rgba8* from, Ints at, Words& left, Words& right) {
#if FARFIELD_LANES == 1
    std::uint32_t pair[2];
    __builtin_memcpy(pair, from + at[0], sizeof pair);
    left = Words{pair[0]};
    right = Words{pair[1]};
#else
    typedef std::uint64_t Pairs __attribute__((vector_size(4 * FARFIELD_LANES)));
    const auto pair = [&](int lane) {
        std::uint64_t p;
        __builtin_memcpy(&p, from + at[lane], sizeof p);
        return p;
    };
#if FARFIELD_LANES == 4
    const Words a = reinterpret_cast<Words>(Pairs{pair(0), pair(1)});
    const Words b = reinterpret_cast<Words>(Pairs{pair(2), pair(3)});
    left = __builtin_shufflevector(a, b, 0, 2, 4, 6);
    right = __builtin_shufflevector(a, b, 1, 3, 5, 7);
#else
    const Words a = reinterpret_cast<Words>(Pairs{pair(0), pair(1), pair(4), pair(5)});
    const Words b = reinterpret_cast<Words>(Pairs{pair(2), pair(3), pair(6), pair(7)});
    left = __builtin_shufflevector(a, b, 0, 2, 8, 10, 4, 6, 12, 14);
    right = __builtin_shufflevector(a, b, 1, 3, 9, 11, 5, 7, 13, 15);
#endif
#endif
}

class BlockOfImage {
  public:
    BlockOfImage(SampleBuffers& buffers, const KeptImage& image, const ImageInBlock& in)
        : buffers_(buffers),
          image_(image),
          in_(in),
          at_(buffers.blocks().index(in.x >> SampleBlocks::log2_side, in.y >> SampleBlocks::log2_side)) {
        SampleBlocks& blocks = buffers.blocks();
        if (blocks.is_drawn(blocks.block(at_))) open();
    }

    bool fill() {
        for (int v = 0; v < vectors; ++v) {
            const Ints column = numbered_from(v * FARFIELD_LANES);
            wanted_[v] = (column >= in_.first) & (column < in_.end);
        }
        for (int row = in_.first_row; row <= in_.last_row; ++row) fill_row(row);
        float nearest = nothing;
        for (int lane = 0; lane < FARFIELD_LANES; ++lane) nearest = std::max(nearest, nearest_[lane]);
        if (nearest == nothing) return false;
        buffers_.blocks().filled_much(at_, nearest);
        return true;
    }

  private:
    static constexpr int side = SampleBlocks::side, vectors = side / FARFIELD_LANES;
    static constexpr float nothing = -std::numeric_limits<float>::infinity();

    void open() {
        samples_ = &buffers_.blocks().opened(at_, in_.x >> SampleBlocks::log2_side, in_.y >> SampleBlocks::log2_side);
    }

    void fill_row(int row) {
        const auto [a, c] = in_.left;
        const auto [b, d] = in_.right;
        const auto between = [&](std::int32_t from, std::int32_t to) { return from + (to - from) * row / side; };
        const float down = float(row) / side;
        const std::int32_t u = between(a.u, c.u), v = between(a.v, c.v);
        const std::int32_t u_step = (between(b.u, d.u) - u) / side, v_step = (between(b.v, d.v) - v) / side;
        const float q = a.q + (c.q - a.q) * down, q_step = (b.q + (d.q - b.q) * down - q) * (1.0f / side);
        for (int i = 0; i < vectors; ++i) {
            const Ints column = numbered_from(i * FARFIELD_LANES);
            // Rounded to 1/256.
            fill_lanes(row, i, column * u_step + (u + 128), column * v_step + (v + 128),
                       __builtin_convertvector(column, Floats) * q_step + q);
        }
    }

    FARFIELD_INLINE void fill_lanes(int row, int vector, Ints u, Ints v, Floats quad_q) {
        Ints column = u >> 16, line = v >> 16, wins = wanted_[vector];
        if (in_.end_part - in_.first_part < 64) wins &= is_in_part(row, vector);
        if (!in_.is_inside) {
            wins &= ~((column < 0) | (line < 0) | (column > image_.width) | (line > image_.height));
            if (!any(wins)) return;
            column &= wins;
            line &= wins;
            u &= wins;
            v &= wins;
        }
        const auto stride = std::int32_t(image_.stride());
        const Ints texel = line * stride + column;
        const Ints nearest_texel = texel + (u >> 15 & 1) + (v >> 15 & 1) * stride;
        Ints steps;
        for (int lane = 0; lane < FARFIELD_LANES; ++lane) {
            steps[lane] = image_.depth[std::size_t(std::uint32_t(nearest_texel[lane]))];
        }
        const Floats relative = __builtin_convertvector(steps, Floats) * image_.depth_step + image_.least_depth;
        const Floats q = in_.is_quotient ? (quad_q + in_.bias) * relative - in_.bias : quad_q + relative;
        const int first = row * side + vector * FARFIELD_LANES;
        Floats old_q = Floats{} + nothing;
        if (samples_ != nullptr) old_q = load<Floats>(samples_->depth + first);
        wins &= q > old_q;
        if (!any(wins)) return;
        Words c = color(texel, stride, u, v);
        const Ints alpha = reinterpret_cast<Ints>(c >> 24);
        if (image_.is_solid) {
            wins &= alpha >= 128;
            if (any(wins & (alpha < 255))) c = made_opaque(c);
        } else {
            const Ints partly = wins & (alpha > 0) & (alpha < 255);
            if (any(partly)) deposit(row, vector, q, c, partly);
            wins &= alpha == 255;
        }
        if (!any(wins)) return;
        // A block that nothing has been drawn into is opened only for something opaque.
        if (samples_ == nullptr) open();
        store(samples_->depth + first, wins ? q : load<Floats>(samples_->depth + first));
        const Words replaced = reinterpret_cast<Words>(wins);
        store(samples_->color + first, (replaced & c) | (~replaced & load<Words>(samples_->color + first)));
        const Floats won = wins ? q : Floats{} + nothing;
        nearest_ = won > nearest_ ? won : nearest_;
    }

    FARFIELD_INLINE Ints is_in_part(int row, int vector) const {
        const std::int32_t* orders = fade_orders.row[(in_.whole_y + row) & (side - 1)];
        const Ints order = load<Ints>(orders + (in_.whole_x & (side - 1)) + vector * FARFIELD_LANES);
        return (order >= in_.first_part) & (order < in_.end_part);
    }
    FARFIELD_INLINE static Halves weights(Ints of) {
        const Words part = reinterpret_cast<Words>(of) >> 8 & 255u;
        return reinterpret_cast<Halves>(part | part << 16);
    }
    FARFIELD_INLINE Words color(Ints texel, std::int32_t stride, Ints u, Ints v) const {
        Words upper[2], lower[2];
        load_pairs(image_.color.data(), texel, upper[0], upper[1]);
        load_pairs(image_.color.data() + stride, texel, lower[0], lower[1]);
        const Halves u_part = weights(u), v_part = weights(v);
        const Halves u_rest = std::uint16_t(256) - u_part, v_rest = std::uint16_t(256) - v_part;
        return mixed_bytes(mixed_bytes(upper[0], upper[1], u_rest, u_part),
                           mixed_bytes(lower[0], lower[1], u_rest, u_part), v_rest, v_part);
    }

    [[gnu::noinline]] void deposit(int row, int vector, Floats q, Words c, Ints where) {
        FarSamples::Eight deposits = buffers_.eight_deposits(in_.x, in_.y + row);
        for (int lane = 0; lane < FARFIELD_LANES; ++lane) {
            if (where[lane] == 0) continue;
            deposits.deposit(unsigned(vector * FARFIELD_LANES + lane), q[lane], std::bit_cast<Rgba8>(c[lane]));
        }
    }

    SampleBuffers& buffers_;
    const KeptImage& image_;
    const ImageInBlock& in_;
    const std::size_t at_;
    SampleBlocks::Samples* samples_ = nullptr;  ///< null while nothing was drawn
    Ints wanted_[vectors]{};                    ///< lanes that are filled
    Floats nearest_ = Floats{} + nothing;
};

inline bool fill_block(SampleBuffers& buffers, const KeptImage& image, const ImageInBlock& in) {
    return BlockOfImage(buffers, image, in).fill();
}
