#include "farfield/raster/snapping.hpp"

#include <cmath>

#include "catch.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

TEST_CASE("any number below 2^22 is snapped to the nearest, halves to the even one", "[raster]") {
    Random random(770);
    for (int i = 0; i < 20000; ++i) {
        const float reach = std::exp2(random.between(-3, 22));
        const float v = random.between(-reach, reach);
        CHECK(snapped_to_256th(v) == std::int32_t(std::nearbyint(double(v))));
    }
    CHECK(snapped_to_256th(0.5f) == 0);
    CHECK(snapped_to_256th(1.5f) == 2);
    CHECK(snapped_to_256th(-0.5f) == 0);
    CHECK(snapped_to_256th(-2.5f) == -2);
    CHECK(snapped_to_256th(4194303.0f) == 4194303);
    CHECK(snapped_to_256th(-4194304.0f) == -4194304);
}
