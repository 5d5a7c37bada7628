#include "farfield/raster/sample_rect.hpp"

#include "catch.hpp"

using namespace farfield;
using namespace farfield::detail;

TEST_CASE("a rectangle of nothing is empty, and adds nothing", "[raster]") {
    SampleRect r;
    CHECK(r.is_empty());
    r.add(SampleRect{});
    CHECK(r.is_empty());
    r.add(SampleRect{3, 4, 3, 9});  // no column
    CHECK(r.is_empty());
}

TEST_CASE("rectangles grow to hold what is added", "[raster]") {
    SampleRect r;
    r.add(2, 3, 4, 5);
    CHECK((r.x0 == 2 && r.y0 == 3 && r.x1 == 4 && r.y1 == 5));
    CHECK_FALSE(r.is_empty());
    r.add(SampleRect{-7, 4, -6, 20});
    CHECK((r.x0 == -7 && r.y0 == 3 && r.x1 == 4 && r.y1 == 20));
    r.add(SampleRect{0, 0, 0, 0});
    CHECK((r.x0 == -7 && r.y0 == 3 && r.x1 == 4 && r.y1 == 20));
}
