#include "farfield/measure/pixel_rect.hpp"

#include <limits>
#include <stdexcept>

#include "catch.hpp"

using farfield::compared_rect;
using farfield::Image;
using farfield::PixelRect;

TEST_CASE("a rectangle without width or height is empty") {
    CHECK(PixelRect{}.is_empty());
    CHECK(PixelRect{2, 2, 2, 5}.is_empty());
    CHECK(PixelRect{2, 2, 5, 2}.is_empty());
    CHECK(PixelRect{5, 2, 2, 5}.is_empty());
    CHECK_FALSE(PixelRect{2, 2, 3, 3}.is_empty());
}

TEST_CASE("a rectangle is clipped to the picture on all four sides") {
    const Image image(8, 6);
    constexpr int least = std::numeric_limits<int>::min();
    constexpr int most = std::numeric_limits<int>::max();
    CHECK(PixelRect{least, least, most, most}.clipped_to(image) == PixelRect{0, 0, 8, 6});
    CHECK(PixelRect{-1, 2, 3, 4}.clipped_to(image) == PixelRect{0, 2, 3, 4});
    CHECK(PixelRect{2, 3, 9, 9}.clipped_to(image) == PixelRect{2, 3, 8, 6});
    CHECK(PixelRect{8, 0, 9, 6}.clipped_to(image).is_empty());
    CHECK(PixelRect{-5, 0, 0, 6}.clipped_to(image).is_empty());
}

TEST_CASE("what is compared is never empty") {
    const Image image(8, 6);
    CHECK(compared_rect(image, image, {}) == PixelRect{0, 0, 8, 6});
    CHECK(compared_rect(image, image, PixelRect{7, 5, 20, 20}) == PixelRect{7, 5, 8, 6});
    CHECK_THROWS_AS(compared_rect(image, image, PixelRect{8, 6, 20, 20}), std::invalid_argument);
    CHECK_THROWS_AS(compared_rect(image, image, PixelRect{}), std::invalid_argument);
    CHECK_THROWS_AS(compared_rect(Image{}, Image{}, {}), std::invalid_argument);
    CHECK_THROWS_AS(compared_rect(Image(8, 6), Image(6, 8), {}), std::invalid_argument);
    CHECK_THROWS_AS(compared_rect(Image(8, 6), Image(8, 7), PixelRect{0, 0, 1, 1}), std::invalid_argument);
}
