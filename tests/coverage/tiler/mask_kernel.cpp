// Every instruction set makes the masks that the definitions say.
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>

#include "catch.hpp"
#include "farfield/coverage/tiler/coverage_tiler.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

namespace {
bool has_instructions(int lanes) {
#if defined(__x86_64__)
    return lanes <= lanes_for(Simd::automatic);
#else
    return lanes == 1;
#endif
}

struct alignas(64) Values {
    std::array<std::int32_t, 64> v;
};
struct alignas(64) Depths {
    std::array<float, 64> q;
};

/// Few different values, so that many are equal; infinities among them.
float any_depth(Random& random) {
    const std::uint32_t n = random.below(12);
    if (n < 2) return (n == 0 ? 1.0f : -1.0f) * std::numeric_limits<float>::infinity();
    return float(n) * 0.1f - 0.5f;
}

template <class Kernel>
void check_kernel(int lanes) {
    if (!has_instructions(lanes)) return;
    Random random(810);
    for (int i = 0; i < 4000; ++i) {
        // As edges have it: |a| + |b| below 2^24.
        const unsigned shift = random.below(24);
        const auto slope = [&] { return std::int32_t(random.below(2u << shift)) - (1 << shift); };
        const std::int32_t a = slope() / 2, b = slope() / 2;
        Values table;
        Kernel::tabulate(a, b, table.v.data());
        std::int32_t threshold = random.below(2) == 0 ? table.v[random.below(64)] : slope();
        if (i % 64 == 0) threshold = std::numeric_limits<std::int32_t>::max();
        if (i % 64 == 1) threshold = std::numeric_limits<std::int32_t>::min();
        const std::uint64_t greater = Kernel::greater(table.v.data(), threshold);

        // Without a table, thresholds are those of edges that cross the cell.
        const auto near = std::int32_t(random.below(1u << 29)) - (1 << 28);
        const std::int32_t close =
            random.below(2) == 0 ? table.v[random.below(64)] - std::int32_t(random.below(2)) : near;
        const std::uint64_t untabulated = Kernel::greater(a, b, close);

        Depths q;
        for (float& one : q.q) one = any_depth(random);
        const float limit = any_depth(random);
        const std::uint64_t nearer = Kernel::greater(q.q.data(), limit);

        alignas(64) float rows[8], columns[8];
        for (int k = 0; k < 8; ++k) {
            rows[k] = float(random.below(8)) * 0.1f;
            columns[k] = float(random.below(8)) * 0.1f - 0.4f;
        }
        const float lowest = float(random.below(5)) * 0.1f - 0.2f, highest = lowest + float(random.below(5)) * 0.1f;
        const std::uint64_t below = Kernel::plane_below(rows, columns, lowest, highest, q.q.data());
        const std::uint64_t above = Kernel::plane_above(rows, columns, lowest, highest, q.q.data());
        const std::int32_t as[3] = {a / 64, b / 64, (a - b) / 64}, bs[3] = {b / 64, -a / 64, (a + b) / 64},
                           es[3] = {close / 64, -close / 64, slope() / 8};
        const int edges = 1 + int(random.below(3));
        const std::uint64_t inside = Kernel::inside_all(as, bs, es, edges);
        for (std::int32_t k = 0; k < 64; ++k) {
            bool is_inside = true;
            for (int n = 0; n < edges; ++n) is_inside = is_inside && as[n] * (k % 8) + bs[n] * (k / 8) + es[n] >= 0;
            if ((inside >> k & 1) != (is_inside ? 1u : 0u)) FAIL(lanes << " lanes: inside all");
        }
        const std::uint64_t chosen = random.bits() & random.bits();
        Depths lowered = q, raised = q, assigned = q;
        using Update = typename Kernel::Update;
        Kernel::template update<Update::lower>(chosen, rows, columns, lowest, highest, lowered.q.data());
        Kernel::template update<Update::raise>(chosen, rows, columns, lowest, highest, raised.q.data());
        Kernel::template update<Update::assign>(chosen, rows, columns, lowest, highest, assigned.q.data());
        float least = q.q[0];
        for (const float one : q.q) least = std::min(least, one);
        if (Kernel::least(q.q.data()) != least) FAIL(lanes << " lanes: the least");
        for (unsigned k = 0; k < 64; ++k) {
            const auto x = std::int32_t(k % 8), y = std::int32_t(k / 8);
            const float plane = std::min(std::max(rows[y] + columns[x], lowest), highest);
            const bool is_chosen = (chosen >> k & 1) != 0;
            const bool is_right = table.v[k] == a * x + b * y && (greater >> k & 1) == (table.v[k] > threshold) &&
                                  (untabulated >> k & 1) == (table.v[k] > close) &&
                                  (nearer >> k & 1) == (q.q[k] > limit) && (below >> k & 1) == (plane < q.q[k]) &&
                                  (above >> k & 1) == (plane > q.q[k]) &&
                                  lowered.q[k] == (is_chosen ? std::min(plane, q.q[k]) : q.q[k]) &&
                                  raised.q[k] == (is_chosen ? std::max(plane, q.q[k]) : q.q[k]) &&
                                  assigned.q[k] == (is_chosen ? plane : q.q[k]);
            if (!is_right) FAIL(lanes << " lanes, " << k);
        }
        const std::uint64_t mask = random.bits() & random.bits();
        if (Kernel::count(mask) != std::popcount(mask)) FAIL("count of " << mask);
    }
    CHECK(Kernel::count(no_subcells) == 0);
    CHECK(Kernel::count(all_subcells) == 64);
}
}  // namespace

TEST_CASE("comparisons to masks, whatever the number of lanes", "[coverage]") {
    check_kernel<one_lane::MaskKernel>(1);
#if defined(__x86_64__)
    check_kernel<four_lanes::MaskKernel>(4);
    check_kernel<eight_lanes::MaskKernel>(8);
    check_kernel<sixteen_lanes::MaskKernel>(16);
#endif
}
