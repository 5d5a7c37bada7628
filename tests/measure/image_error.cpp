#include "farfield/measure/image_error.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>

#include "catch.hpp"

using farfield::Image;
using farfield::mse;
using farfield::PixelRect;
using farfield::psnr;
using farfield::Rgba8;
using farfield::rmse;

TEST_CASE("black against white is the largest error") {
    const Image black(3, 2, {0, 0, 0, 255});
    const Image white(3, 2, {255, 255, 255, 255});
    CHECK(mse(black, white) == 1.0);
    CHECK(rmse(black, white) == 1.0);
    CHECK(psnr(black, white) == 0.0);
}

TEST_CASE("equal pictures have no error, and a noise ratio beyond every number") {
    const Image image(5, 4, {10, 200, 30, 40});
    CHECK(mse(image, image) == 0.0);
    CHECK(rmse(image, image) == 0.0);
    CHECK(psnr(image, image) == std::numeric_limits<double>::infinity());
}

TEST_CASE("the error is averaged over red, green and blue") {
    // One channel of one pixel in four is off by 51 = 0.2 * 255: mse = 0.2^2 / 12 = 1/300.
    Image reference(2, 2, {100, 100, 100, 255});
    for (int channel = 0; channel < 3; ++channel) {
        Image variant = reference;
        Rgba8& pixel = variant.at(1, 0);
        (channel == 0 ? pixel.r : channel == 1 ? pixel.g : pixel.b) = 151;
        CHECK(mse(variant, reference) == Approx(1.0 / 300));
        CHECK(mse(reference, variant) == mse(variant, reference));
        CHECK(rmse(variant, reference) == Approx(0.0577350269));  // 1 / sqrt(300)
        CHECK(psnr(variant, reference) == Approx(24.7712125));    // 10 log10(300)
    }
}

TEST_CASE("alpha is not compared") {
    CHECK(mse(Image(2, 2, {9, 9, 9, 0}), Image(2, 2, {9, 9, 9, 255})) == 0.0);
}

TEST_CASE("a single step of a single channel is seen, and weighs the same in the largest sum") {
    Image reference(1, 1, {7, 7, 7, 255});
    Image variant(1, 1, {7, 8, 7, 255});
    CHECK(mse(variant, reference) == Approx(1.0 / (3 * 65025.0)));

    // 1000 x 1000 steps: a sum in float would have stopped growing.
    reference = Image(1000, 1000, {7, 7, 7, 255});
    variant = Image(1000, 1000, {7, 8, 7, 255});
    CHECK(mse(variant, reference) == Approx(1.0 / (3 * 65025.0)).epsilon(1e-14));
}

TEST_CASE("only the rectangle is compared, its end excluded") {
    const Image reference(10, 10, {0, 0, 0, 255});
    Image variant = reference;
    variant.at(4, 6) = {255, 255, 255, 255};
    CHECK(mse(variant, reference) == Approx(0.01));
    CHECK(mse(variant, reference, PixelRect{4, 6, 5, 7}) == 1.0);
    CHECK(mse(variant, reference, PixelRect{3, 5, 5, 7}) == 0.25);
    CHECK(mse(variant, reference, PixelRect{0, 0, 4, 10}) == 0.0);
    CHECK(mse(variant, reference, PixelRect{5, 0, 10, 10}) == 0.0);
    CHECK(mse(variant, reference, PixelRect{0, 0, 10, 6}) == 0.0);
    CHECK(mse(variant, reference, PixelRect{0, 7, 10, 10}) == 0.0);
    CHECK(mse(variant, reference, PixelRect{-10, 6, 90, 7}) == Approx(0.1));  // clipped to ten pixels
    CHECK(psnr(variant, reference, PixelRect{-10, 6, 90, 7}) == Approx(10.0));
}

TEST_CASE("colors that cannot be compared are refused") {
    const Image image(2, 2);
    CHECK_THROWS_AS(mse(image, Image(2, 3)), std::invalid_argument);
    CHECK_THROWS_AS(rmse(image, Image(1, 2)), std::invalid_argument);
    CHECK_THROWS_AS(psnr(image, image, PixelRect{2, 0, 3, 1}), std::invalid_argument);
    CHECK_THROWS_AS(mse(Image{}, Image{}), std::invalid_argument);
}
