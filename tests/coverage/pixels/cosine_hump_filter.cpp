// Against the convolution itself, in double precision.
#include "farfield/coverage/pixels/cosine_hump_filter.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "catch.hpp"
#include "coverage/random_samples.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {
/// Of a sample (i, j), counted from the first one of the pixel.
double kernel(int i, int j) {
    const double r = std::hypot(2 * i - 7, 2 * j - 7) / 16;
    return r < 1 ? (1 + std::cos(std::acos(-1.0) * r)) / 2 : 0;
}
int rounded(int i, int j) {
    return detail::CosineHump::weight(2 * i - 7, 2 * j - 7);
}

/// Mean of the samples of an image around a pixel.
template <class Weight>
std::array<double, 4> mean(const RandomSamples& samples, int x, int y, Weight&& weight) {
    std::array<double, 4> sum{};
    double weights = 0;
    for (int j = std::max(-8, -8 * y); j < std::min(16, 8 * (samples.height - y)); ++j) {
        for (int i = std::max(-8, -8 * x); i < std::min(16, 8 * (samples.width - x)); ++i) {
            const double w = weight(i, j);
            const Rgba8 c = samples.at(8 * x + i, 8 * y + j);
            weights += w;
            sum[0] += w * c.r;
            sum[1] += w * c.g;
            sum[2] += w * c.b;
            sum[3] += w * c.a;
        }
    }
    for (double& s : sum) s /= weights;
    return sum;
}
double largest_difference(Rgba8 c, const std::array<double, 4>& mean) {
    return std::max(
        {std::abs(c.r - mean[0]), std::abs(c.g - mean[1]), std::abs(c.b - mean[2]), std::abs(c.a - mean[3])});
}
constexpr std::pair<int, int> sizes[] = {{1, 1}, {1, 5}, {2, 1}, {7, 3}, {8, 8}, {65, 9}, {512, 512}, {641, 359}};
}  // namespace

TEST_CASE("rounding the kernel to whole numbers costs less than a fifth of a step, whatever the colors", "[coverage]") {
    // A mean errs most where the samples that weigh too much are white and the others black.
    for (int columns = 1; columns < 8; ++columns) {
        for (int rows = 1; rows < 8; ++rows) {
            if ((columns & 2) == 0 || (rows & 2) == 0) continue;  // pixels have their own samples
            double exact_sum = 0, sum = 0, too_much = 0;
            const auto for_samples = [&](auto&& f) {
                for (int j = -8; j < 16; ++j) {
                    for (int i = -8; i < 16; ++i) {
                        if ((columns >> (i + 8) / 8 & rows >> (j + 8) / 8 & 1) != 0) f(i, j);
                    }
                }
            };
            for_samples([&](int i, int j) { exact_sum += kernel(i, j), sum += rounded(i, j); });
            for_samples(
                [&](int i, int j) { too_much += std::max(0.0, rounded(i, j) / sum - kernel(i, j) / exact_sum); });
            CHECK(too_much * 255 < 0.2);
            CHECK(detail::cosine_hump.of_pixels[unsigned(columns)][unsigned(rows)] == float(sum));
        }
    }
}

TEST_CASE("pixels are what the convolution gives, in any order, frame after frame", "[coverage]") {
    Random random(510);
    CosineHumpFilter filter;
    Image image, again(3, 3);
    for (const auto& [width, height] : sizes) {
        RandomSamples samples(width, height, random);
        filter.begin(width, height);
        samples.draw(filter);
        filter.resolve(image);
        double from_kernel = 0, from_weights = 0;
        const int step = width * height > 10000 ? 17 : 1;
        for (int y = 0; y < height; ++y) {
            const bool is_border = y == 0 || y == height - 1;
            for (int x = 0; x < width; x = is_border || x >= width - 1 - step ? x + 1 : x + step) {
                from_kernel = std::max(from_kernel, largest_difference(image.at(x, y), mean(samples, x, y, kernel)));
                from_weights = std::max(from_weights, largest_difference(image.at(x, y), mean(samples, x, y, rounded)));
            }
        }
        CHECK(from_kernel < 0.5 + 0.2);
        CHECK(from_weights < 0.5 + 1e-4);
        random.shuffle(samples.pieces);
        filter.begin(width, height);
        samples.draw(filter);
        filter.resolve(again);
        CHECK(again == image);
    }
}

TEST_CASE("images of one color are that color, to the border", "[coverage]") {
    Random random(511);
    CosineHumpFilter filter;
    Image image;
    for (const auto& [width, height] : sizes) {
        for (int i = 0; i < (width * height > 10000 ? 2 : 40); ++i) {
            const Rgba8 c = RandomSamples::any_color(random);
            RandomSamples samples(width, height, random);
            for (auto& piece : samples.pieces) piece.color = c;
            filter.begin(width, height);
            samples.draw(filter);
            filter.resolve(image);
            CHECK(image == Image(width, height, c));
        }
    }
}

TEST_CASE("rectangles need not be blocks", "[coverage]") {
    Random random(512);
    const int width = 9, height = 6;
    CosineHumpFilter whole, pixel_by_pixel;
    Image a, b;
    for (int i = 0; i < 300; ++i) {
        const int x = int(random.below(9)), y = int(random.below(6));
        const int w = 1 + int(random.below(9)), h = 1 + int(random.below(6));
        const Rgba8 c = random.color(), background = random.color();
        whole.begin(width, height);
        pixel_by_pixel.begin(width, height);
        whole.fill(x, y, w, h, c);
        for (int j = 0; j < height; ++j) {
            for (int k = 0; k < width; ++k) {
                const bool inside = k >= x && k < x + w && j >= y && j < y + h;
                pixel_by_pixel.add(k, j, ~std::uint64_t(0), inside ? c : background, true);
                if (!inside) whole.add(k, j, ~std::uint64_t(0), background, true);
            }
        }
        whole.resolve(a);
        pixel_by_pixel.resolve(b);
        CHECK(a == b);
    }
}

TEST_CASE("pixels beyond the image are nothing, whole blocks of pixels are rectangles", "[coverage]") {
    const Rgba8 white{255, 255, 255, 255}, black{0, 0, 0, 255};
    CosineHumpFilter by_pixels, by_rectangles;
    Image a, b;
    by_pixels.begin(21, 18);
    by_rectangles.begin(21, 18);
    by_rectangles.fill(0, 0, 8, 8, white);
    by_rectangles.fill(8, 0, 64, 18, black);
    by_rectangles.fill(0, 8, 8, 8, black);
    by_rectangles.fill(0, 16, 8, 1, white);
    by_rectangles.fill(0, 17, 8, 64, black);
    by_rectangles.fill(24, 0, 8, 8, white);
    by_rectangles.fill(0, 24, 64, 64, white);
    for (int y = 0; y < 24; y += 8) {
        for (int x = 0; x < 24; x += 8) {
            if (x == 0 && y == 16) {
                by_pixels.fill_pixels(x, y, 0xff, white);
                by_pixels.fill_pixels(x, y, ~std::uint64_t(0xff), black);
            } else {
                by_pixels.fill_pixels(x, y, ~std::uint64_t(0), x + y == 0 ? white : black);
            }
        }
    }
    by_pixels.resolve(a);
    by_rectangles.resolve(b);
    CHECK(a == b);
}

TEST_CASE("the response to a pixel is symmetric and falls off to nothing beyond its neighbors", "[coverage]") {
    CosineHumpFilter filter;
    filter.begin(5, 5);
    filter.fill(0, 0, 5, 5, {0, 0, 0, 0});
    filter.add(2, 2, ~std::uint64_t(0), {255, 255, 255, 255}, false);
    Image image;
    filter.resolve(image);
    for (int y = 0; y < 5; ++y) {
        for (int x = 0; x < 5; ++x) {
            CHECK(image.at(x, y) == image.at(4 - x, y));
            CHECK(image.at(x, y) == image.at(y, x));
        }
    }
    CHECK(image.at(2, 2).r > image.at(1, 2).r);
    CHECK(image.at(1, 2).r > image.at(1, 1).r);
    CHECK(image.at(0, 2).r == 0);
}
