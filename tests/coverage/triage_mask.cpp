#include "farfield/coverage/triage_mask.hpp"

#include "catch.hpp"

using namespace farfield;

TEST_CASE("a mask begins vacant; subcells neither covered nor vacant are active", "[coverage]") {
    TriageMask mask;
    CHECK(mask.covered == no_subcells);
    CHECK(mask.vacant == all_subcells);
    CHECK(mask.active() == no_subcells);
    mask = {0x00000000000000ffu, 0xffffffffff000000u};
    CHECK(mask.active() == 0x0000000000ffff00u);
    CHECK(mask == TriageMask{0xff, 0xffffffffff000000u});
    CHECK_FALSE(mask == TriageMask{});
}

TEST_CASE("rectangles of subcells, all of them", "[coverage]") {
    for (int y0 = 0; y0 < 8; ++y0) {
        for (int y1 = y0; y1 < 8; ++y1) {
            for (int x0 = 0; x0 < 8; ++x0) {
                for (int x1 = x0; x1 < 8; ++x1) {
                    std::uint64_t expected = 0;
                    for (int y = y0; y <= y1; ++y) {
                        for (int x = x0; x <= x1; ++x) expected |= std::uint64_t(1) << (8 * y + x);
                    }
                    if (subcells_of_rect(x0, y0, x1, y1) != expected) FAIL(x0 << y0 << x1 << y1);
                }
            }
        }
    }
}
