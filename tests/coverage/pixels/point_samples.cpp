// Pixels are what was written last, whatever pieces they come in.
#include "farfield/coverage/pixels/point_samples.hpp"

#include <utility>
#include <vector>

#include "catch.hpp"
#include "coverage/random_samples.hpp"

using namespace farfield;
using namespace farfield::test;

TEST_CASE("every pixel has the color that came for it, frame after frame", "[coverage]") {
    Random random(530);
    PointSamples points;
    Image image(2, 9), again;
    for (const auto& size : {std::pair{1, 1}, {7, 3}, {8, 8}, {65, 9}, {512, 512}, {641, 359}}) {
        const int width = size.first, height = size.second;
        for (int frame = 0; frame < 3; ++frame) {
            struct Piece {
                std::size_t block;
                std::uint64_t pixels;  ///< 0: all, by fill_block
                Rgba8 color;
            };
            Image expected(width, height);
            std::vector<Piece> pieces;
            points.begin(width, height);
            for (int y = 0; y < height; y += 8) {
                for (int x = 0; x < width; x += 8) {
                    const auto add = [&](std::uint64_t pixels) {
                        const Rgba8 c = RandomSamples::any_color(random);
                        pieces.push_back({points.block_of(x, y), pixels, c});
                        for (int k = 0; k < 64; ++k) {
                            const int i = x + k % 8, j = y + k / 8;
                            if (i < width && j < height && (pixels == 0 || (pixels >> k & 1) != 0))
                                expected.at(i, j) = c;
                        }
                    };
                    if (random.below(3) == 0) {
                        add(0);
                        continue;
                    }
                    for (std::uint64_t left = ~std::uint64_t(0); left != 0;) {
                        const std::uint64_t bits = random.bits();
                        const std::uint64_t mask = random.below(3) == 0 ? left : left & bits;
                        if (mask != 0) add(mask);
                        left &= ~mask;
                    }
                }
            }
            random.shuffle(pieces);
            for (const Piece& p : pieces) {
                if (p.pixels == 0) {
                    points.fill_block(p.block, p.color);
                } else {
                    points.add(p.block, p.pixels, p.color);
                }
            }
            points.resolve(image);
            CHECK(image == expected);
            points.resolve(again);
            CHECK(again == expected);
        }
    }
}

TEST_CASE("rectangles of blocks end at the border", "[coverage]") {
    PointSamples points;
    Image image;
    points.begin(70, 67);
    points.fill(0, 0, 64, 64, {1, 2, 3, 4});
    points.fill(64, 0, 64, 64, {5, 6, 7, 8});
    points.fill(0, 64, 64, 64, {9, 10, 11, 12});
    points.fill(64, 64, 64, 64, {13, 14, 15, 16});
    points.fill(128, 0, 64, 64, {0, 0, 0, 0});
    points.fill(0, 128, 64, 64, {0, 0, 0, 0});
    points.resolve(image);
    for (int y = 0; y < 67; ++y) {
        for (int x = 0; x < 70; ++x) {
            const Rgba8 c = image.at(x, y);
            CHECK(int(c.r) == 1 + 4 * (x / 64) + 8 * (y / 64));
        }
    }
}
