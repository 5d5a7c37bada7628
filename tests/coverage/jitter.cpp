// Jittered samples stay in their squares, patterns differ, and masks of edges are exact.
#include "farfield/coverage/jitter.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "catch.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

namespace {
constexpr std::int32_t limit = (1 << 24) - 1;

/// Of any size up to the limit, small ones as often as large ones, and the limits.
std::int32_t any_slope(Random& random) {
    const unsigned shift = random.below(25);
    const auto v = std::int32_t(random.below(1u << shift));
    const std::uint32_t choice = random.below(16);
    return choice == 0 ? limit : choice == 1 ? -limit : choice % 2 == 0 ? v : -v;
}
/// An edge that crosses the pixel, or nearly, or is anywhere.
std::int64_t any_value(Random& random, std::int32_t a, std::int32_t b) {
    const auto x = std::int64_t(random.below(2600)) - 384, y = std::int64_t(random.below(2600)) - 384;
    const auto nudge = std::int64_t(random.below(3)) - 1;
    const auto far = std::int64_t(random.bits()) >> 14;
    return random.below(8) == 0 ? far : -(a * x + b * y) + nudge;
}
std::uint64_t by_definition(const JitterPattern& p, std::int64_t e, std::int32_t a, std::int32_t b) {
    std::uint64_t mask = 0;
    for (int j = 0; j < 8; ++j) {
        for (int i = 0; i < 8; ++i) {
            const auto k = unsigned(8 * j + i);
            if (e + std::int64_t(a) * (256 * i + p.x(k)) + std::int64_t(b) * (256 * j + p.y(k)) >= 0)
                mask |= std::uint64_t(1) << k;
        }
    }
    return mask;
}
}  // namespace

TEST_CASE("jittered masks of edges are exact, and those of reversed edges the complement", "[coverage]") {
    Random random(520);
    const JitterPatterns patterns(7, 3);
    int partial = 0;
    for (int i = 0; i < 200000; ++i) {
        const std::int32_t a = any_slope(random), b = any_slope(random);
        const std::int64_t e = any_value(random, a, b);
        const JitterPattern& p = patterns[random.below(7)];
        const std::uint64_t mask = samples(p, e, a, b);
        if (mask != by_definition(p, e, a, b) || mask != detail::samples_one_by_one(p, e, a, b) ||
            mask != ~samples(p, -e - 1, -a, -b)) {
            FAIL("e " << e << ", a " << a << ", b " << b);
        }
        partial += mask != 0 && ~mask != 0;
    }
    CHECK(partial > 50000);
}

TEST_CASE("of no jitter the mask is that of the regular centers; degenerate edges are all or nothing", "[coverage]") {
    Random random(521);
    const JitterPattern regular;
    for (int i = 0; i < 1000; ++i) {
        const std::int32_t a = any_slope(random), b = any_slope(random);
        const std::int64_t e = any_value(random, a, b);
        std::uint64_t mask = 0;
        for (int k = 0; k < 64; ++k) {
            mask |= std::uint64_t(e + 256 * (std::int64_t(a) * (k % 8) + std::int64_t(b) * (k / 8)) >= 0) << k;
        }
        CHECK(samples(regular, e, a, b) == mask);
    }
    CHECK(samples(regular, 0, 0, 0) == ~std::uint64_t(0));
    CHECK(samples(regular, -1, 0, 0) == 0);
    const std::int64_t far = std::int64_t(1) << 61;
    CHECK(samples(regular, far, limit, -limit) == ~std::uint64_t(0));
    CHECK(samples(regular, -far, limit, -limit) == 0);
}

TEST_CASE("edge functions differ from their values at regular centers by the slack at most", "[coverage]") {
    Random random(522);
    const JitterPatterns patterns(64, 5);
    CHECK(jitter_slack(0, 0) == 0);
    CHECK(jitter_slack(-3, 5) == 8 * 128);
    CHECK(jitter_slack(-limit, -limit) == 256 * std::int64_t(limit));
    double largest = 0;
    for (int i = 0; i < 20000; ++i) {
        const std::int32_t a = any_slope(random), b = any_slope(random);
        const JitterPattern& p = patterns[random.below(64)];
        for (unsigned k = 0; k < 64; ++k) {
            const std::int64_t difference = std::int64_t(a) * p.x(k) + std::int64_t(b) * p.y(k);
            if (std::abs(difference) > jitter_slack(a, b)) FAIL("a " << a << ", b " << b);
            if (difference != 0) largest = std::max(largest, double(std::abs(difference)) / double(jitter_slack(a, b)));
        }
    }
    CHECK(largest > 0.99);
}

TEST_CASE("offsets are uniform in their squares, independent, and differ from pattern to pattern", "[coverage]") {
    const std::size_t count = 256;
    const JitterPatterns patterns(count, 9);
    REQUIRE(patterns.size() == count);
    double x = 0, y = 0, xx = 0, yy = 0, xy = 0;
    int lowest = 0, highest = 0;
    for (std::size_t i = 0; i < count; ++i) {
        for (unsigned k = 0; k < 64; ++k) {
            const int dx = patterns[i].x(k), dy = patterns[i].y(k);
            lowest = std::min({lowest, dx, dy});
            highest = std::max({highest, dx, dy});
            x += dx, y += dy, xx += dx * dx, yy += dy * dy, xy += dx * dy;
        }
        for (std::size_t j = 0; j < i; ++j) CHECK(std::memcmp(&patterns[i], &patterns[j], sizeof(JitterPattern)) != 0);
    }
    const double n = double(count) * 64;
    CHECK(lowest == -128);
    CHECK(highest == 127);
    CHECK(std::abs(x / n + 0.5) < 3);  // of a standard deviation of 74 / sqrt(n) = 0.6
    CHECK(std::abs(y / n + 0.5) < 3);
    CHECK(std::sqrt(xx / n) == Approx(256 / std::sqrt(12.0)).epsilon(0.02));
    CHECK(std::sqrt(yy / n) == Approx(256 / std::sqrt(12.0)).epsilon(0.02));
    CHECK(std::abs(xy / n) < 0.04 * 74 * 74);
}

TEST_CASE("patterns come of their seed, and all of them are used, without regularity", "[coverage]") {
    const JitterPatterns a(16, 1), b(16, 1), other(16, 2), one(1);
    CHECK(std::memcmp(&a[5], &b[5], sizeof(JitterPattern)) == 0);
    CHECK(std::memcmp(&a[5], &other[5], sizeof(JitterPattern)) != 0);
    CHECK(&one.pattern_of(-5, 1 << 20) == &one[0]);
    std::vector<int> used(16);
    int same_as_neighbor = 0;
    for (int y = 0; y < 128; ++y) {
        for (int x = 0; x < 128; ++x) {
            const JitterPattern& p = a.pattern_of(x, y);
            CHECK(&p == &a.pattern_of(x, y));
            ++used[std::size_t(&p - &a[0])];
            same_as_neighbor += &p == &a.pattern_of(x + 1, y);
            same_as_neighbor += &p == &a.pattern_of(x, y + 1);
        }
    }
    for (const int times : used) CHECK(std::abs(times - 1024) < 160);  // five standard deviations
    CHECK(std::abs(same_as_neighbor - 2048) < 220);
    CHECK_THROWS_AS(JitterPatterns(0), std::invalid_argument);
}
