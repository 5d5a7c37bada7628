#include "farfield/fail.hpp"

#include <stdexcept>
#include <string>

#include "catch.hpp"

using namespace farfield;

TEST_CASE("A failure throws the exception that it names, with its message") {
    CHECK_THROWS_AS(detail::fail<std::length_error>(std::string("too long")), std::length_error);
    CHECK_THROWS_WITH(detail::fail<std::invalid_argument>("a NaN"), "a NaN");
}

TEST_CASE("A guarded call tells of what it was asked to catch, and lets the rest pass") {
    int caught = 0;
    const auto count = [&] { ++caught; };
    detail::guarded([] {}, count);
    CHECK(caught == 0);
    detail::guarded([] { throw 1; }, count);
    CHECK(caught == 1);
    detail::guarded<std::runtime_error>([] { throw std::runtime_error("x"); }, count);
    CHECK(caught == 2);
    CHECK_THROWS_AS(detail::guarded<std::runtime_error>([] { throw std::logic_error("x"); }, count), std::logic_error);
    CHECK(caught == 2);
}
