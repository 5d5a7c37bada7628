#include "farfield/approximation/sample_set/sample_size.hpp"

#include <cmath>
#include <limits>

#include "catch.hpp"

using namespace farfield;

TEST_CASE("the constant of the paper is that of a correct image in 99 of 100 cases", "[approximation]") {
    // "If the factor j is about 10^4 ... we generate a correct image with probability p^j > 0.99."
    CHECK(std::abs(sample_constant(0.99) - 13.8) < 0.05);
    CHECK(sample_constant(0.99, 1) < sample_constant(0.99, 2));
    // exp(-exp(-c)) is the probability of one cell.
    CHECK(std::abs(std::exp(-std::exp(-sample_constant(0.9, 1))) - 0.9) < 1e-12);
}

TEST_CASE("samples are as large as Theorem 1 has them, without its jumps", "[approximation]") {
    CHECK(sample_size(1, 13.8) == 14);
    CHECK(sample_size(1.0001, 13.8) == 14);  // rounded up first it would be two groups, 29 polygons
    CHECK(sample_size(2, 13.8) == 29);
    CHECK(sample_size(10, 4) == std::uint32_t(std::ceil(10 * std::log(10.0) + 40)));
    // One group is the least, whatever little lies in the cell.
    for (const double q : {0.0, 1e-30, 0.5, 1.0}) CHECK(sample_size(q, 5) == 5);
    CHECK(sample_size(0, 0.01) == 1);
    CHECK(sample_size(std::numeric_limits<double>::infinity(), 13.8) == 0x80000000u);
    CHECK(sample_size(std::numeric_limits<double>::quiet_NaN(), 13.8) == 14);
}

TEST_CASE("the first key is one of a primitive with a probability proportional to its area", "[approximation]") {
    int first = 0;
    constexpr int races = 20000;
    for (std::uint32_t seed = 0; seed < races; ++seed) {
        first += detail::race_key(7, seed, 3.0) < detail::race_key(8, seed, 1.0);
    }
    CHECK(std::abs(double(first) / races - 0.75) < 0.015);
}

TEST_CASE("keys of neighbors have nothing to do with one another", "[approximation]") {
    double sum = 0, squares = 0, products = 0;
    constexpr int count = 100000;
    for (std::uint32_t i = 0; i < count; ++i) {
        const double u = detail::uniform_of(i, 1) - 0.5, v = detail::uniform_of(i + 1, 1) - 0.5;
        sum += u;
        squares += u * u;
        products += u * v;
    }
    CHECK(std::abs(sum / count) < 0.005);
    CHECK(std::abs(squares / count - 1.0 / 12) < 0.001);
    CHECK(std::abs(products / count) < 0.002);
}

TEST_CASE("keys are finite and above 0 for areas of any size", "[approximation]") {
    for (const double area : {1e-300, 1e-30, 1.0, 1e30}) {
        for (std::uint32_t i = 0; i < 1000; ++i) {
            const float key = detail::race_key(i, 0, area);
            REQUIRE(key >= 0);
            REQUIRE(std::isfinite(key));
        }
    }
}
