#include "farfield/measure/flip.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "catch.hpp"

using farfield::flip;
using farfield::flip_map;
using farfield::Image;
using farfield::PixelRect;
using farfield::Rgba8;
using farfield::detail::FlipFilters;

namespace {

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

// Smooth, with an edge and a dot, so that all parts of the measure have something to see.
Image drawing(int width, int height, int shift) {
    Image image(width, height);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const int step = 2 * (x + shift) > width ? 90 : 0;
            const bool dot = x == width / 4 + shift && y == height / 3;
            const auto byte = [](int v) { return static_cast<std::uint8_t>(std::clamp(v, 0, 255)); };
            image.at(x, y) = {byte(40 + 5 * y + step), byte(dot ? 250 : 60 + 4 * x), byte(200 - 6 * x + step), 255};
        }
    }
    return image;
}

Image crop(const Image& image, PixelRect r) {
    Image part(r.width(), r.height());
    for (int y = 0; y < r.height(); ++y) {
        for (int x = 0; x < r.width(); ++x) part.at(x, y) = image.at(r.x0 + x, r.y0 + y);
    }
    return part;
}

using Color = std::array<double, 3>;

Color transformed(const std::array<Color, 3>& m, const Color& c) {
    Color result{};
    for (std::size_t i = 0; i < 3; ++i) result[i] = m[i][0] * c[0] + m[i][1] * c[1] + m[i][2] * c[2];
    return result;
}

// sRGB and D65, to ten digits; the inverse to as many.
constexpr std::array<Color, 3> xyz_from_rgb{{{10135552 / 24577794.0, 8788810 / 24577794.0, 4435075 / 24577794.0},
                                             {2613072 / 12288897.0, 8788810 / 12288897.0, 887015 / 12288897.0},
                                             {1425312 / 73733382.0, 8788810 / 73733382.0, 70074185 / 73733382.0}}};
constexpr std::array<Color, 3> rgb_from_xyz{{{3.241003275, -1.537398934, -0.498615861},
                                             {-0.969224334, 1.875930071, 0.041554224},
                                             {0.055639423, -0.204011202, 1.057148933}}};
constexpr Color white{0.950428545, 1.0, 1.088900371};

double linear(std::uint8_t byte) {
    const double c = byte / 255.0;
    return c > 0.04045 ? std::pow((c + 0.055) / 1.055, 2.4) : c / 12.92;
}

Color xyz(Rgba8 c) {
    return transformed(xyz_from_rgb, {linear(c.r), linear(c.g), linear(c.b)});
}

// L*a*b* of CIE 1976, a* and b* times L* / 100.
Color hunt_lab(const Color& xyz) {
    const auto f = [&](std::size_t i) {
        const double t = xyz[i] / white[i];
        return t > 216.0 / 24389 ? std::cbrt(t) : (24389.0 / 27 * t + 16) / 116;
    };
    const double l = 116 * f(1) - 16;
    return {l, l / 100 * 500 * (f(0) - f(1)), l / 100 * 200 * (f(1) - f(2))};
}

double hyab(const Color& a, const Color& b) {
    return std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]);
}

// Of two colors after filtering.
double color_error(const Color& a, const Color& b) {
    const double largest = std::pow(hyab(hunt_lab(xyz({0, 255, 0})), hunt_lab(xyz({0, 0, 255}))), 0.7);
    const double distance = std::pow(hyab(a, b), 0.7);
    if (distance < 0.4 * largest) return 0.95 / (0.4 * largest) * distance;
    return 0.95 + (distance - 0.4 * largest) / (largest - 0.4 * largest) * 0.05;
}

double error_of_constant(Rgba8 a, Rgba8 b) {
    return color_error(hunt_lab(xyz(a)), hunt_lab(xyz(b)));
}

// The definition word by word: two-dimensional kernels, every tap clamped to the rectangle.
class BruteForce {
  public:
    BruteForce(PixelRect rect, double ppd) : r_(rect), ppd_(ppd) {}

    std::vector<double> errors(const Image& a, const Image& b) const {
        std::vector<double> result;
        for (int y = r_.y0; y < r_.y1; ++y) {
            for (int x = r_.x0; x < r_.x1; ++x) {
                const double color = color_error(filtered(a, x, y), filtered(b, x, y));
                const double edge = std::abs(feature(a, x, y, false) - feature(b, x, y, false));
                const double point = std::abs(feature(a, x, y, true) - feature(b, x, y, true));
                const double delta_f = std::sqrt(std::max(edge, point) / std::sqrt(2.0));
                result.push_back(std::pow(color, 1 - delta_f));
            }
        }
        return result;
    }

  private:
    Color ycxcz(const Image& image, int x, int y) const {
        const Color c = xyz(image.at(std::clamp(x, r_.x0, r_.x1 - 1), std::clamp(y, r_.y0, r_.y1 - 1)));
        const double yn = c[1] / white[1];
        return {116 * yn - 16, 500 * (c[0] / white[0] - yn), 200 * (yn - c[2] / white[2])};
    }

    Color filtered(const Image& image, int x, int y) const {
        struct Sensitivity {
            double a1, b1, a2, b2;
        };
        constexpr Sensitivity table[]{{1, 0.0047, 0, 1e-5}, {1, 0.0053, 0, 1e-5}, {34.1, 0.04, 13.5, 0.025}};
        constexpr double pi = std::numbers::pi;
        const int radius = static_cast<int>(std::ceil(3 * std::sqrt(0.04 / (2 * pi * pi)) * ppd_));
        Color sum{}, weights{};
        for (int dy = -radius; dy <= radius; ++dy) {
            for (int dx = -radius; dx <= radius; ++dx) {
                const Color c = ycxcz(image, x + dx, y + dy);
                const double squared = (dx * dx + dy * dy) / (ppd_ * ppd_);
                for (std::size_t k = 0; k < 3; ++k) {
                    const auto& [a1, b1, a2, b2] = table[k];
                    const double weight = a1 * std::sqrt(pi / b1) * std::exp(-pi * pi * squared / b1) +
                                          a2 * std::sqrt(pi / b2) * std::exp(-pi * pi * squared / b2);
                    sum[k] += weight * c[k];
                    weights[k] += weight;
                }
            }
        }
        for (std::size_t k = 0; k < 3; ++k) sum[k] /= weights[k];
        const double yn = (sum[0] + 16) / 116;
        Color rgb = transformed(rgb_from_xyz, {white[0] * (yn + sum[1] / 500), yn, white[2] * (yn - sum[2] / 200)});
        for (double& channel : rgb) channel = std::clamp(channel, 0.0, 1.0);
        return hunt_lab(transformed(xyz_from_rgb, rgb));
    }

    double feature(const Image& image, int x, int y, bool point) const {
        const double sigma = 0.5 * 0.082 * ppd_;
        const int radius = static_cast<int>(std::ceil(3 * sigma));
        const auto weight = [&](int u, int v) {
            const double g = std::exp(-(u * u + v * v) / (2 * sigma * sigma));
            return point ? (u * u / (sigma * sigma) - 1) * g : -u * g;
        };
        double positive = 0, negative = 0;
        for (int v = -radius; v <= radius; ++v) {
            for (int u = -radius; u <= radius; ++u) (weight(u, v) > 0 ? positive : negative) += weight(u, v);
        }
        double across = 0, down = 0;
        for (int v = -radius; v <= radius; ++v) {
            for (int u = -radius; u <= radius; ++u) {
                const double w = weight(u, v) > 0 ? weight(u, v) / positive : -weight(u, v) / negative;
                across += w * (ycxcz(image, x + u, y + v)[0] + 16) / 116;
                down += w * (ycxcz(image, x + v, y + u)[0] + 16) / 116;
            }
        }
        return std::hypot(across, down);
    }

    PixelRect r_;
    double ppd_;
};

void check_against_definition(const Image& a, const Image& b, PixelRect rect, double ppd) {
    INFO(rect.width() << " x " << rect.height() << " at " << ppd << " pixels per degree");
    const std::vector<double> expected = BruteForce(rect, ppd).errors(a, b);
    const std::vector<float> errors = flip_map(a, b, rect, ppd);
    REQUIRE(errors.size() == expected.size());
    double sum = 0, worst = 0;
    for (std::size_t i = 0; i < errors.size(); ++i) {
        sum += expected[i];
        worst = std::max(worst, std::abs(double(errors[i]) - expected[i]));
    }
    CHECK(worst < 1e-5);  // the digits of the inverse matrix above; float
    CHECK(flip(a, b, rect, ppd) == Approx(sum / double(errors.size())).epsilon(1e-6));
}

}  // namespace

TEST_CASE("pictures of equal colors are no different, exactly") {
    for (const int size : {1, 2, 9, 30}) {
        const Image a = noise(size, size + 1, 1);
        Image b = a;
        for (Rgba8& pixel : b.pixels()) pixel.a = static_cast<std::uint8_t>(255 - pixel.a);
        CHECK(flip(a, b) == 0.0);
        for (const float error : flip_map(a, b)) CHECK(error == 0.0f);
    }
}

TEST_CASE("constant pictures differ by their colors alone") {
    // Filters of sum 1 do nothing there, features are none.
    const std::initializer_list<Rgba8> colors{gray(0),       gray(255),       gray(128),     gray(7),
                                              {0, 255, 0},   {0, 0, 255},     {255, 0, 0},   {255, 255, 0},
                                              {0, 255, 255}, {255, 0, 255},   {12, 200, 90}, {13, 200, 90},
                                              {90, 20, 120}, {255, 254, 255}, {1, 0, 0}};
    for (const Rgba8 a : colors) {
        for (const Rgba8 b : colors) {
            const double expected = error_of_constant(a, b);
            INFO(int(a.r) << " " << int(a.g) << " " << int(a.b) << " | " << int(b.r) << " " << int(b.g) << " "
                          << int(b.b));
            CHECK(flip(Image(1, 1, a), Image(1, 1, b)) == Approx(expected).epsilon(1e-7).margin(1e-9));
            CHECK(flip(Image(23, 6, a), Image(23, 6, b)) == Approx(expected).epsilon(1e-7).margin(1e-9));
            CHECK(flip(Image(23, 6, a), Image(23, 6, b)) <= 1.0);
        }
    }
}

TEST_CASE("black and white, green and blue") {
    // Green has L* = 87.735, a* = -86.183, b* = 83.180, blue 32.297, 79.188, -107.860 (sRGB, D65). Times L* / 100,
    // a* and b* are -75.612, 72.977 and 25.575, -34.836: the distance is 55.438 + |(101.187, 107.813)| = 203.298,
    // to the power 0.7 41.280. Black and white are 100 apart, to the power 0.7 25.119: 0.60850 of it, and
    // 0.95 + (0.60850 - 0.4) / 0.6 * 0.05 = 0.96738.
    CHECK(flip(Image(5, 5, gray(0)), Image(5, 5, gray(255))) == Approx(0.96738).margin(2e-5));
    CHECK(flip(Image(5, 5, {0, 255, 0}), Image(5, 5, {0, 0, 255})) == Approx(1.0).epsilon(1e-12));
}

TEST_CASE("the separable filters agree with two-dimensional kernels") {
    struct Size {
        int width, height;
    };
    for (const auto& [width, height] : {Size{18, 15}, {1, 1}, {1, 9}, {9, 1}, {2, 3}, {30, 4}}) {
        const PixelRect all{0, 0, width, height};
        check_against_definition(drawing(width, height, 0), drawing(width, height, 2), all, 20);
        check_against_definition(noise(width, height, 1), noise(width, height, 2), all, 20);
    }
    for (const double ppd : {2.0, 7.5, 33.3, farfield::flip_pixels_per_degree}) {
        check_against_definition(drawing(14, 12, 0), drawing(14, 12, 3), {0, 0, 14, 12}, ppd);
        check_against_definition(noise(14, 12, 3), noise(14, 12, 4), {0, 0, 14, 12}, ppd);
    }
}

TEST_CASE("weights have the sums that they should have") {
    for (const double ppd : {1e-300, 0.5, 4.0, 8.13, 8.14, farfield::flip_pixels_per_degree, 500.0}) {
        INFO(ppd);
        const FlipFilters filters(ppd);
        for (const auto& w : {filters.achromatic, filters.red_green, filters.blue_yellow_wide,
                              filters.blue_yellow_narrow, filters.smooth}) {
            double sum = w[0];
            for (std::size_t i = 1; i < w.size(); ++i) sum += 2 * w[i];
            CHECK(sum == Approx(1.0));
        }
        double edges = 0, positive = 0, negative = std::min(filters.point[0], 0.0);
        for (std::size_t i = 1; i < filters.edge.size(); ++i) {
            edges += filters.edge[i];
            (filters.point[i] > 0 ? positive : negative) += 2 * filters.point[i];
        }
        CHECK(filters.edge[0] == 0.0);
        CHECK(edges == Approx(1.0));
        CHECK(positive == Approx(1.0));
        CHECK(negative == Approx(-1.0));
        CHECK(filters.blue_yellow_wide_share > 0.5);
        CHECK(filters.blue_yellow_wide_share < 1.0);
    }
    // Three standard deviations of the widest: 3 sqrt(0.04 / (2 pi^2)) 67.02 = 9.05 and 3 * 0.5 * 0.082 * 67.02 = 8.24.
    const FlipFilters usual(farfield::flip_pixels_per_degree);
    CHECK(usual.blue_yellow_wide.size() == 11);
    CHECK(usual.point.size() == 10);
}

TEST_CASE("where nothing is, no feature is found, exactly") {
    const farfield::detail::FlipColors space;
    const FlipFilters filters(farfield::flip_pixels_per_degree);
    for (const Rgba8 color : {gray(1), gray(77), gray(255), Rgba8{200, 13, 99}}) {
        const Image image(12, 40, color);
        farfield::detail::FlipRows rows(image, {0, 0, 12, 40}, space, filters);
        for (int y = 0; y < 40; ++y) {
            rows.advance();
            for (const double edge : rows.edges) CHECK(edge == 0.0);
            for (const double point : rows.points) CHECK(point == 0.0);
        }
    }
}

TEST_CASE("errors are symmetric and in the unit range") {
    for (std::uint32_t seed = 1; seed < 9; ++seed) {
        const Image a = noise(31, 17, seed);
        const Image b = seed % 2 == 0 ? noise(31, 17, seed + 100) : Image(31, 17, gray(seed > 4 ? 255 : 0));
        for (const double ppd : {0.1, 5.0, farfield::flip_pixels_per_degree}) {
            const std::vector<float> errors = flip_map(a, b, {}, ppd);
            REQUIRE(errors.size() == 31 * 17);
            double sum = 0;
            for (const float error : errors) {
                CHECK(error >= 0.0f);
                CHECK(error <= 1.0f);
                sum += double(error);
            }
            CHECK(flip_map(b, a, {}, ppd) == errors);
            CHECK(flip(a, b, {}, ppd) == flip(b, a, {}, ppd));
            CHECK(flip(a, b, {}, ppd) == Approx(sum / (31 * 17)));
        }
    }
}

TEST_CASE("the error of a constant shift grows with it") {
    const Image reference(8, 8, gray(100));
    double last = 0;
    for (int value = 101; value < 256; ++value) {
        const double error = flip(Image(8, 8, gray(value)), reference);
        CHECK(error > last);
        last = error;
    }
}

TEST_CASE("the finer the pixels, the less noise is seen") {
    // Half of white's light is gray 188 (0.503): what remains when the pattern can no longer be seen.
    const Image reference(40, 40, gray(188));
    Image variant = reference;
    for (int y = 0; y < 40; ++y) {
        for (int x = 0; x < 40; ++x) variant.at(x, y) = gray((x + y) % 2 == 0 ? 0 : 255);
    }
    double last = 1;
    for (const double ppd : {5.0, 20.0, 40.0, 80.0}) {
        const double error = flip(variant, reference, PixelRect{0, 0, 40, 40}, ppd);
        CHECK(error < last);
        last = error;
    }
    CHECK(last < 0.1);
}

TEST_CASE("an edge that went raises the error of its colors") {
    // On both sides of the edge, as different as before: without it the colors alone would count.
    Image edge(41, 20, gray(60));
    for (int y = 0; y < 20; ++y) {
        for (int x = 20; x < 41; ++x) edge.at(x, y) = gray(70);
    }
    const Image flat(41, 20, gray(65));
    const std::vector<float> errors = flip_map(edge, flat);
    const float far_from_it = errors[41 * 10 + 2];
    CHECK(double(far_from_it) == Approx(error_of_constant(gray(60), gray(65))).epsilon(1e-5));
    CHECK(errors[41 * 10 + 18] > 1.1f * far_from_it);
}

TEST_CASE("pixels outside of the rectangle do not change its errors") {
    const Image a = noise(33, 28, 6);
    const Image b = drawing(33, 28, 1);
    for (const PixelRect rect : {PixelRect{3, 4, 29, 20}, {-5, -5, 14, 14}, {20, 8, 24, 99}, {7, 7, 8, 8}}) {
        const PixelRect inside = rect.clipped_to(a);
        CHECK(flip_map(a, b, rect) == flip_map(crop(a, inside), crop(b, inside)));
        CHECK(flip(a, b, rect) == flip(crop(a, inside), crop(b, inside)));
    }
    check_against_definition(a, b, {20, 8, 28, 14}, 30);
}

TEST_CASE("a difference that cannot be computed is refused") {
    const Image image(20, 20);
    CHECK_THROWS_AS(flip(image, Image(20, 21)), std::invalid_argument);
    CHECK_THROWS_AS(flip(image, image, PixelRect{20, 0, 40, 20}), std::invalid_argument);
    CHECK_THROWS_AS(flip(Image{}, Image{}), std::invalid_argument);
    CHECK_THROWS_AS(flip_map(Image{}, Image{}), std::invalid_argument);
    constexpr double infinity = std::numeric_limits<double>::infinity();
    for (const double ppd : {0.0, -1.0, infinity, -infinity, std::numeric_limits<double>::quiet_NaN(), 10'000.1}) {
        CHECK_THROWS_AS(flip(image, image, {}, ppd), std::invalid_argument);
        CHECK_THROWS_AS(flip_map(image, image, {}, ppd), std::invalid_argument);
    }
    CHECK(flip(Image(2, 1, gray(9)), Image(2, 1, gray(9)), {}, 10'000) == 0.0);
    CHECK(flip(Image(2, 1, gray(0)), Image(2, 1, gray(255)), {}, std::numeric_limits<double>::denorm_min()) ==
          Approx(error_of_constant(gray(0), gray(255))));
}
