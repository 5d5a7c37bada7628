// Triages a block of triangles; compiled once for each width of vectors, see triangle_triage.hpp. There is no include
// guard; FARFIELD_LANES must be 1, 4 or 8, and the including namespace is for this file alone.

typedef float Floats __attribute__((vector_size(4 * FARFIELD_LANES)));
typedef std::int32_t Ints __attribute__((vector_size(4 * FARFIELD_LANES)));
typedef std::uint32_t Words __attribute__((vector_size(4 * FARFIELD_LANES)));

// The conditional operator works lane by lane, and compilers turn these into single instructions.
inline Floats lower(Floats a, Floats b) {
    return a < b ? a : b;
}
inline Floats upper(Floats a, Floats b) {
    return a > b ? a : b;
}

inline unsigned bits(Ints where) {
#if FARFIELD_LANES == 8 && defined(__x86_64__)
    return unsigned(__builtin_ia32_movmskps256(reinterpret_cast<Floats>(where)));
#elif FARFIELD_LANES == 4 && defined(__x86_64__)
    return unsigned(__builtin_ia32_movmskps(reinterpret_cast<Floats>(where)));
#else
    unsigned out = 0;
    for (unsigned lane = 0; lane < FARFIELD_LANES; ++lane) out |= unsigned(where[lane] & 1) << lane;
    return out;
#endif
}

inline Floats load(const float* p) {
    Floats v;
    __builtin_memcpy(&v, p, sizeof v);
    return v;
}
template <class V, class T>
inline void store(T* p, V v) {
    __builtin_memcpy(p, &v, sizeof v);
}

inline Ints snapped(Floats v) {
    // The constant is 1.5 * 2^23: the sum's last bit is worth one, and the bits below the constant's are the integer.
    // Unsigned, because values far outside the guard band wrap; those are clipped.
    return reinterpret_cast<Ints>(reinterpret_cast<Words>(v + snap_rounder) - snap_rounder_bits);
}

template <Depths depths, bool deposits>
inline TriageMasks triage(const TriangleBlock& block, const SampleProjection& projection, TriagedBlock& out) {
    TriageMasks masks{0, 0, 0, 0};
    const bool has_far_plane = projection.far_depth < std::numeric_limits<float>::infinity();
    for (unsigned first = 0; first < TriangleBlock::lanes; first += FARFIELD_LANES) {
        Floats x[3], y[3], q[3];
        Ints behind[3], beyond[3] = {Ints{}, Ints{}, Ints{}};
        for (unsigned c = 0; c < 3; ++c) {
            const Floats dx = load(block.v[3 * c] + first) - projection.anchor.x;
            const Floats dy = load(block.v[3 * c + 1] + first) - projection.anchor.y;
            const Floats dz = load(block.v[3 * c + 2] + first) - projection.anchor.z;
            const Floats depth = dx * projection.forward.x + dy * projection.forward.y + dz * projection.forward.z;
            x[c] = dx * projection.right.x + dy * projection.right.y + dz * projection.right.z;
            y[c] = dx * projection.down.x + dy * projection.down.y + dz * projection.down.z;
            // Each is SampleProjection's formula with what is 0 or 1 in it left out.
            if constexpr (depths == Depths::from_eye) {
                const Floats inverse = 1.0f / depth;
                x[c] *= inverse;
                y[c] *= inverse;
                q[c] = inverse * projection.q_of_inverse;
            } else if constexpr (depths == Depths::from_anchor) {
                const Floats inverse = 1.0f / (depth + projection.depth_bias);
                x[c] *= inverse;
                y[c] *= inverse;
                q[c] = inverse * (depth * projection.q_of_depth);
            } else {
                q[c] = depth * projection.q_of_depth;
            }
            x[c] += projection.offset_x;
            y[c] += projection.offset_y;
            behind[c] = depth < projection.near_depth;
            if (has_far_plane) beyond[c] = depth > projection.far_depth;
            store(out.x[c] + first, x[c]);
            store(out.y[c] + first, y[c]);
            store(out.q[c] + first, q[c]);
        }
        // Rounding keeps the order, so snapping the box suffices; corners are snapped where they matter.
        const Floats low_x = lower(lower(x[0], x[1]), x[2]), high_x = upper(upper(x[0], x[1]), x[2]);
        const Floats low_y = lower(lower(y[0], y[1]), y[2]), high_y = upper(upper(y[0], y[1]), y[2]);
        const float guard = SampleProjection::guard_band * 256;
        const Ints in_guard_band = (low_x > -guard) & (high_x < guard) & (low_y > -guard) & (high_y < guard);
        const Ints gone = (behind[0] & behind[1] & behind[2]) | (beyond[0] & beyond[1] & beyond[2]);
        const Ints clip =
            (~in_guard_band | behind[0] | behind[1] | behind[2] | beyond[0] | beyond[1] | beyond[2]) & ~gone;
        // A sample i is inside if 256 i + 128 is in [lowest, highest].
        const Ints x0 = (snapped(low_x) + 127) >> 8, x1 = (snapped(high_x) - 128) >> 8;
        const Ints y0 = (snapped(low_y) + 127) >> 8, y1 = (snapped(high_y) - 128) >> 8;
        const Ints holds_no_sample = (x0 > x1) | (y0 > y1) | (x0 >= projection.end_x) | (y0 >= projection.end_y) |
                                     (x1 < projection.first_x) | (y1 < projection.first_y);
        masks.draw |= bits(~(holds_no_sample | clip | gone)) << first;
        masks.clip |= bits(clip) << first;
        if constexpr (deposits) {
            const float limit = deposited_below * 256;
            const Ints is_small = (high_x - low_x < limit) & (high_y - low_y < limit);
            const Floats doubled_area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
            const Ints in_image = (high_x > projection.small_left) & (low_x < projection.small_right) &
                                  (high_y > projection.small_top) & (low_y < projection.small_bottom);
            masks.small_ones |= bits(is_small & in_image & (doubled_area != 0.0f) & ~(clip | gone)) << first;
            masks.front |= bits(doubled_area < 0.0f) << first;
            store(out.center_x + first, (x[0] + x[1] + x[2]) * (1.0f / 768));
            store(out.center_y + first, (y[0] + y[1] + y[2]) * (1.0f / 768));
            store(out.center_q + first, (q[0] + q[1] + q[2]) * (1.0f / 3));
            store(out.area + first, upper(doubled_area, -doubled_area) * 0x1p-17f);
        }
    }
    if (projection.is_mirrored) masks.front = ~masks.front;
    return masks;
}

template <bool deposits>
inline TriageMasks triage_any(const TriangleBlock& block, const SampleProjection& projection, TriagedBlock& out) {
    if (!projection.is_perspective) return triage<Depths::parallel, deposits>(block, projection, out);
    return projection.is_at_eye ? triage<Depths::from_eye, deposits>(block, projection, out)
                                : triage<Depths::from_anchor, deposits>(block, projection, out);
}
