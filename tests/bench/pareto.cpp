#include "../../bench/accuracy/chart/pareto.hpp"

#include <algorithm>
#include <limits>

#include "catch.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::bench;

using Indices = std::vector<std::size_t>;

TEST_CASE("the front is what nothing beats, from left to right") {
    const std::vector<ChartPoint> points{{3, 1}, {1, 3}, {2, 2}, {3, 3}, {2.5, 2.5}};
    CHECK(pareto_front(points) == Indices{1, 2, 0});
}

TEST_CASE("of equal points the first is on the front, and nothing that is as good in one and worse in the other") {
    CHECK(pareto_front(std::vector<ChartPoint>{{1, 1}, {1, 1}}) == Indices{0});
    CHECK(pareto_front(std::vector<ChartPoint>{{1, 2}, {1, 1}, {2, 1}}) == Indices{1});
}

TEST_CASE("what is not finite is never on the front") {
    const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
    CHECK(pareto_front(std::vector<ChartPoint>{{nan, 0}, {0, nan}, {-infinity, 0}, {0, infinity}}).empty());
    CHECK(pareto_front(std::vector<ChartPoint>{{nan, 0}, {1, 1}}) == Indices{1});
    CHECK(pareto_front({}).empty());
}

TEST_CASE("the front of random points is that of all pairs compared") {
    test::Random random(1);
    for (int round = 0; round < 200; ++round) {
        std::vector<ChartPoint> points(random.below(60));
        // Few values, so that many are equal.
        for (ChartPoint& p : points) p = {double(random.below(9)), double(random.below(9))};
        Indices expected;
        for (std::size_t i = 0; i < points.size(); ++i) {
            bool is_beaten = false;
            for (std::size_t j = 0; j < points.size(); ++j) {
                const bool no_worse = points[j].x <= points[i].x && points[j].y <= points[i].y;
                const bool is_equal = points[j].x == points[i].x && points[j].y == points[i].y;
                is_beaten = is_beaten || (no_worse && (!is_equal || j < i));
            }
            if (!is_beaten) expected.push_back(i);
        }
        std::sort(expected.begin(), expected.end(),
                  [&](std::size_t a, std::size_t b) { return points[a].x < points[b].x; });
        CHECK(pareto_front(points) == expected);
    }
}
