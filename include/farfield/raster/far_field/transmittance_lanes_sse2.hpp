// The same as transmittance_lanes.hpp, which explains it, eight lanes at a time with what every x86-64 has.
#pragma once

#include "farfield/settings.hpp"

#if defined(__SSE2__)

#include <emmintrin.h>

#include <cstdint>
#include <glm/vec3.hpp>

#include "farfield/geometry/area_law.hpp"
#include "farfield/raster/far_field/far_sample.hpp"

namespace farfield::detail {

namespace eight_lanes_at_a_time {

inline __m128i same(int v) {
    return _mm_set1_epi16(short(v));
}
inline __m128i load(const std::uint16_t* p) {
    return _mm_load_si128(reinterpret_cast<const __m128i*>(p));
}
inline void store(std::uint16_t* p, __m128i v) {
    _mm_store_si128(reinterpret_cast<__m128i*>(p), v);
}

/// Where the lanes of a small square's samples begin, in units, as they lie in registers.
struct Positions {
    alignas(16) std::uint16_t column[lanes::most_samples][8], row[lanes::most_samples][16];

    constexpr Positions() : column(), row() {
        for (unsigned sample = 0; sample < lanes::most_samples; ++sample) {
            for (unsigned i = 0; i < lanes::count; ++i) {
                column[sample][i % 8] = std::uint16_t((lanes::side * sample + i % lanes::side) * lanes::width);
                row[sample][i] = std::uint16_t((lanes::side * sample + i / lanes::side) * lanes::height);
            }
        }
    }
};
inline constexpr Positions positions{};

using Columns = __m128i;  ///< four widths, twice
struct Rows {
    __m128i upper, lower;
};

class Square {
  public:
    int x0, y0, x1, y1;

    Square(float left, float top, float right, float bottom, int width, int height) {
        const __m128 size = _mm_cvtepi32_ps(_mm_setr_epi32(width, height, width, height));
        // In this order _mm_max_ps gives the zero where the other is NaN.
        const __m128 v = _mm_min_ps(_mm_max_ps(_mm_setr_ps(left, top, right, bottom), _mm_setzero_ps()), size);
        // Half a unit inwards, so that no sample is touched but not covered.
        constexpr float x = 0.5f / lanes::sample_width, y = 0.5f / lanes::sample_height;
        const __m128 inner = _mm_add_ps(v, _mm_setr_ps(x, y, -x, -y));
        const __m128i sample = _mm_cvttps_epi32(_mm_min_ps(inner, _mm_sub_ps(size, _mm_set1_ps(1))));
        constexpr int w = lanes::sample_width, h = lanes::sample_height;
        const __m128 inside = _mm_mul_ps(_mm_sub_ps(v, _mm_cvtepi32_ps(sample)), _mm_setr_ps(w, h, w, h));
        const __m128i rest = _mm_cvttps_epi32(_mm_add_ps(inside, _mm_set1_ps(0.5f)));
        // The first samples' edges are at 0, the last ones' at their ends.
        at_border_ = _mm_movemask_ps(_mm_castsi128_ps(_mm_cmpeq_epi32(rest, _mm_setr_epi32(0, 0, w, h))));
        const __m128i from_first = _mm_sub_epi32(sample, _mm_shuffle_epi32(sample, 0x44));
        // Both factors are below 2^15.
        const __m128i at = _mm_add_epi32(rest, _mm_madd_epi16(from_first, _mm_setr_epi32(w, h, w, h)));
        is_empty_ = (_mm_movemask_ps(_mm_castsi128_ps(_mm_cmpgt_epi32(_mm_shuffle_epi32(at, 0xee), at))) & 3) != 3;
        left_ = _mm_shuffle_epi32(_mm_shufflelo_epi16(at, 0x00), 0x00);
        top_ = _mm_shuffle_epi32(_mm_shufflelo_epi16(at, 0xaa), 0x00);
        right_ = _mm_shuffle_epi32(_mm_shufflehi_epi16(at, 0x00), 0xaa);
        bottom_ = _mm_shuffle_epi32(_mm_shufflehi_epi16(at, 0xaa), 0xaa);
        x0 = _mm_cvtsi128_si32(sample);
        y0 = _mm_cvtsi128_si32(_mm_shuffle_epi32(sample, 0x55));
        x1 = _mm_cvtsi128_si32(_mm_shuffle_epi32(sample, 0xaa));
        y1 = _mm_cvtsi128_si32(_mm_shuffle_epi32(sample, 0xff));
    }
    bool is_empty() const { return is_empty_; }
    bool is_small() const { return x1 - x0 < lanes::most_samples && y1 - y0 < lanes::most_samples; }
    Columns columns(int i) const { return between(left_, right_, load(positions.column[i]), same(lanes::width)); }
    Rows rows(int i) const {
        return {between(top_, bottom_, load(positions.row[i]), same(lanes::height)),
                between(top_, bottom_, load(positions.row[i] + 8), same(lanes::height))};
    }
    bool starts_at_column() const { return (at_border_ & 1) != 0; }
    bool starts_at_row() const { return (at_border_ & 2) != 0; }
    bool ends_at_column() const { return (at_border_ & 4) != 0; }
    bool ends_at_row() const { return (at_border_ & 8) != 0; }

  private:
    static __m128i between(__m128i begin, __m128i end, __m128i at, __m128i lane) {
        return _mm_sub_epi16(_mm_min_epi16(_mm_subs_epu16(end, at), lane),
                             _mm_min_epi16(_mm_subs_epu16(begin, at), lane));
    }
    __m128i left_, top_, right_, bottom_;
    int at_border_;
    bool is_empty_;
};

inline __m128i product(__m128i a, __m128i b) {
    const __m128i high = _mm_mulhi_epu16(a, b), low = _mm_mullo_epi16(a, b);
    return _mm_add_epi16(high, _mm_srli_epi16(_mm_adds_epu16(low, high), 15));
}

class Deposit {
  public:
    Deposit(Loss loss, glm::vec3 rgb) : rgb_(_mm_setr_ps(rgb.x, rgb.y, rgb.z, -1)) {
        const __m128 part = _mm_max_ps(_mm_setr_ps(loss.relative, loss.absolute, 0, 0), _mm_setzero_ps());
        const __m128 scaled = _mm_mul_ps(_mm_min_ps(part, _mm_set1_ps(1)), _mm_set1_ps(float(lanes::one)));
        const __m128i rounded = _mm_cvttps_epi32(_mm_add_ps(scaled, _mm_set1_ps(0.5f)));
        const __m128i twice = _mm_shufflelo_epi16(rounded, 0xa0);
        relative_ = _mm_shuffle_epi32(twice, 0x00);
        absolute_ = _mm_shuffle_epi32(twice, 0x55);
    }

    bool into(FarSample& s, FarLanes& of, Columns columns, const Rows& rows) const {
        return into(s, of, left_of(load(of.lane), _mm_mullo_epi16(columns, rows.upper)),
                    left_of(load(of.lane + 8), _mm_mullo_epi16(columns, rows.lower)));
    }
    bool into(FarSample& s, FarLanes& of) const {
        // A loss that covers a lane whole is taken as it is: product(loss, 65535) is the loss.
        const __m128i upper = load(of.lane), lower = load(of.lane + 8);
        return into(s, of, _mm_subs_epu16(upper, loss_of(upper)), _mm_subs_epu16(lower, loss_of(lower)));
    }
    bool into(FarSample& s) const {
        const __m128i t = _mm_set1_epi32(lane_of(s.transmittance));
        const __m128i left = _mm_subs_epu16(t, loss_of(t));
        return take(s, _mm_slli_epi32(_mm_and_si128(left, _mm_set1_epi32(0xffff)), 4));
    }

  private:
    /// The lanes are then these.
    bool into(FarSample& s, FarLanes& of, __m128i upper, __m128i lower) const {
        store(of.lane, upper);
        store(of.lane + 8, lower);
        // Pairs can only be added as signed numbers, so 2^15 is taken from all first.
        const __m128i half = same(-32768), ones = same(1);
        const __m128i pairs = _mm_add_epi32(_mm_madd_epi16(_mm_xor_si128(upper, half), ones),
                                            _mm_madd_epi16(_mm_xor_si128(lower, half), ones));
        const __m128i fours = _mm_add_epi32(pairs, _mm_shuffle_epi32(pairs, 0x4e));
        const __m128i sum = _mm_add_epi32(fours, _mm_shuffle_epi32(fours, 0xb1));
        return take(s, _mm_add_epi32(sum, _mm_set1_epi32(lanes::count * 32768)));
    }
    /// `sum` is that of the lanes that are left, four times.
    bool take(FarSample& s, __m128i sum) const {
        const bool closes = _mm_cvtsi128_si32(sum) < lanes::closed;
        if (closes) sum = _mm_setzero_si128();
        const __m128 left = _mm_mul_ps(_mm_cvtepi32_ps(sum), _mm_set1_ps(1.0f / float(lanes::count * lanes::one)));
        const __m128 before = _mm_load_ps(&s.r);
        const __m128 taken = _mm_sub_ps(_mm_shuffle_ps(before, before, 0xff), left);
        _mm_store_ps(&s.r, _mm_add_ps(before, _mm_mul_ps(taken, rgb_)));
        return closes;
    }
    __m128i loss_of(__m128i t) const { return _mm_adds_epu16(_mm_mulhi_epu16(t, relative_), absolute_); }
    __m128i left_of(__m128i t, __m128i part) const { return _mm_subs_epu16(t, product(loss_of(t), part)); }
    __m128i relative_, absolute_;
    __m128 rgb_;
};

}  // namespace eight_lanes_at_a_time

}  // namespace farfield::detail

#endif
