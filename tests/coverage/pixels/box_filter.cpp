// Every pixel is the mean of its samples, whatever pieces they come in.
#include "farfield/coverage/pixels/box_filter.hpp"

#include <array>
#include <cmath>
#include <utility>

#include "catch.hpp"
#include "coverage/random_samples.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {
Image means(const RandomSamples& samples) {
    Image image(samples.width, samples.height);
    for (int y = 0; y < image.height(); ++y) {
        for (int x = 0; x < image.width(); ++x) {
            std::array<double, 4> sum{};
            for (int k = 0; k < 64; ++k) {
                const Rgba8 c = samples.at(8 * x + k % 8, 8 * y + k / 8);
                sum[0] += c.r;
                sum[1] += c.g;
                sum[2] += c.b;
                sum[3] += c.a;
            }
            const auto mean = [&](unsigned i) { return std::uint8_t(std::floor(sum[i] / 64 + 0.5)); };
            image.at(x, y) = {mean(0), mean(1), mean(2), mean(3)};
        }
    }
    return image;
}
}  // namespace

TEST_CASE("means of samples are exact in any order, frame after frame", "[coverage]") {
    Random random(500);
    BoxFilter filter;
    Image image, again(3, 3);
    for (const auto& size : {std::pair{1, 1}, {7, 3}, {8, 8}, {65, 9}, {512, 512}, {641, 359}}) {
        for (int frame = 0; frame < 2; ++frame) {
            RandomSamples samples(size.first, size.second, random);
            filter.begin(size.first, size.second);
            samples.draw(filter);
            filter.resolve(image);
            CHECK(image == means(samples));
            random.shuffle(samples.pieces);
            filter.begin(size.first, size.second);
            samples.draw(filter);
            filter.resolve(again);
            CHECK(again == image);
        }
    }
}

TEST_CASE("the functions that take indices do what those do that take coordinates", "[coverage]") {
    Random random(501);
    const int width = 43, height = 21;
    BoxFilter by_coordinates, by_index;
    for (int frame = 0; frame < 4; ++frame) {
        by_coordinates.begin(width, height);
        by_index.begin(width, height);
        for (int y = 0; y < height; y += 8) {
            for (int x = 0; x < width; x += 8) {
                const std::size_t block = by_index.block_of(x, y);
                const Rgba8 one = random.color(), other = random.color();
                if (random.below(2) == 0) {
                    by_coordinates.fill(x, y, 8, 8, one);
                    by_index.fill_block(block, one);
                    continue;
                }
                const std::uint64_t whole = random.bits(), some = random.bits();
                by_index.open_block(block);
                by_index.fill_pixels(block, whole, one);
                by_coordinates.fill_pixels(x, y, whole, one);
                for (unsigned k = 0; k < 64; ++k) {
                    const int i = x + int(k % 8), j = y + int(k / 8);
                    CHECK(by_index.index_of(i, j) == block * 64 + k);
                    if ((whole >> k & 1) != 0) continue;
                    by_index.add_at(block * 64 + k, bit_count(some), one, true);
                    by_index.add_at(block * 64 + k, bit_count(~some), other, false);
                    if (i >= width || j >= height) continue;
                    by_coordinates.add(i, j, ~some, other, true);
                    by_coordinates.add(i, j, some, one, false);
                }
            }
        }
        Image a, b;
        by_coordinates.resolve(a);
        by_index.resolve(b);
        CHECK(a == b);
    }
}

TEST_CASE("images of one color are that color", "[coverage]") {
    Random random(502);
    BoxFilter filter;
    Image image;
    for (int i = 0; i < 40; ++i) {
        const Rgba8 c = RandomSamples::any_color(random);
        RandomSamples samples(13, 11, random);
        for (auto& piece : samples.pieces) piece.color = c;
        filter.begin(13, 11);
        samples.draw(filter);
        filter.resolve(image);
        CHECK(image == Image(13, 11, c));
    }
}

TEST_CASE("halves are rounded up", "[coverage]") {
    BoxFilter filter;
    Image image;
    filter.begin(2, 1);
    filter.add(0, 0, 0xffffffffu, {1, 2, 254, 255}, true);
    filter.add(0, 0, 0xffffffff00000000u, {0, 1, 255, 0}, false);
    filter.add(1, 0, 0x7fffffffu, {1, 1, 1, 1}, true);
    filter.add(1, 0, 0xffffffff80000000u, {0, 0, 0, 0}, false);
    filter.resolve(image);
    CHECK(image.at(0, 0) == Rgba8{1, 2, 255, 128});
    CHECK(image.at(1, 0) == Rgba8{0, 0, 0, 0});
}

TEST_CASE("bits are counted", "[coverage]") {
    Random random(503);
    CHECK(bit_count(0) == 0);
    CHECK(bit_count(~std::uint64_t(0)) == 64);
    for (int i = 0; i < 1000; ++i) {
        const std::uint64_t a = random.bits(), b = random.bits();
        CHECK(bit_count(a & b) == std::popcount(a & b));
    }
}
