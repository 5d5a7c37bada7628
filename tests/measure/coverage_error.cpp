#include "farfield/measure/coverage_error.hpp"

#include <limits>
#include <stdexcept>

#include "catch.hpp"

using farfield::coverage_error;
using farfield::CoverageError;
using farfield::Image;
using farfield::PixelRect;

namespace {

Image covered(int width, int height, int pixels, std::uint8_t alpha) {
    Image image(width, height);
    for (int i = 0; i < pixels; ++i) image.at(i % width, i / width) = {0, 0, 0, alpha};
    return image;
}

}  // namespace

TEST_CASE("equal coverage has no error, whatever the colors") {
    CHECK(coverage_error(Image(4, 4, {1, 2, 3, 77}), Image(4, 4, {9, 8, 7, 77})) == CoverageError{0, 0});
}

TEST_CASE("the bias is relative and signed") {
    const Image reference = covered(4, 4, 8, 255);
    // Half as many pixels: 4 of 16 differ by 1.
    CHECK(coverage_error(covered(4, 4, 4, 255), reference).bias == -0.5);
    CHECK(coverage_error(covered(4, 4, 4, 255), reference).rms == 0.5);
    // Twice as many: 8 of 16 differ by 1.
    CHECK(coverage_error(covered(4, 4, 16, 255), reference).bias == 1.0);
    CHECK(coverage_error(covered(4, 4, 16, 255), reference).rms == Approx(0.70710678));
    // None.
    CHECK(coverage_error(Image(4, 4), reference).bias == -1.0);
}

TEST_CASE("coverage in the wrong place has no bias but an error") {
    // 8 pixels of alpha 204 = 0.8 against 16 of 102 = 0.4: all 16 differ by 0.4.
    const CoverageError error = coverage_error(covered(4, 4, 16, 102), covered(4, 4, 8, 204));
    CHECK(error.bias == 0.0);
    CHECK(error.rms == Approx(0.4));
}

TEST_CASE("empty space around the object changes the rms and not the bias") {
    const Image variant = covered(8, 8, 8, 102);
    const Image reference = covered(8, 8, 8, 204);
    const CoverageError row = coverage_error(variant, reference, PixelRect{0, 0, 8, 1});
    const CoverageError all = coverage_error(variant, reference, PixelRect{-3, -3, 99, 99});
    CHECK(row.bias == -0.5);
    CHECK(row.rms == Approx(0.4));
    CHECK(all.bias == -0.5);
    CHECK(all.rms == Approx(0.4 / 2.8284271));  // an eighth of the pixels
}

TEST_CASE("over an empty reference the bias is defined") {
    const Image empty(2, 2);
    CHECK(coverage_error(empty, empty) == CoverageError{0, 0});
    const CoverageError error = coverage_error(covered(2, 2, 1, 255), empty);
    CHECK(error.bias == std::numeric_limits<double>::infinity());
    CHECK(error.rms == 0.5);
}

TEST_CASE("one pixel of the least coverage is enough") {
    const CoverageError error = coverage_error(covered(1, 1, 1, 2), covered(1, 1, 1, 1));
    CHECK(error.bias == 1.0);
    CHECK(error.rms == Approx(1.0 / 255));
}

TEST_CASE("coverage that cannot be compared is refused") {
    CHECK_THROWS_AS(coverage_error(Image(2, 2), Image(2, 3)), std::invalid_argument);
    CHECK_THROWS_AS(coverage_error(Image(2, 2), Image(2, 2), PixelRect{1, 1, 1, 2}), std::invalid_argument);
    CHECK_THROWS_AS(coverage_error(Image{}, Image{}), std::invalid_argument);
}
