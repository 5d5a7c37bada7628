#include "farfield/coverage/edge_mask_table.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <thread>
#include <utility>
#include <vector>

#include "catch.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

namespace {

struct TestEdge {
    std::int64_t e;
    std::int32_t a, b;

    std::int64_t at(std::int64_t i, std::int64_t j) const { return e + 256 * (a * i + b * j); }
    TestEdge reversed() const { return {-e - 1, -a, -b}; }
};

/// Through (x, y), in 1/256 sample from the square's corner, in direction (dx, dy); inside is to the right of it on the
/// screen, as the triangles' edges are.
TestEdge through(std::int64_t x, std::int64_t y, std::int32_t dx, std::int32_t dy) {
    const std::int64_t bias = dy < 0 || (dy == 0 && dx > 0) ? 0 : -1;
    return {dx * (128 - y) - dy * (128 - x) + bias, -dy, dx};
}

/// Through a random point of a square of 8 << log2_subcell samples, any direction, short or long.
TestEdge random_edge(Random& random, int log2_subcell) {
    const float scale = float(2048 << log2_subcell);
    const auto x = std::int64_t(random.unit() * scale), y = std::int64_t(random.unit() * scale);
    const float angle = random.between(0, 6.2831853f), length = std::exp(random.between(5, 13));
    const auto dx = std::int32_t(length * std::cos(angle)), dy = std::int32_t(length * std::sin(angle));
    return through(x, y, dx == 0 && dy == 0 ? 1 : dx, dy);
}

std::uint64_t exact_samples(const TestEdge& edge) {
    std::uint64_t mask = 0;
    for (int k = 0; k < 64; ++k) mask |= std::uint64_t(edge.at(k % 8, k / 8) >= 0) << k;
    return mask;
}

/// By the outermost samples of each subcell: E is linear.
TriageMask exact_triage(const TestEdge& edge, int log2_subcell) {
    const std::int64_t side = std::int64_t(1) << log2_subcell;
    TriageMask mask{0, 0};
    for (int k = 0; k < 64; ++k) {
        const std::int64_t i = k % 8 * side, j = k / 8 * side, last = side - 1;
        const auto [low, high] =
            std::minmax({edge.at(i, j), edge.at(i + last, j), edge.at(i, j + last), edge.at(i + last, j + last)});
        mask.covered |= std::uint64_t(low >= 0) << k;
        mask.vacant |= std::uint64_t(high < 0) << k;
    }
    return mask;
}

bool is_conservative(const TriageMask& mask, const TriageMask& exact) {
    return (mask.covered & ~exact.covered) == 0 && (mask.vacant & ~exact.vacant) == 0;
}

/// Edges whose masks, or those of their reverse, break what is promised.
struct Failures {
    int not_conservative = 0, triage_not_complementary = 0, samples_not_complementary = 0;

    void add(const TestEdge& edge, int log2_subcell) {
        const EdgeMaskTable& table = EdgeMaskTable::instance();
        const TestEdge back = edge.reversed();
        const TriageMask mask = table.triage(edge.e, edge.a, edge.b, log2_subcell);
        const TriageMask reverse = table.triage(back.e, back.a, back.b, log2_subcell);
        not_conservative += !is_conservative(mask, exact_triage(edge, log2_subcell));
        triage_not_complementary += !(reverse == TriageMask{mask.vacant, mask.covered});
        samples_not_complementary += table.samples(back.e, back.a, back.b) != ~table.samples(edge.e, edge.a, edge.b);
    }
    bool none() const {
        return not_conservative == 0 && triage_not_complementary == 0 && samples_not_complementary == 0;
    }
};

/// Steep and flat, both ways, and those that divide intervals evenly or by a hair.
std::vector<std::pair<std::int32_t, std::int32_t>> directions() {
    std::vector<std::pair<std::int32_t, std::int32_t>> all;
    const std::int32_t lengths[] = {0, 1, 2, 3, 63, 64, 65, 255, 256, 257, 4096, 65535, 1 << 20, (1 << 24) - 1};
    for (const std::int32_t x : lengths) {
        for (const std::int32_t y : lengths) {
            if (x != 0 || y != 0) all.insert(all.end(), {{x, y}, {-x, y}, {x, -y}, {-x, -y}});
        }
    }
    return all;
}

}  // namespace

TEST_CASE("Edge mask table: what triage says of random edges is true of their samples") {
    Random random(1);
    for (const int log2_subcell : {0, 1, 3, 6, 10}) {
        Failures failures;
        for (int n = 0; n < 20000; ++n) failures.add(random_edge(random, log2_subcell), log2_subcell);
        CAPTURE(log2_subcell, failures.not_conservative, failures.triage_not_complementary,
                failures.samples_not_complementary);
        CHECK(failures.none());
    }
}

TEST_CASE("Edge mask table: edges through corners, centers of samples and ends of intervals, and a hair beside them") {
    for (const int log2_subcell : {0, 3}) {
        Failures failures;
        const std::int64_t side = std::int64_t(2048) << log2_subcell;
        const std::int64_t along[] = {0,        1,        side / 64, side / 16, side / 8,   side / 8 + 1,
                                      side / 2, side - 1, side,      128,       side - 128, 32};
        for (const auto& [dx, dy] : directions()) {
            for (const std::int64_t t : along) {
                for (const TestEdge& edge : {through(t, 0, dx, dy), through(t, side, dx, dy), through(0, t, dx, dy),
                                             through(side, t, dx, dy), through(t, t, dx, dy)}) {
                    for (const std::int64_t hair : {-1, 0, 1}) {
                        failures.add({edge.e + hair, edge.a, edge.b}, log2_subcell);
                    }
                }
            }
        }
        CAPTURE(log2_subcell, failures.not_conservative, failures.triage_not_complementary,
                failures.samples_not_complementary);
        CHECK(failures.none());
    }
}

TEST_CASE("Edge mask table: the largest coefficients, cells and distances") {
    Random random(2);
    Failures failures;
    const std::int32_t most = (1 << 24) - 1;
    for (int n = 0; n < 20000; ++n) {
        const auto a = std::int32_t(random.between(-1, 1) * float(most)),
                   b = std::int32_t(random.between(-1, 1) * float(most));
        const int log2_subcell = int(random.below(16));
        // Somewhere between the values at opposite corners, or just beyond.
        const std::int64_t reach = (std::int64_t(std::abs(a)) + std::abs(b)) << (11 + log2_subcell);
        const std::int64_t limit = (std::int64_t(1) << 50) - 1;
        const auto e = std::int64_t(double(random.between(-1.1f, 1.1f)) * double(reach));
        failures.add({std::clamp(e, -limit, limit), a, b}, log2_subcell);
    }
    CHECK(failures.none());
    const EdgeMaskTable& table = EdgeMaskTable::instance();
    const std::int64_t far = (std::int64_t(1) << 50) - 1;
    CHECK(table.triage(far, most, -most, 0) == TriageMask{all_subcells, no_subcells});
    CHECK(table.triage(-far, most, -most, 0) == TriageMask{no_subcells, all_subcells});
}

TEST_CASE("Edge mask table: edges along rows and columns have exact masks") {
    const EdgeMaskTable& table = EdgeMaskTable::instance();
    int wrong_samples = 0, wrong_triage = 0;
    for (int t = -300; t < 2400; ++t) {
        for (const std::int32_t length : {1, 255, 256, 100000, -1, -256, -4097}) {
            for (const TestEdge& edge : {through(0, t, length, 0), through(t, 0, 0, length)}) {
                wrong_samples += table.samples(edge.e, edge.a, edge.b) != exact_samples(edge);
                // Only the row or column that the edge lies in, or none, where it runs between two.
                const std::uint64_t active = table.triage(edge.e, edge.a, edge.b, 0).active();
                wrong_triage += std::popcount(active) != 8 * int(t > 0 && t < 2048) && t % 256 > 1;
            }
        }
    }
    CHECK(wrong_samples == 0);
    CHECK(wrong_triage == 0);
}

TEST_CASE("Edge mask table: an edge that misses the square, or has no direction, is told exactly") {
    const EdgeMaskTable& table = EdgeMaskTable::instance();
    const TriageMask inside{all_subcells, no_subcells}, outside{no_subcells, all_subcells};
    for (const int log2_subcell : {0, 3, 15}) {
        CHECK(table.triage(0, 0, 0, log2_subcell) == inside);
        CHECK(table.triage(-1, 0, 0, log2_subcell) == outside);
    }
    CHECK(table.samples(0, 0, 0) == all_subcells);
    CHECK(table.samples(-1, 0, 0) == no_subcells);
    Random random(3);
    int wrong = 0, missing = 0;
    for (int n = 0; n < 20000; ++n) {
        TestEdge edge = random_edge(random, 0);
        edge.e +=
            (random.below(2) == 0 ? 1 : -1) * std::int64_t(random.below(2000)) * (std::abs(edge.a) + std::abs(edge.b));
        const auto [low, high] = std::minmax({edge.at(0, 0) - 128 * (std::int64_t(edge.a) + edge.b),
                                              edge.at(8, 0) - 128 * (std::int64_t(edge.a) + edge.b),
                                              edge.at(0, 8) - 128 * (std::int64_t(edge.a) + edge.b),
                                              edge.at(8, 8) - 128 * (std::int64_t(edge.a) + edge.b)});
        if (low < 0 && high >= 0) continue;
        ++missing;
        wrong += !(table.triage(edge.e, edge.a, edge.b, 0) == (low >= 0 ? inside : outside));
        wrong += table.samples(edge.e, edge.a, edge.b) != (low >= 0 ? all_subcells : no_subcells);
    }
    CHECK(missing > 5000);
    CHECK(wrong == 0);
}

TEST_CASE("Edge mask table: active are the subcells that some line between the two intervals meets, and no others") {
    const EdgeMaskTable& table = EdgeMaskTable::instance();
    // All lines between ends of intervals, from the lines' own definition: a subcell is active if it has points on both
    // sides of some line in the interval, that is, unless all four lines between ends have it on one side.
    Random random(4);
    int too_few = 0, too_many = 0;
    for (int n = 0; n < 3000; ++n) {
        const TestEdge edge = random_edge(random, 0);
        // Ends of intervals in 1/8 sample along the border; crossings by bisection over the border's 256 intervals.
        struct Point {
            std::int64_t x, y;
        };
        const auto border = [](int t) -> Point {
            const int side = t / 64 % 4, u = t % 64;
            return side == 0   ? Point{u, 0}
                   : side == 1 ? Point{64, u}
                   : side == 2 ? Point{64 - u, 64}
                               : Point{0, 64 - u};
        };
        const auto inside = [&](Point p) { return edge.e + 32 * (edge.a * (p.x - 4) + edge.b * (p.y - 4)) >= 0; };
        std::vector<int> crossed;
        for (int t = 0; t < 256; ++t) {
            if (inside(border(t)) != inside(border(t + 1))) crossed.push_back(t);
        }
        if (crossed.size() != 2) continue;  // it misses
        std::uint64_t met = 0;
        for (int k = 0; k < 64; ++k) {
            bool all_left = true, all_right = true;
            for (int line = 0; line < 4; ++line) {
                const Point p = border(crossed[0] + line % 2), q = border(crossed[1] + line / 2);
                for (int corner = 0; corner < 4; ++corner) {
                    const Point c{8 * (k % 8 + corner % 2), 8 * (k / 8 + corner / 2)};
                    const std::int64_t v = (q.x - p.x) * (c.y - p.y) - (q.y - p.y) * (c.x - p.x);
                    all_left &= v >= 0;
                    all_right &= v <= 0;
                }
            }
            met |= std::uint64_t(!all_left && !all_right) << k;
        }
        const std::uint64_t active = table.triage(edge.e, edge.a, edge.b, 0).active();
        too_few += (met & ~active) != 0;
        too_many += (active & ~met) != 0;
    }
    CHECK(too_few == 0);
    CHECK(too_many == 0);
}

TEST_CASE("Edge mask table: what intervals lose is what the header says") {
    const EdgeMaskTable& table = EdgeMaskTable::instance();
    const int count = 100000;
    Random random(5);
    int wrong = 0, most_wrong = 0, wrong_masks = 0, lost_at_vertices = 0;
    int active[2] = {0, 0}, exactly_active[2] = {0, 0};
    for (int n = 0; n < count; ++n) {
        const TestEdge edge = random_edge(random, 0);
        const int w = std::popcount(table.samples(edge.e, edge.a, edge.b) ^ exact_samples(edge));
        wrong += w;
        most_wrong = std::max(most_wrong, w);
        wrong_masks += w != 0;
        for (int k = 0; k < 2; ++k) {
            const int log2_subcell = 3 * (k + 1);
            const TestEdge large = random_edge(random, log2_subcell);
            active[k] += std::popcount(table.triage(large.e, large.a, large.b, log2_subcell).active());
            exactly_active[k] += std::popcount(exact_triage(large, log2_subcell).active());
        }
        // Three polygons that meet in a vertex.
        const int x = int(random.below(2048)), y = int(random.below(2048));
        std::uint64_t mask[3];
        const float turn = random.between(0, 6.2831853f);
        for (int k = 0; k < 3; ++k) {
            const float angle = turn + 2.0943951f * float(k) + random.between(-0.5f, 0.5f);
            const TestEdge spoke =
                through(x, y, std::int32_t(8000 * std::cos(angle)), std::int32_t(8000 * std::sin(angle)));
            mask[k] = table.samples(spoke.e, spoke.a, spoke.b);
        }
        lost_at_vertices += 64 - std::popcount((mask[0] & ~mask[1]) | (mask[1] & ~mask[2]) | (mask[2] & ~mask[0]));
    }
    CHECK(wrong / double(count) == Approx(0.16).margin(0.005));
    CHECK(wrong_masks / double(count) == Approx(0.15).margin(0.01));
    CHECK(most_wrong <= 4);
    CHECK(lost_at_vertices / double(count) == Approx(1.0 / 700).margin(0.0004));
    CHECK(active[0] / double(count) == Approx(10.15).margin(0.05));
    CHECK(exactly_active[0] / double(count) == Approx(8.43).margin(0.05));
    CHECK(active[1] / double(count) == Approx(10.15).margin(0.05));
    CHECK(exactly_active[1] / double(count) == Approx(9.44).margin(0.05));
}

TEST_CASE("Edge mask table: one table, whichever thread asks first") {
    const EdgeMaskTable* seen[4] = {};
    std::vector<std::thread> threads;
    for (const EdgeMaskTable*& s : seen) threads.emplace_back([&s] { s = &EdgeMaskTable::instance(); });
    for (std::thread& t : threads) t.join();
    for (const EdgeMaskTable* s : seen) CHECK(s == &EdgeMaskTable::instance());
}
