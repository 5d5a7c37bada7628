#include "farfield/geometry/rgba8.hpp"

#include <cstdint>
#include <cstdlib>
#include <limits>

#include "catch.hpp"

using namespace farfield;

TEST_CASE("eight bits come back as they were", "[geometry]") {
    for (int v = 0; v < 256; ++v) {
        const Rgba8 c{std::uint8_t(v), std::uint8_t(255 - v), std::uint8_t(v / 2), std::uint8_t(v)};
        CHECK(to_rgba8(to_vec4(c)) == c);
    }
}

TEST_CASE("premultiplied colors are rounded, and no channel is above alpha", "[geometry]") {
    for (int a = 0; a < 256; ++a) {
        for (int v = 0; v < 256; ++v) {
            const Rgba8 c = premultiplied({std::uint8_t(v), 255, 0, std::uint8_t(a)});
            REQUIRE(std::abs(v * a - 255 * c.r) <= 127);
            REQUIRE((c.g == a && c.b == 0 && c.a == a));
        }
    }
}

TEST_CASE("what lies outside is clamped, and what is no number is 0", "[geometry]") {
    const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
    CHECK(to_rgba8({-1, 2, nan, infinity}) == Rgba8{0, 255, 0, 255});
    CHECK(to_rgba8({-infinity, -0.0f, 1.0f / 255, 0.5f}) == Rgba8{0, 0, 1, 128});
}
