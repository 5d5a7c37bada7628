#include "farfield/geometry/halvings.hpp"

#include <cmath>
#include <limits>

#include "catch.hpp"

using namespace farfield;

TEST_CASE("halvings are exact and never reach 0") {
    for (unsigned levels = 0; levels <= 126; ++levels)
        CHECK(two_to_the_minus(levels) == std::ldexp(1.0f, -int(levels)));
    CHECK(two_to_the_minus(127) == std::numeric_limits<float>::min());
    CHECK(two_to_the_minus(0xffffffffu) == std::numeric_limits<float>::min());
}
