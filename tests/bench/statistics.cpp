#include "../../bench/accuracy/chart/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "catch.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::bench;

TEST_CASE("quartiles lie between neighbors in order") {
    CHECK(quartiles({7}) == Quartiles{7, 7, 7});
    CHECK(quartiles({3, 1}) == Quartiles{1.5, 2, 2.5});
    CHECK(quartiles({5, 1, 4, 2, 3}) == Quartiles{2, 3, 4});
    CHECK(quartiles({4, 3, 2, 1}) == Quartiles{1.75, 2.5, 3.25});
    CHECK(quartiles({2, 2, 2, 9}) == Quartiles{2, 2, 3.75});
}

TEST_CASE("quartiles of nothing are not numbers") {
    CHECK(std::isnan(quartiles({}).first));
    CHECK(std::isnan(quartiles({}).median));
    CHECK(std::isnan(quartiles({}).third));
}

TEST_CASE("an infinite value does not spoil the others") {
    const double infinity = std::numeric_limits<double>::infinity();
    CHECK(quartiles({1, infinity, 2, 3, infinity}) == Quartiles{2, 3, infinity});
    CHECK(quartiles({1, 2, 3, 4, infinity}) == Quartiles{2, 3, 4});
}

TEST_CASE("a quarter of the values lies below the first quartile and above the third, half below the median") {
    test::Random random(3);
    for (int i = 0; i < 200; ++i) {
        std::vector<double> values(1 + random.below(40));
        for (double& v : values) v = random.between(-1, 1);
        const Quartiles q = quartiles(values);
        const auto below = [&](double bound) {
            return std::count_if(values.begin(), values.end(), [&](double v) { return v < bound; });
        };
        const auto above = [&](double bound) {
            return std::count_if(values.begin(), values.end(), [&](double v) { return v > bound; });
        };
        const auto n = double(values.size());
        CHECK(double(below(q.first)) <= 0.25 * n + 1);
        CHECK(double(above(q.first)) <= 0.75 * n);
        CHECK(double(below(q.median)) <= 0.5 * n);
        CHECK(double(above(q.median)) <= 0.5 * n);
        CHECK(double(below(q.third)) <= 0.75 * n);
        CHECK(double(above(q.third)) <= 0.25 * n + 1);
        CHECK(q.first <= q.median);
        CHECK(q.median <= q.third);
    }
}
