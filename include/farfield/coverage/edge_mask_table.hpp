// Gets an edge's masks as the paper does: by a table of where the edge crosses the cell's border (Greene 1996, sections
// 3, 4.2 and 9). Exact masks are faster on today's machines and lose nothing; they are compared with this.
#pragma once

#include "farfield/settings.hpp"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "farfield/coverage/triage_mask.hpp"

namespace farfield::detail {

/// Holds the masks of all edges that cross a square whose sides have 64 intervals each: an entry for each two intervals
/// not on one side, 576 KiB. Edges of opposite directions share entries (section 4.2). All machines build the same
/// table.
///
/// An edge is E(i, j) = e + 256 (a i + b j), 0 or more inside, at sample (i, j) counted from the cell's first one, with
/// |a|, |b| < 2^24, |e| < 2^50 and log2_subcell at most 15. The square reaches half a sample beyond the outer samples.
/// Edges that miss it, and those without a direction (a = b = 0), are all inside or all outside, exactly.
///
/// An edge and its reverse, (-e - 1, -a, -b), always give complementary masks: polygons on both sides of an edge leave
/// no gap and do not overlap along it. Where edges end within the square their lines no longer meet in a point: one in
/// 700 vertices where three polygons meet leaves a sample to none of them.
class EdgeMaskTable {
  public:
    static constexpr int intervals = 64;

    /// The first call, from any thread, builds the table in a few hundredths of a second. Keep the reference.
    static const EdgeMaskTable& instance() {
        static const EdgeMaskTable table;
        return table;
    }
    EdgeMaskTable(const EdgeMaskTable&) = delete;
    EdgeMaskTable& operator=(const EdgeMaskTable&) = delete;

    /// The mask of 8 x 8 subcells of 2^log2_subcell samples a side. It is conservative: covered subcells have E >= 0 at
    /// every sample, vacant ones at none. Edges in random places and directions make 10.1 of 64 subcells active; with
    /// exact masks it is 8.4 where a subcell has 8 samples a side, 9.4 where it has 64.
    TriageMask triage(std::int64_t e, std::int32_t a, std::int32_t b, int log2_subcell) const {
        const Crossing edge(e, a, b, log2_subcell);
        if (edge.parted == 0) return {~edge.complement, edge.complement};
        const Sides& sides = triage_[edge.entry()];
        const std::uint64_t exchanged = (sides.same ^ sides.other) & edge.complement;
        return {sides.same ^ exchanged, sides.other ^ exchanged};
    }

    /// The mask of 8 x 8 samples: those inside the edge through the middles of the intervals crossed. 15 % of edges in
    /// random places and directions get a wrong mask; 0.16 of 64 samples are wrong on average, 4 at most in a million
    /// edges.
    std::uint64_t samples(std::int64_t e, std::int32_t a, std::int32_t b) const {
        const Crossing edge(e, a, b, 0);
        return (edge.parted == 0 ? all_subcells : samples_[edge.entry()]) ^ edge.complement;
    }

  private:
    enum Side : std::uint8_t { top, bottom, left, right };
    struct SidePair {
        Side first, second;
    };
    /// Each pair is in the order that makes Line 0 or more at the square's corner (0, 0).
    static constexpr std::array<SidePair, 6> side_pairs{
        {{top, right}, {bottom, left}, {right, bottom}, {top, bottom}, {right, left}, {top, left}}};

    /// Where a side begins and whether E grows along it by a or b.
    struct Ray {
        std::uint8_t corner, axis;
    };
    struct Parting {
        std::uint8_t pair;  ///< index to side_pairs
        Ray first, second;
    };
    /// Indexed by which of the corners (1, 0), (0, 1) and (1, 1) are parted from (0, 0). For none the edge misses; the
    /// first two without the third never are.
    static constexpr std::array<Parting, 8> partings{{{},
                                                      {0, {0, 0}, {1, 1}},
                                                      {1, {2, 0}, {0, 1}},
                                                      {},
                                                      {2, {1, 1}, {2, 0}},
                                                      {3, {0, 0}, {2, 0}},
                                                      {4, {1, 1}, {0, 1}},
                                                      {5, {0, 0}, {0, 1}}}};

    /// Where an edge crosses the square. The edge is taken at E = -1/2, which passes between the integers that E is at
    /// samples and at ends of intervals: no case is left to chance, and the reverse takes the same line. All sums are
    /// integers below 2^53, which double precision adds exactly.
    struct Crossing {
        double value[3];           ///< 2 E + 1 at corners (0, 0), (1, 0) and (0, 1)
        double minus_interval[2];  ///< change over an interval along either axis, negated
        std::uint64_t complement;  ///< all ones: corner (0, 0) is outside
        unsigned parted;           ///< index to partings

        Crossing(std::int64_t e, std::int32_t a, std::int32_t b, int log2_subcell) {
            // An interval has an eighth of a subcell's samples, a sample has 256 units, and 2 E + 1 has E twice.
            const double units = double(std::int32_t(64) << log2_subcell);
            minus_interval[0] = -units * a;
            minus_interval[1] = -units * b;
            value[0] = double(2 * e + 1 - 256 * (std::int64_t(a) + b));
            value[1] = value[0] - intervals * minus_interval[0];
            value[2] = value[0] - intervals * minus_interval[1];
            const std::int64_t origin = bits(value[0]);
            const auto differs = [&](double v) { return unsigned(std::uint64_t(bits(v) ^ origin) >> 63); };
            complement = std::uint64_t(origin >> 63);
            parted =
                differs(value[1]) | differs(value[2]) << 1 | differs(value[1] - intervals * minus_interval[1]) << 2;
        }
        std::size_t entry() const {
            const Parting& p = partings[parted];
            return (p.pair * std::size_t(intervals) + interval(p.first)) * intervals + interval(p.second);
        }

      private:
        static std::int64_t bits(double v) { return std::bit_cast<std::int64_t>(v); }
        /// The quotient's distance to integers exceeds its rounding error.
        unsigned interval(Ray side) const { return unsigned(int(value[side.corner] / minus_interval[side.axis])); }
    };

    struct Point {
        int x, y;
    };
    struct Line {
        Point p, q;
        int operator()(int x, int y) const { return (q.x - p.x) * (y - p.y) - (q.y - p.y) * (x - p.x); }
        /// Bit 8 j + i: is sign * the line's value 0 or more at (first_x + step i, first_y + step j)?
        std::uint64_t mask(int sign, Point first, int step) const {
            const int by_x = -sign * step * (q.y - p.y), by_y = sign * step * (q.x - p.x);
            int row = sign * (*this)(first.x, first.y);
            std::uint64_t bits = 0;
            for (unsigned bit = 0; bit < 64; row += by_y) {
                for (int i = 0, v = row; i < 8; ++i, ++bit, v += by_x) bits |= std::uint64_t(v >= 0) << bit;
            }
            return bits;
        }
        /// The subcells, `step` wide, entirely on one side: their corner farthest towards the other side is on it.
        std::uint64_t subcells(int sign, int step) const {
            return mask(sign, {sign * (q.y - p.y) > 0 ? step : 0, sign * (q.x - p.x) < 0 ? step : 0}, step);
        }
    };

    /// The point at t half intervals from the side's beginning; 128 is the square's side.
    static Point on(Side side, int t) {
        if (side == top || side == bottom) return {t, side == top ? 0 : 2 * intervals};
        return {side == left ? 0 : 2 * intervals, t};
    }

    EdgeMaskTable() {
        constexpr int subcell = 2 * intervals / 8;
        std::size_t entry = 0;
        for (const auto& [s1, s2] : side_pairs) {
            // Two intervals span a quadrilateral; these two of its edges part it from the rest of the square.
            const int crossed = (s1 == top && s2 == right) || (s1 == bottom && s2 == left) ? 2 : 0;
            for (int t1 = 0; t1 < 2 * intervals; t1 += 2) {
                for (int t2 = 0; t2 < 2 * intervals; t2 += 2, ++entry) {
                    const Line one{on(s1, t1), on(s2, t2 + crossed)}, other{on(s1, t1 + 2), on(s2, t2 + 2 - crossed)};
                    triage_[entry] = {one.subcells(1, subcell) & other.subcells(1, subcell),
                                      one.subcells(-1, subcell) & other.subcells(-1, subcell)};
                    const Line middle{on(s1, t1 + 1), on(s2, t2 + 1)};
                    samples_[entry] = middle.mask(1, {subcell / 2, subcell / 2}, subcell);
                }
            }
        }
    }

    static constexpr std::size_t entries = side_pairs.size() * intervals * intervals;
    /// The subcells on the side of the square's corner (0, 0), and on the other side.
    struct Sides {
        std::uint64_t same, other;
    };
    std::array<Sides, entries> triage_;
    std::array<std::uint64_t, entries> samples_;
};

}  // namespace farfield::detail
