// The samples that a triangle covers, several of a row at once; included by axis_masks.hpp, once for each width of
// vectors: simd.hpp.

typedef std::int32_t Lanes __attribute__((vector_size(4 * FARFIELD_LANES)));

/// One bit a lane.
FARFIELD_INLINE std::uint32_t not_negative(Lanes v) {
#if FARFIELD_LANES == 8
    return ~std::uint32_t(_mm256_movemask_ps(reinterpret_cast<__m256>(v))) & 255u;
#elif defined(__SSE2__)
    return ~std::uint32_t(_mm_movemask_ps(reinterpret_cast<__m128>(v))) & 15u;
#else
    std::uint32_t bits = 0;
    for (int i = 0; i < FARFIELD_LANES; ++i) bits |= std::uint32_t(v[i] >= 0) << i;
    return bits;
#endif
}

/// 0, step, 2 step and so on. Few machines multiply vectors of integers.
FARFIELD_INLINE Lanes multiples(std::int32_t step) {
#if FARFIELD_LANES == 8
    constexpr Lanes ones{0, -1, 0, -1, 0, -1, 0, -1}, twos{0, 0, -1, -1, 0, 0, -1, -1},
        fours{0, 0, 0, 0, -1, -1, -1, -1};
    const Lanes all = Lanes{} + step;
    return (all & ones) + ((all + all) & twos) + ((all * 4) & fours);
#else
    constexpr Lanes ones{0, -1, 0, -1}, twos{0, 0, -1, -1};
    const Lanes all = Lanes{} + step;
    return (all & ones) + ((all + all) & twos);
#endif
}

/// Coordinates reach 2^14, so that twice an area stays below 2^30.
FARFIELD_INLINE void scan(MaskRows& rows, const MaskCoordinates& along_u, const MaskCoordinates& along_v) {
    const int first_u = along_u.first, last_u = along_u.last, first_v = along_v.first, last_v = along_v.last;
    if (first_u > last_u || first_v > last_v) return;
    const std::int32_t(&u)[3] = along_u.at, (&v)[3] = along_v.at;
    const std::int32_t doubled_area = (u[1] - u[0]) * (v[2] - v[0]) - (u[2] - u[0]) * (v[1] - v[0]);
    if (doubled_area == 0) return;
    const int k[3] = {0, doubled_area > 0 ? 1 : 2, doubled_area > 0 ? 2 : 1};
    std::int32_t edge[3], by_u[3], by_v[3];
    for (int i = 0; i < 3; ++i) {
        const int from = k[(i + 1) % 3], to = k[(i + 2) % 3];
        const std::int32_t du = u[to] - u[from], dv = v[to] - v[from];
        // A sample on an edge belongs to one of the two triangles that share it.
        const std::int32_t bias = (dv < 0 || (dv == 0 && du > 0)) ? 0 : -1;
        edge[i] = du * (first_v * 256 - v[from]) - dv * (first_u * 256 - u[from]) + bias;
        by_u[i] = -dv * 256;
        by_v[i] = du * 256;
    }
    Lanes row0 = multiples(by_u[0]) + edge[0], row1 = multiples(by_u[1]) + edge[1], row2 = multiples(by_u[2]) + edge[2];
    const std::uint32_t inside = (2u << last_u) - (1u << first_u);
    for (int row = first_v; row <= last_v; ++row) {
        std::uint32_t bits = not_negative(row0 | row1 | row2) << first_u;
        if (last_u - first_u >= FARFIELD_LANES) {
            Lanes e0 = row0, e1 = row1, e2 = row2;
            for (int i = first_u + FARFIELD_LANES; i <= last_u; i += FARFIELD_LANES) {
                e0 += by_u[0] * FARFIELD_LANES;
                e1 += by_u[1] * FARFIELD_LANES;
                e2 += by_u[2] * FARFIELD_LANES;
                bits |= not_negative(e0 | e1 | e2) << i;
            }
        }
        rows[std::size_t(row)] |= bits & inside;
        row0 += by_v[0];
        row1 += by_v[1];
        row2 += by_v[2];
    }
}

/// Along the axes, then along the diagonals.
inline void add_triangle(MaskRows* rows, const MaskCoordinates (&at)[3]) {
    for (int axis = 0; axis < 3; ++axis) scan(rows[axis], at[(axis + 1) % 3], at[(axis + 2) % 3]);
    // Sheared along a diagonal, the box is twice as wide; coordinates are where it meets the middle of z.
    for (int diagonal = 0; diagonal < 2; ++diagonal) {
        MaskCoordinates u, v;
        for (int i = 0; i < 3; ++i) {
            const std::int32_t z = diagonal == 0 ? mask_side * 256 - at[2].at[i] : at[2].at[i];
            u.at[i] = (at[0].at[i] + z) >> 1;
            v.at[i] = (at[1].at[i] + z) >> 1;
        }
        u.find_samples();
        v.find_samples();
        scan(rows[3 + diagonal], u, v);
    }
}
