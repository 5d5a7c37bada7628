#include "farfield/raster/sample_count.hpp"

#include <array>
#include <stdexcept>
#include <string>

#include "catch.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

TEST_CASE("samples are a square of one to eight on a side", "[raster]") {
    for (int samples = -4; samples < 100; ++samples) {
        int side = 0;
        for (int i = 1; i <= 8; ++i) side = i * i == samples ? i : side;
        if (side != 0) {
            CHECK(checked_samples_a_side(samples, "R") == side);
        } else {
            CHECK_THROWS_AS(checked_samples_a_side(samples, "R"), std::invalid_argument);
        }
    }
    try {
        checked_samples_a_side(5, "MyRenderer");
    } catch (const std::invalid_argument& e) {
        CHECK(std::string(e.what()).rfind("farfield::MyRenderer: ", 0) == 0);
    }
}

TEST_CASE("an image has one sample at least and 16,000 on a side at most", "[raster]") {
    const auto checked = [](int width, int height, int side) {
        View view = looking({0, 0, 5});
        view.width = width;
        view.height = height;
        check_image_size(LocalView(view, glm::dvec3(0), 1), side, "R");
    };
    CHECK_NOTHROW(checked(1, 1, 1));
    CHECK_NOTHROW(checked(16000, 1, 1));
    CHECK_NOTHROW(checked(2000, 2000, 8));
    for (const auto& [width, height, side] :
         {std::array{0, 1, 1}, {1, 0, 1}, {-1, 1, 1}, {16001, 1, 1}, {1, 16001, 1}, {2001, 1, 8}, {1, 2147483647, 8}}) {
        CHECK_THROWS_AS(checked(width, height, side), std::invalid_argument);
    }
}
