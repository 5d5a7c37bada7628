// Packs sixty-four comparisons into a mask; compiled once for each instruction set, see coverage_tiler.hpp. There is no
// include guard; FARFIELD_LANES must be 1, 4, 8 or 16, and the including namespace is for these files alone.

struct MaskKernel {
    /// Eight lanes on any processor: compilers take several registers where these are narrower.
    typedef float EightFloats __attribute__((vector_size(32)));
    typedef std::int32_t EightInts __attribute__((vector_size(32)));
    typedef std::uint32_t EightWords __attribute__((vector_size(32)));

    /// Bit k: v[k] > threshold.
    static std::uint64_t greater(const std::int32_t* v, std::int32_t threshold) {
#if FARFIELD_LANES == 16
        const __m512i t = _mm512_set1_epi32(threshold);
        return joined(_mm512_cmpgt_epi32_mask(_mm512_load_si512(v), t),
                      _mm512_cmpgt_epi32_mask(_mm512_load_si512(v + 16), t),
                      _mm512_cmpgt_epi32_mask(_mm512_load_si512(v + 32), t),
                      _mm512_cmpgt_epi32_mask(_mm512_load_si512(v + 48), t));
#elif FARFIELD_LANES == 8
        const __m256i t = _mm256_set1_epi32(threshold);
        std::uint64_t mask = 0;
        for (unsigned k = 0; k < 8; ++k) {
            const __m256i part = _mm256_cmpgt_epi32(_mm256_load_si256(reinterpret_cast<const __m256i*>(v + 8 * k)), t);
            mask |= std::uint64_t(std::uint32_t(_mm256_movemask_ps(_mm256_castsi256_ps(part)))) << (8 * k);
        }
        return mask;
#elif FARFIELD_LANES == 4
        const __m128i t = _mm_set1_epi32(threshold);
        std::uint64_t mask = 0;
        for (unsigned k = 0; k < 4; ++k) {
            const auto* p = reinterpret_cast<const __m128i*>(v + 16 * k);
            const __m128i a = _mm_packs_epi32(_mm_cmpgt_epi32(p[0], t), _mm_cmpgt_epi32(p[1], t));
            const __m128i b = _mm_packs_epi32(_mm_cmpgt_epi32(p[2], t), _mm_cmpgt_epi32(p[3], t));
            mask |= std::uint64_t(std::uint32_t(_mm_movemask_epi8(_mm_packs_epi16(a, b)))) << (16 * k);
        }
        return mask;
#else
        std::uint64_t mask = 0;
        for (unsigned k = 0; k < 64; ++k) mask |= std::uint64_t(v[k] > threshold) << k;
        return mask;
#endif
    }

    /// Sets the words of 64 whose bits are set: see PortableStores.
    static void store_selected(std::uint64_t* words, std::uint64_t bits, std::uint64_t value) {
#if FARFIELD_LANES == 16
        const __m512i v = _mm512_set1_epi64(std::int64_t(value));
        for (unsigned j = 0; j < 8; ++j) _mm512_mask_storeu_epi64(words + 8 * j, __mmask8(bits >> 8 * j), v);
#else
        PortableStores::store_selected(words, bits, value);
#endif
    }
    static void store_selected(std::uint32_t* words, std::uint64_t bits, std::uint32_t value) {
#if FARFIELD_LANES == 16
        const __m512i v = _mm512_set1_epi32(std::int32_t(value));
        for (unsigned j = 0; j < 4; ++j) _mm512_mask_storeu_epi32(words + 16 * j, __mmask16(bits >> 16 * j), v);
#else
        PortableStores::store_selected(words, bits, value);
#endif
    }

    /// Sixty-four numbers that are compared with many thresholds.
    class Numbers {
      public:
        FARFIELD_INLINE explicit Numbers(const std::int32_t* v) {
#if FARFIELD_LANES == 16
            for (unsigned k = 0; k < 4; ++k) v_[k] = _mm512_load_si512(v + 16 * k);
#else
            v_ = v;
#endif
        }
        /// Bit k: number k is above the threshold.
        FARFIELD_INLINE std::uint64_t greater(std::int32_t threshold) const {
#if FARFIELD_LANES == 16
            const __m512i t = _mm512_set1_epi32(threshold);
            return joined(_mm512_cmpgt_epi32_mask(v_[0], t), _mm512_cmpgt_epi32_mask(v_[1], t),
                          _mm512_cmpgt_epi32_mask(v_[2], t), _mm512_cmpgt_epi32_mask(v_[3], t));
#else
            return MaskKernel::greater(v_, threshold);
#endif
        }

      private:
#if FARFIELD_LANES == 16
        __m512i v_[4];
#else
        const std::int32_t* v_;
#endif
    };

    /// Bit k: v[k] > threshold.
    static std::uint64_t greater(const float* v, float threshold) {
#if FARFIELD_LANES == 16
        const __m512 t = _mm512_set1_ps(threshold);
        return joined(_mm512_cmp_ps_mask(_mm512_load_ps(v), t, _CMP_GT_OQ),
                      _mm512_cmp_ps_mask(_mm512_load_ps(v + 16), t, _CMP_GT_OQ),
                      _mm512_cmp_ps_mask(_mm512_load_ps(v + 32), t, _CMP_GT_OQ),
                      _mm512_cmp_ps_mask(_mm512_load_ps(v + 48), t, _CMP_GT_OQ));
#elif FARFIELD_LANES == 8
        const __m256 t = _mm256_set1_ps(threshold);
        std::uint64_t mask = 0;
        for (unsigned k = 0; k < 8; ++k) {
            const __m256 part = _mm256_cmp_ps(_mm256_load_ps(v + 8 * k), t, _CMP_GT_OQ);
            mask |= std::uint64_t(std::uint32_t(_mm256_movemask_ps(part))) << (8 * k);
        }
        return mask;
#elif FARFIELD_LANES == 4
        const __m128 t = _mm_set1_ps(threshold);
        std::uint64_t mask = 0;
        for (unsigned k = 0; k < 16; ++k) {
            const __m128 part = _mm_cmpgt_ps(_mm_load_ps(v + 4 * k), t);
            mask |= std::uint64_t(std::uint32_t(_mm_movemask_ps(part))) << (4 * k);
        }
        return mask;
#else
        std::uint64_t mask = 0;
        for (unsigned k = 0; k < 64; ++k) mask |= std::uint64_t(v[k] > threshold) << k;
        return mask;
#endif
    }

    /// Bit 8 * j + i: rows[j] + columns[i], clamped to [lowest, highest], is below limits[8 * j + i].
    static std::uint64_t plane_below(const float* rows, const float* columns, float lowest, float highest,
                                     const float* limits) {
        return compare_plane<false>(rows, columns, lowest, highest, limits);
    }
    /// The same for above.
    static std::uint64_t plane_above(const float* rows, const float* columns, float lowest, float highest,
                                     const float* limits) {
        return compare_plane<true>(rows, columns, lowest, highest, limits);
    }

    /// Bit 8 * j + i: value + by_x i + by_y j is below `low`, or above `high`. With NaN among them it is neither.
    static void split(float value, float by_x, float by_y, float low, float high, std::uint64_t& below,
                      std::uint64_t& above) {
#if FARFIELD_LANES == 16
        const __m512 i = _mm512_set_ps(7, 6, 5, 4, 3, 2, 1, 0, 7, 6, 5, 4, 3, 2, 1, 0);
        const __m512 j = _mm512_set_ps(1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0);
        __m512 v = _mm512_add_ps(_mm512_add_ps(_mm512_mul_ps(i, _mm512_set1_ps(by_x)), _mm512_set1_ps(value)),
                                 _mm512_mul_ps(j, _mm512_set1_ps(by_y)));
        const __m512 two_rows = _mm512_set1_ps(2 * by_y), l = _mm512_set1_ps(low), h = _mm512_set1_ps(high);
        __mmask16 is_below[4], is_above[4];
        for (unsigned k = 0; k < 4; ++k, v = _mm512_add_ps(v, two_rows)) {
            is_below[k] = _mm512_cmp_ps_mask(v, l, _CMP_LT_OQ);
            is_above[k] = _mm512_cmp_ps_mask(v, h, _CMP_GT_OQ);
        }
        below = joined(is_below[0], is_below[1], is_below[2], is_below[3]);
        above = joined(is_above[0], is_above[1], is_above[2], is_above[3]);
#else
        const EightFloats columns = EightFloats{0, 1, 2, 3, 4, 5, 6, 7} * by_x + value;
        below = above = 0;
        for (int j = 0; j < 8; ++j) {
            const EightFloats v = columns + by_y * float(j);
            below |= std::uint64_t(byte_of(v < low)) << (8 * j);
            above |= std::uint64_t(byte_of(v > high)) << (8 * j);
        }
#endif
    }

    /// Bit 8 * j + i: at sample (x + i, y + j), as DepthPlane::at computes it, q of plane d is above that of plane o,
    /// or the same.
    static void compare(const DepthPlane& d, const DepthPlane& o, int x, int y, std::uint64_t& above,
                        std::uint64_t& equal) {
#if FARFIELD_LANES == 16
        const __m512 i = _mm512_set_ps(7, 6, 5, 4, 3, 2, 1, 0, 7, 6, 5, 4, 3, 2, 1, 0);
        const __m512 j = _mm512_set_ps(1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0);
        const __m512 at_x = _mm512_add_ps(i, _mm512_set1_ps(float(x))),
                     at_y = _mm512_add_ps(j, _mm512_set1_ps(float(y)));
        const auto columns = [&](const DepthPlane& p) {
            return _mm512_mul_ps(_mm512_set1_ps(p.by_x), _mm512_add_ps(at_x, _mm512_set1_ps(p.base_x)));
        };
        const auto depths = [&](const DepthPlane& p, __m512 column, __m512 row_y) {
            const __m512 row =
                _mm512_add_ps(_mm512_set1_ps(p.at_corner),
                              _mm512_mul_ps(_mm512_set1_ps(p.by_y), _mm512_add_ps(row_y, _mm512_set1_ps(p.base_y))));
            return _mm512_maskz_min_ps(all,
                                       _mm512_maskz_max_ps(all, _mm512_add_ps(row, column), _mm512_set1_ps(p.lowest)),
                                       _mm512_set1_ps(p.highest));
        };
        const __m512 d_columns = columns(d), o_columns = columns(o);
        __mmask16 is_above[4], is_equal[4];
        for (int k = 0; k < 4; ++k) {
            const __m512 row_y = _mm512_add_ps(at_y, _mm512_set1_ps(float(2 * k)));
            const __m512 q = depths(d, d_columns, row_y), r = depths(o, o_columns, row_y);
            is_above[k] = _mm512_cmp_ps_mask(q, r, _CMP_GT_OQ);
            is_equal[k] = _mm512_cmp_ps_mask(q, r, _CMP_EQ_OQ);
        }
        above = joined(is_above[0], is_above[1], is_above[2], is_above[3]);
        equal = joined(is_equal[0], is_equal[1], is_equal[2], is_equal[3]);
#else
        const EightFloats i = EightFloats{0, 1, 2, 3, 4, 5, 6, 7} + float(x);
        const EightFloats d_columns = d.by_x * (i + d.base_x), o_columns = o.by_x * (i + o.base_x);
        above = equal = 0;
        for (int j = 0; j < 8; ++j) {
            EightFloats q = d.row(y + j) + d_columns, r = o.row(y + j) + o_columns;
            q = q < d.lowest ? EightFloats{} + d.lowest : q;
            q = q > d.highest ? EightFloats{} + d.highest : q;
            r = r < o.lowest ? EightFloats{} + o.lowest : r;
            r = r > o.highest ? EightFloats{} + o.highest : r;
            above |= std::uint64_t(byte_of(q > r)) << (8 * j);
            equal |= std::uint64_t(byte_of(q == r)) << (8 * j);
        }
#endif
    }

    enum class Update { lower, raise, assign };

    /// Lowers or raises limits[8 * j + i] to rows[j] + columns[i], clamped to [lowest, highest], or sets it, where bit
    /// 8 * j + i is set.
    template <Update how>
    static void update(std::uint64_t bits, const float* rows, const float* columns, float lowest, float highest,
                       float* limits) {
#if FARFIELD_LANES == 16
        const __m512 c = _mm512_maskz_broadcast_f32x8(all, _mm256_load_ps(columns));
        const __m512 low = _mm512_set1_ps(lowest), high = _mm512_set1_ps(highest);
        for (; bits != 0; bits >>= 16, rows += 2, limits += 16) {
            const __m512 two_rows = _mm512_maskz_insertf32x8(all, _mm512_set1_ps(rows[0]), _mm256_set1_ps(rows[1]), 1);
            const __m512 q = _mm512_maskz_min_ps(all, _mm512_maskz_max_ps(all, _mm512_add_ps(two_rows, c), low), high);
            const __m512 old = _mm512_load_ps(limits);
            const auto wanted = __mmask16(bits & 0xffff);
            if constexpr (how == Update::lower) {
                _mm512_store_ps(limits, _mm512_mask_min_ps(old, wanted, old, q));
            } else if constexpr (how == Update::raise) {
                _mm512_store_ps(limits, _mm512_mask_max_ps(old, wanted, old, q));
            } else {
                _mm512_store_ps(limits, _mm512_mask_mov_ps(old, wanted, q));
            }
        }
#else
        EightFloats c, limit;
        __builtin_memcpy(&c, columns, sizeof c);
        for (; bits != 0; bits >>= 8, ++rows, limits += 8) {
            if ((bits & 255) == 0) continue;
            EightFloats q = *rows + c;
            q = q < lowest ? EightFloats{} + lowest : q;
            q = q > highest ? EightFloats{} + highest : q;
            EightInts is_wanted;
            lanes_of(unsigned(bits & 255), is_wanted);
            __builtin_memcpy(&limit, limits, sizeof limit);
            if constexpr (how == Update::lower) {
                is_wanted &= q < limit;
            } else if constexpr (how == Update::raise) {
                is_wanted &= q > limit;
            }
            limit = is_wanted ? q : limit;
            __builtin_memcpy(limits, &limit, sizeof limit);
        }
#endif
    }

    /// Turns each bit of a byte into all bits of a lane; byte_of() turns them back.
    static void lanes_of(unsigned byte, EightInts& lanes) {
        const EightInts bit = {1, 2, 4, 8, 16, 32, 64, 128};
        lanes = ((bit & std::int32_t(byte)) != 0);
    }
    static unsigned byte_of(const EightInts& lanes) {
#if FARFIELD_LANES >= 8
        return unsigned(_mm256_movemask_ps(reinterpret_cast<__m256>(lanes)));
#elif FARFIELD_LANES == 4
        __m128 half[2];
        __builtin_memcpy(half, &lanes, sizeof half);
        return unsigned(_mm_movemask_ps(half[0]) | _mm_movemask_ps(half[1]) << 4);
#else
        unsigned byte = 0;
        for (unsigned i = 0; i < 8; ++i) byte |= unsigned(lanes[i] & 1) << i;
        return byte;
#endif
    }

    /// The least of 64.
    static float least(const float* q) {
        EightFloats least, next;
        __builtin_memcpy(&least, q, sizeof least);
        for (unsigned j = 1; j < 8; ++j) {
            __builtin_memcpy(&next, q + 8 * j, sizeof next);
            least = next < least ? next : least;
        }
        return least_of(least);
    }
    static float least_of(const EightFloats& lanes) {
        float least = lanes[0];
        for (int i = 1; i < 8; ++i) least = std::min(least, lanes[i]);
        return least;
    }

    static int count(std::uint64_t mask) {
#if FARFIELD_LANES >= 8
        return __builtin_popcountll(mask);
#else
        // Without an instruction for it, compilers call a function.
        mask -= mask >> 1 & 0x5555555555555555u;
        mask = (mask & 0x3333333333333333u) + (mask >> 2 & 0x3333333333333333u);
        mask = (mask + (mask >> 4)) & 0x0f0f0f0f0f0f0f0fu;
        return int(mask * 0x0101010101010101u >> 56);
#endif
    }

    /// Bit 8 * j + i: a * i + b * j > threshold. This is for few masks, where a table would not pay.
    static std::uint64_t greater(std::int32_t a, std::int32_t b, std::int32_t threshold) {
#if FARFIELD_LANES == 16
        const __m512i i = _mm512_set_epi32(7, 6, 5, 4, 3, 2, 1, 0, 7, 6, 5, 4, 3, 2, 1, 0);
        const __m512i j = _mm512_set_epi32(b, b, b, b, b, b, b, b, 0, 0, 0, 0, 0, 0, 0, 0);
        const __m512i v = _mm512_add_epi32(_mm512_mullo_epi32(i, _mm512_set1_epi32(a)), j);
        const auto rows_from = [&](int row) {
            return _mm512_cmpgt_epi32_mask(v, _mm512_set1_epi32(threshold - row * b));
        };
        return joined(rows_from(0), rows_from(2), rows_from(4), rows_from(6));
#elif FARFIELD_LANES == 8
        const __m256i v = _mm256_mullo_epi32(_mm256_set_epi32(7, 6, 5, 4, 3, 2, 1, 0), _mm256_set1_epi32(a));
        std::uint64_t mask = 0;
        for (int j = 0; j < 8; ++j) {
            const __m256i row = _mm256_cmpgt_epi32(v, _mm256_set1_epi32(threshold - j * b));
            mask |= std::uint64_t(std::uint32_t(_mm256_movemask_ps(_mm256_castsi256_ps(row)))) << (8 * j);
        }
        return mask;
#elif FARFIELD_LANES == 4
        const __m128i left = _mm_set_epi32(3 * a, 2 * a, a, 0), right = _mm_add_epi32(left, _mm_set1_epi32(4 * a));
        std::uint64_t mask = 0;
        for (int j = 0; j < 8; j += 2) {
            const __m128i t = _mm_set1_epi32(threshold - j * b), u = _mm_set1_epi32(threshold - j * b - b);
            const __m128i one = _mm_packs_epi32(_mm_cmpgt_epi32(left, t), _mm_cmpgt_epi32(right, t));
            const __m128i two = _mm_packs_epi32(_mm_cmpgt_epi32(left, u), _mm_cmpgt_epi32(right, u));
            mask |= std::uint64_t(std::uint32_t(_mm_movemask_epi8(_mm_packs_epi16(one, two)))) << (8 * j);
        }
        return mask;
#else
        std::uint64_t mask = 0;
        for (std::int32_t k = 0; k < 64; ++k) mask |= std::uint64_t(a * (k & 7) + b * (k >> 3) > threshold) << k;
        return mask;
#endif
    }

    /// Bit 8 * j + i: a[n] * i + b[n] * j + e[n] is 0 or more for all n < count, which is 1 to 6. Nothing overflows.
    static std::uint64_t inside_all(const std::int32_t* a, const std::int32_t* b, const std::int32_t* e, int count) {
#if FARFIELD_LANES == 16
        const __m512i i = _mm512_set_epi32(7, 6, 5, 4, 3, 2, 1, 0, 7, 6, 5, 4, 3, 2, 1, 0);
        __m512i rows[4] = {_mm512_setzero_si512(), _mm512_setzero_si512(), _mm512_setzero_si512(),
                           _mm512_setzero_si512()};
        for (int n = 0; n < count; ++n) {
            const __m512i two_rows = _mm512_set1_epi32(2 * b[n]);
            __m512i v = _mm512_add_epi32(
                _mm512_mullo_epi32(i, _mm512_set1_epi32(a[n])),
                _mm512_maskz_inserti64x4(0xff, _mm512_set1_epi32(e[n]), _mm256_set1_epi32(e[n] + b[n]), 1));
            for (auto& row : rows) {
                row = _mm512_or_si512(row, v);  // its sign is set if any is negative
                v = _mm512_add_epi32(v, two_rows);
            }
        }
        return ~joined(_mm512_movepi32_mask(rows[0]), _mm512_movepi32_mask(rows[1]), _mm512_movepi32_mask(rows[2]),
                       _mm512_movepi32_mask(rows[3]));
#else
        EightInts rows[8] = {};
        for (int n = 0; n < count; ++n) {
            EightInts v = EightInts{0, 1, 2, 3, 4, 5, 6, 7} * a[n] + e[n];
            for (auto& row : rows) {
                row |= v;
                v += b[n];
            }
        }
        std::uint64_t outside = 0;
        for (unsigned j = 0; j < 8; ++j) outside |= std::uint64_t(byte_of(rows[j] < 0)) << (8 * j);
        return ~outside;
#endif
    }

    /// v[8 * j + i] = a * i + b * j.
    static void tabulate(std::int32_t a, std::int32_t b, std::int32_t* v) {
#if FARFIELD_LANES == 16
        const __m512i i = _mm512_set_epi32(7, 6, 5, 4, 3, 2, 1, 0, 7, 6, 5, 4, 3, 2, 1, 0);
        const __m512i j = _mm512_set_epi32(b, b, b, b, b, b, b, b, 0, 0, 0, 0, 0, 0, 0, 0);
        const __m512i two_rows = _mm512_set1_epi32(2 * b);
        __m512i row = _mm512_add_epi32(_mm512_mullo_epi32(i, _mm512_set1_epi32(a)), j);
        for (unsigned k = 0; k < 4; ++k, row = _mm512_add_epi32(row, two_rows)) _mm512_store_si512(v + 16 * k, row);
#elif FARFIELD_LANES == 8
        const __m256i by_row = _mm256_set1_epi32(b);
        __m256i row = _mm256_mullo_epi32(_mm256_set_epi32(7, 6, 5, 4, 3, 2, 1, 0), _mm256_set1_epi32(a));
        for (unsigned k = 0; k < 8; ++k, row = _mm256_add_epi32(row, by_row)) {
            _mm256_store_si256(reinterpret_cast<__m256i*>(v + 8 * k), row);
        }
#elif FARFIELD_LANES == 4
        const __m128i by_row = _mm_set1_epi32(b);
        __m128i left = _mm_set_epi32(3 * a, 2 * a, a, 0), right = _mm_add_epi32(left, _mm_set1_epi32(4 * a));
        for (unsigned k = 0; k < 8; ++k) {
            _mm_store_si128(reinterpret_cast<__m128i*>(v + 8 * k), left);
            _mm_store_si128(reinterpret_cast<__m128i*>(v + 8 * k + 4), right);
            left = _mm_add_epi32(left, by_row);
            right = _mm_add_epi32(right, by_row);
        }
#else
        for (std::int32_t k = 0; k < 64; ++k) v[k] = a * (k & 7) + b * (k >> 3);
#endif
    }

  private:
    template <bool above>
    static std::uint64_t compare_plane(const float* rows, const float* columns, float lowest, float highest,
                                       const float* limits) {
        std::uint64_t mask = 0;
#if FARFIELD_LANES >= 8
        constexpr int comparison = above ? _CMP_GT_OQ : _CMP_LT_OQ;
        const __m256 c = _mm256_load_ps(columns), low = _mm256_set1_ps(lowest), high = _mm256_set1_ps(highest);
        for (unsigned j = 0; j < 8; ++j) {
            const __m256 q = _mm256_min_ps(_mm256_max_ps(_mm256_add_ps(_mm256_set1_ps(rows[j]), c), low), high);
            const __m256 is_set = _mm256_cmp_ps(q, _mm256_load_ps(limits + 8 * j), comparison);
            mask |= std::uint64_t(std::uint32_t(_mm256_movemask_ps(is_set))) << (8 * j);
        }
#elif FARFIELD_LANES == 4
        const __m128 low = _mm_set1_ps(lowest), high = _mm_set1_ps(highest);
        for (unsigned k = 0; k < 16; ++k) {
            const __m128 sum = _mm_add_ps(_mm_set1_ps(rows[k / 2]), _mm_load_ps(columns + k % 2 * 4));
            const __m128 q = _mm_min_ps(_mm_max_ps(sum, low), high), limit = _mm_load_ps(limits + 4 * k);
            const __m128 is_set = above ? _mm_cmpgt_ps(q, limit) : _mm_cmplt_ps(q, limit);
            mask |= std::uint64_t(std::uint32_t(_mm_movemask_ps(is_set))) << (4 * k);
        }
#else
        for (unsigned k = 0; k < 64; ++k) {
            const float q = std::min(std::max(rows[k / 8] + columns[k % 8], lowest), highest);
            mask |= std::uint64_t(above ? q > limits[k] : q < limits[k]) << k;
        }
#endif
        return mask;
    }

#if FARFIELD_LANES == 16
    /// Without a mask g++ 12 warns of its own headers.
    static constexpr __mmask16 all = 0xffff;

    static std::uint64_t joined(__mmask16 a, __mmask16 b, __mmask16 c, __mmask16 d) {
        return _mm512_kunpackd(_mm512_kunpackw(d, c), _mm512_kunpackw(b, a));
    }
#endif
};
