#include "farfield/measure/ssim.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>

#include "catch.hpp"

using farfield::Image;
using farfield::PixelRect;
using farfield::Rgba8;
using farfield::ssim;

namespace {

constexpr double c1 = 1e-4;
constexpr double c2 = 9e-4;

Rgba8 gray(int value) {
    const auto v = static_cast<std::uint8_t>(value);
    return {v, v, v, 255};
}

// A linear congruential generator: the same pictures on every machine.
Image noise(int width, int height, std::uint32_t seed) {
    Image image(width, height);
    for (Rgba8& pixel : image.pixels()) {
        const auto next = [&seed] {
            seed = seed * 1664525u + 1013904223u;
            return static_cast<std::uint8_t>(seed >> 24);
        };
        pixel = {next(), next(), next(), next()};
    }
    return image;
}

Image mixed(const Image& a, const Image& b) {
    Image image(a.width(), a.height());
    for (int y = 0; y < a.height(); ++y) {
        for (int x = 0; x < a.width(); ++x) {
            const auto mean = [](int p, int q) { return static_cast<std::uint8_t>((3 * p + q) / 4); };
            const Rgba8 p = a.at(x, y);
            const Rgba8 q = b.at(x, y);
            image.at(x, y) = {mean(p.r, q.r), mean(p.g, q.g), mean(p.b, q.b), 255};
        }
    }
    return image;
}

// The definition word by word: two-dimensional windows, each with its own weights, deviations from the mean.
double brute_force(const Image& a, const Image& b, PixelRect r) {
    const auto luma = [](Rgba8 c) { return (0.299 * c.r + 0.587 * c.g + 0.114 * c.b) / 255; };
    const bool narrow = r.x1 - r.x0 < 11;
    const bool low = r.y1 - r.y0 < 11;
    double sum = 0;
    int windows = 0;
    for (int cy = r.y0 + (low ? 0 : 5); cy < r.y1 - (low ? 0 : 5); ++cy) {
        for (int cx = r.x0 + (narrow ? 0 : 5); cx < r.x1 - (narrow ? 0 : 5); ++cx) {
            const auto weighted_mean = [&](auto&& value) {
                double total = 0;
                double weights = 0;
                for (int y = std::max(cy - 5, r.y0); y < std::min(cy + 6, r.y1); ++y) {
                    for (int x = std::max(cx - 5, r.x0); x < std::min(cx + 6, r.x1); ++x) {
                        const double squared = (x - cx) * (x - cx) + (y - cy) * (y - cy);
                        const double weight = std::exp(-squared / (2 * 1.5 * 1.5));
                        total += weight * value(x, y);
                        weights += weight;
                    }
                }
                return total / weights;
            };
            const double ma = weighted_mean([&](int x, int y) { return luma(a.at(x, y)); });
            const double mb = weighted_mean([&](int x, int y) { return luma(b.at(x, y)); });
            const auto covariance = [&](const Image& p, double mp, const Image& q, double mq) {
                return weighted_mean([&](int x, int y) { return (luma(p.at(x, y)) - mp) * (luma(q.at(x, y)) - mq); });
            };
            sum += (2 * ma * mb + c1) / (ma * ma + mb * mb + c1) * (2 * covariance(a, ma, b, mb) + c2) /
                   (covariance(a, ma, a, ma) + covariance(b, mb, b, mb) + c2);
            ++windows;
        }
    }
    return sum / windows;
}

}  // namespace

TEST_CASE("equal pictures have similarity one, exactly") {
    for (const int size : {1, 2, 10, 11, 12, 30}) {
        const Image image = noise(size, size + 1, 1);
        CHECK(ssim(image, image) == 1.0);
    }
}

TEST_CASE("constant pictures differ in luminance only") {
    // No variance: the second factor is c2 / c2.
    const double a = 51 / 255.0;
    const double b = 204 / 255.0;
    const double expected = (2 * a * b + c1) / (a * a + b * b + c1);
    for (const int size : {1, 4, 11, 25}) {
        CHECK(ssim(Image(size, size, gray(51)), Image(size, size, gray(204))) == Approx(expected));
        CHECK(ssim(Image(size, size, gray(0)), Image(size, size, gray(255))) == Approx(c1 / (1 + c1)));
    }
}

TEST_CASE("a single window over a single white pixel") {
    // The weight of the middle: along an axis 1 / (1 + 2 (e^(-1/4.5) + e^(-4/4.5) + ... + e^(-25/4.5)))
    // = 1 / (1 + 2 (0.8007374 + 0.4111123 + 0.1353353 + 0.0285655 + 0.0038659)) = 0.2660117, squared
    // 0.0707622. Against black: mean w, variance w - w^2, no covariance.
    const double w = 0.0707622;
    Image variant(11, 11, gray(0));
    variant.at(5, 5) = gray(255);
    const double expected = c1 / (w * w + c1) * c2 / (w - w * w + c2);
    CHECK(ssim(variant, Image(11, 11, gray(0))) == Approx(expected).epsilon(1e-5));
}

TEST_CASE("the luma weights are those of Rec. 601") {
    const Image black(3, 3, gray(0));
    const auto expected = [](double luma) { return c1 / (luma * luma + c1); };
    CHECK(ssim(Image(3, 3, {255, 0, 0, 255}), black) == Approx(expected(0.299)));
    CHECK(ssim(Image(3, 3, {0, 255, 0, 255}), black) == Approx(expected(0.587)));
    CHECK(ssim(Image(3, 3, {0, 0, 255, 255}), black) == Approx(expected(0.114)));
    CHECK(ssim(Image(3, 3, {0, 0, 0, 255}), Image(3, 3, {0, 0, 0, 0})) == 1.0);  // alpha is not compared
}

TEST_CASE("a picture and its negative have negative similarity") {
    const Image image = noise(24, 24, 5);
    Image negative(24, 24);
    for (int y = 0; y < 24; ++y) {
        for (int x = 0; x < 24; ++x) {
            const Rgba8 c = image.at(x, y);
            negative.at(x, y) = {static_cast<std::uint8_t>(255 - c.r), static_cast<std::uint8_t>(255 - c.g),
                                 static_cast<std::uint8_t>(255 - c.b), 255};
        }
    }
    CHECK(ssim(image, negative) < -0.5);
    CHECK(ssim(image, negative) >= -1.0);
}

TEST_CASE("the separable filter agrees with two-dimensional windows") {
    struct Size {
        int width, height;
    };
    for (const auto& [width, height] : {Size{11, 11}, {12, 11}, {17, 31}, {40, 23}}) {
        const Image a = noise(width, height, 1);
        const Image b = mixed(a, noise(width, height, 2));
        INFO(width << " x " << height);
        const double expected = brute_force(a, b, {0, 0, width, height});
        CHECK(expected > 0.5);
        CHECK(expected < 0.999);
        CHECK(ssim(a, b) == Approx(expected).epsilon(1e-10));
        CHECK(ssim(b, a) == ssim(a, b));
    }
}

TEST_CASE("windows are clipped along an axis that is shorter than they are") {
    struct Size {
        int width, height;
    };
    for (const auto& [width, height] : {Size{1, 1}, {2, 1}, {1, 7}, {5, 5}, {10, 10}, {10, 30}, {30, 3}}) {
        const Image a = noise(width, height, 3);
        const Image b = mixed(a, noise(width, height, 4));
        INFO(width << " x " << height);
        CHECK(ssim(a, b) == Approx(brute_force(a, b, {0, 0, width, height})).epsilon(1e-10));
    }
}

TEST_CASE("pixels outside of the rectangle do not count") {
    const Image a = noise(32, 32, 6);
    const Image b = mixed(a, noise(32, 32, 7));
    for (const PixelRect rect : {PixelRect{3, 4, 29, 20}, {-5, -5, 14, 14}, {20, 8, 24, 32}}) {
        const double expected = brute_force(a, b, rect.clipped_to(a));
        CHECK(ssim(a, b, rect) == Approx(expected).epsilon(1e-10));
    }
}

TEST_CASE("similarity that cannot be computed is refused") {
    CHECK_THROWS_AS(ssim(Image(20, 20), Image(20, 21)), std::invalid_argument);
    CHECK_THROWS_AS(ssim(Image(20, 20), Image(20, 20), PixelRect{20, 0, 40, 20}), std::invalid_argument);
    CHECK_THROWS_AS(ssim(Image{}, Image{}), std::invalid_argument);
}
