#include "farfield/image.hpp"

#include <stdexcept>

#include "catch.hpp"

using namespace farfield;

TEST_CASE("pixels lie row by row, from top to bottom") {
    Image image(3, 2, {1, 2, 3, 4});
    CHECK((image.width() == 3 && image.height() == 2));
    REQUIRE(image.pixels().size() == 6);
    for (const Rgba8 p : image.pixels()) CHECK(p == Rgba8{1, 2, 3, 4});
    image.at(2, 1) = {9, 8, 7, 6};
    CHECK(image.pixels()[5] == Rgba8{9, 8, 7, 6});
    image.at(1, 0) = {5, 5, 5, 5};
    CHECK(image.pixels()[1] == Rgba8{5, 5, 5, 5});
    const Image& constant = image;
    CHECK(constant.at(2, 1) == Rgba8{9, 8, 7, 6});
    CHECK(constant.pixels().data() == image.pixels().data());
}

TEST_CASE("pictures are equal in size and in every pixel, or not at all") {
    const Image image(3, 2);
    CHECK(image == Image(3, 2));
    CHECK_FALSE(image == Image(2, 3));
    Image other = image;
    other.at(0, 1).a = 1;
    CHECK_FALSE(image == other);
    CHECK(Image() == Image(0, 0));
    CHECK(Image(0, 5).pixels().empty());
}

TEST_CASE("a negative size is refused") {
    CHECK_THROWS_AS(Image(-1, 2), std::invalid_argument);
    CHECK_THROWS_AS(Image(2, -1), std::invalid_argument);
}
