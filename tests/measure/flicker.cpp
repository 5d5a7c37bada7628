#include "farfield/measure/flicker.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "catch.hpp"

using farfield::Flicker;
using farfield::Image;
using farfield::PixelRect;
using farfield::Rgba8;

namespace {

Rgba8 gray(int value) {
    const auto v = static_cast<std::uint8_t>(value);
    return {v, v, v, 255};
}

Image noise(int width, int height, std::uint32_t seed, int lowest = 0, int highest = 255) {
    Image image(width, height);
    for (Rgba8& pixel : image.pixels()) {
        const auto next = [&] {
            seed = seed * 1664525u + 1013904223u;
            return static_cast<std::uint8_t>(lowest + int(seed >> 16) % (highest - lowest + 1));
        };
        pixel = {next(), next(), next(), next()};
    }
    return image;
}

Image plus(Image image, int shift) {
    for (Rgba8& c : image.pixels()) {
        const auto shifted = [shift](std::uint8_t v) { return static_cast<std::uint8_t>(v + shift); };
        c = {shifted(c.r), shifted(c.g), shifted(c.b), c.a};
    }
    return image;
}

Flicker flicker_of(const std::vector<Image>& variant, const std::vector<Image>& reference) {
    Flicker flicker;
    for (std::size_t t = 0; t < variant.size(); ++t) flicker.add(variant[t], reference[t]);
    return flicker;
}

// The definition: all frames at hand, channels in [0, 1].
double brute_force_step(const std::vector<Image>& i, const std::vector<Image>& r, std::size_t t, PixelRect rect) {
    double sum = 0, count = 0;
    for (int y = rect.y0; y < rect.y1; ++y) {
        for (int x = rect.x0; x < rect.x1; ++x) {
            const auto channels = [&](const Image& image) {
                const Rgba8 c = image.at(x, y);
                return std::array<double, 3>{c.r / 255.0, c.g / 255.0, c.b / 255.0};
            };
            for (std::size_t k = 0; k < 3; ++k) {
                const double change =
                    (channels(i[t])[k] - channels(i[t - 1])[k]) - (channels(r[t])[k] - channels(r[t - 1])[k]);
                sum += change * change;
                ++count;
            }
        }
    }
    return sum / count;
}

void check_none(const Flicker& flicker) {
    CHECK(flicker.mse() == 0.0);
    CHECK(flicker.rms() == 0.0);
    CHECK(flicker.largest_pop_rms() == 0.0);
    CHECK(flicker.largest_pop_frame() == 0);
}

}  // namespace

TEST_CASE("fewer than two frames do not flicker") {
    Flicker flicker;
    check_none(flicker);
    CHECK(flicker.frames() == 0);
    flicker.add(Image(3, 3, gray(0)), Image(3, 3, gray(255)));
    check_none(flicker);
    CHECK(flicker.frames() == 1);
    CHECK(flicker.steps() == 0);
}

TEST_CASE("a frozen sequence does not flicker, however wrong it is") {
    const Image variant = noise(7, 5, 1);
    const Image reference = noise(7, 5, 2);
    const Flicker flicker = flicker_of({variant, variant, variant}, {reference, reference, reference});
    check_none(flicker);
    CHECK(flicker.frames() == 3);
    CHECK(flicker.steps() == 2);
}

TEST_CASE("what moves as its reference does is no flicker, nor is a bias that stays") {
    std::vector<Image> moving, biased, other_alpha;
    for (std::uint32_t t = 0; t < 6; ++t) {
        moving.push_back(noise(9, 9, t, 20, 200));
        biased.push_back(plus(moving.back(), 37));
        other_alpha.push_back(moving.back());
        for (Rgba8& c : other_alpha.back().pixels()) c.a = static_cast<std::uint8_t>(40 * t);
    }
    check_none(flicker_of(moving, moving));
    check_none(flicker_of(biased, moving));
    check_none(flicker_of(moving, biased));
    check_none(flicker_of(other_alpha, moving));
}

TEST_CASE("one frame that pops by a known amount") {
    const Image reference(4, 4, gray(100));
    std::vector<Image> variant(5, reference);
    variant[2] = plus(reference, 51);  // 0.2, there and back: two of four steps
    const Flicker flicker = flicker_of(variant, std::vector<Image>(5, reference));
    CHECK(flicker.mse() == Approx(0.2 * 0.2 / 2));
    CHECK(flicker.rms() == Approx(0.2 / std::sqrt(2.0)));
    CHECK(flicker.largest_pop_rms() == Approx(0.2));
    CHECK(flicker.largest_pop_frame() == 2);
}

TEST_CASE("one channel of one pixel") {
    Image variant(5, 2, gray(0));
    Flicker flicker;
    flicker.add(variant, Image(5, 2, gray(0)));
    variant.at(3, 1).g = 255;
    flicker.add(variant, Image(5, 2, gray(0)));
    CHECK(flicker.mse() == Approx(1.0 / 30));
    CHECK(flicker.largest_pop_rms() == Approx(std::sqrt(1.0 / 30)));
}

TEST_CASE("the largest change there is: black and white alternate against white and black") {
    std::vector<Image> variant, reference;
    for (int t = 0; t < 4; ++t) {
        variant.emplace_back(3, 3, gray(t % 2 == 0 ? 0 : 255));
        reference.emplace_back(3, 3, gray(t % 2 == 0 ? 255 : 0));
    }
    const Flicker flicker = flicker_of(variant, reference);
    CHECK(flicker.mse() == 4.0);
    CHECK(flicker.rms() == 2.0);
    CHECK(flicker.largest_pop_rms() == 2.0);
    CHECK(flicker.largest_pop_frame() == 1);  // the first of equals
}

TEST_CASE("the order of frames counts, unlike for the mean of their errors") {
    const Image reference(2, 2, gray(50));
    const std::vector<Image> references(4, reference);
    const Image off = plus(reference, 102);  // 0.4
    const Flicker once = flicker_of({reference, reference, off, off}, references);
    const Flicker thrice = flicker_of({reference, off, reference, off}, references);
    CHECK(once.mse() == Approx(0.4 * 0.4 / 3));
    CHECK(thrice.mse() == Approx(0.4 * 0.4));
    CHECK(once.largest_pop_frame() == 2);
    CHECK(thrice.largest_pop_frame() == 1);
    CHECK(once.largest_pop_rms() == thrice.largest_pop_rms());
}

TEST_CASE("random sequences agree with the definition") {
    std::vector<Image> variant, reference;
    for (std::uint32_t t = 0; t < 7; ++t) {
        const int most = t == 4 ? 255 : 130;  // so that the steps differ
        variant.push_back(noise(13, 8, 10 + t, 100, most));
        reference.push_back(noise(13, 8, 50 + t, 90, 180));
    }
    double sum = 0, largest = 0;
    int frame = 0;
    for (std::size_t t = 1; t < variant.size(); ++t) {
        const double step = brute_force_step(variant, reference, t, {0, 0, 13, 8});
        sum += step;
        if (step > largest) frame = int(t);
        largest = std::max(largest, step);
    }
    const Flicker flicker = flicker_of(variant, reference);
    CHECK(flicker.mse() == Approx(sum / 6).epsilon(1e-12));
    CHECK(flicker.rms() == std::sqrt(flicker.mse()));
    CHECK(flicker.largest_pop_rms() == Approx(std::sqrt(largest)).epsilon(1e-12));
    CHECK(flicker.largest_pop_frame() == frame);
    CHECK(flicker_of(reference, variant).mse() == flicker.mse());
}

TEST_CASE("a step is compared over the rectangles of both its frames") {
    std::vector<Image> variant, reference;
    for (std::uint32_t t = 0; t < 3; ++t) {
        variant.push_back(noise(12, 10, 1 + t));
        reference.push_back(noise(12, 10, 20 + t));
    }
    const PixelRect first{-4, 2, 5, 6}, second{3, 4, 7, 9}, both{0, 2, 7, 9};
    for (const auto& [before, after] : {std::array{first, second}, {second, first}}) {
        Flicker flicker;
        flicker.add(variant[0], reference[0], before);
        flicker.add(variant[1], reference[1], after);
        const double step = brute_force_step(variant, reference, 1, both);
        CHECK(flicker.mse() == Approx(step));
        flicker.add(variant[2], reference[2], after);
        const double next = brute_force_step(variant, reference, 2, after.clipped_to(variant[2]));
        CHECK(flicker.mse() == Approx((step + next) / 2));
    }
}

TEST_CASE("there is no step across a cut") {
    const Image dark(3, 3, gray(10)), light(3, 3, gray(61));
    Flicker flicker;
    flicker.cut();
    flicker.add(dark, dark, PixelRect{0, 0, 1, 1});
    flicker.cut();
    flicker.add(light, dark);
    check_none(flicker);
    CHECK(flicker.steps() == 0);
    flicker.add(light, dark);
    CHECK(flicker.steps() == 1);
    check_none(flicker);
    flicker.add(dark, dark);
    CHECK(flicker.mse() == Approx(0.2 * 0.2 / 2));
    CHECK(flicker.largest_pop_frame() == 3);
    CHECK(flicker.frames() == 4);
}

TEST_CASE("frames that cannot be compared are refused, and nothing has happened") {
    Flicker flicker;
    CHECK_THROWS_AS(flicker.add(Image{}, Image{}), std::invalid_argument);
    CHECK_THROWS_AS(flicker.add(Image(2, 2), Image(2, 3)), std::invalid_argument);
    flicker.add(Image(2, 2, gray(0)), Image(2, 2, gray(0)));
    CHECK_THROWS_AS(flicker.add(Image(2, 3), Image(2, 3)), std::invalid_argument);
    CHECK_THROWS_AS(flicker.add(Image(4, 1), Image(4, 1)), std::invalid_argument);
    CHECK_THROWS_AS(flicker.add(Image(2, 2), Image(2, 2), PixelRect{2, 0, 3, 2}), std::invalid_argument);
    CHECK(flicker.frames() == 1);
    flicker.add(Image(2, 2, gray(51)), Image(2, 2, gray(0)));
    CHECK(flicker.mse() == Approx(0.2 * 0.2));
    CHECK(flicker.largest_pop_frame() == 1);
}
