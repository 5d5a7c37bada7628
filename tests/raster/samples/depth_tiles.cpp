// A tile's farthest depth is asked for when what is known of it does not answer, and only then.
#include "farfield/raster/samples/depth_tiles.hpp"

#include <cmath>
#include <vector>

#include "catch.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

TEST_CASE("answers are those of every sample of the tiles touched, and err only towards no", "[raster]") {
    Random random(90);
    for (const auto& size : {std::pair{1, 1}, {8, 8}, {9, 17}, {40, 23}}) {
        const int width = size.first, height = size.second;
        std::vector<float> depth(std::size_t(width * height), -INFINITY);
        DepthTiles tiles;
        tiles.begin(width, height);
        const auto least = [&](int left, int top, int right, int bottom) {
            float q = INFINITY;
            for (int y = top; y < std::min(bottom, height); ++y) {
                for (int x = left; x < std::min(right, width); ++x) q = std::min(q, depth[std::size_t(y * width + x)]);
            }
            return q;
        };
        for (int i = 0; i < 3000; ++i) {
            float& d = depth[random.below(std::uint32_t(depth.size()))];
            d = std::max(d, random.between(0, 1));  // only ever nearer
            int x0 = int(random.below(std::uint32_t(width))), x1 = int(random.below(std::uint32_t(width)));
            int y0 = int(random.below(std::uint32_t(height))), y1 = int(random.below(std::uint32_t(height)));
            if (x0 > x1) std::swap(x0, x1);
            if (y0 > y1) std::swap(y0, y1);
            const float q = random.between(0, 1);
            const bool all = least(x0 / 8 * 8, y0 / 8 * 8, x1 / 8 * 8 + 8, y1 / 8 * 8 + 8) > q;
            CHECK(tiles.all_nearer(x0, y0, x1, y1, q, least) == all);
        }
        tiles.begin(width, height);
        std::size_t asked = 0;
        CHECK_FALSE(
            tiles.all_nearer(0, 0, width - 1, height - 1, 2, [&](int, int, int, int) { return ++asked, 1.0f; }));
        CHECK(asked == 1);
        CHECK(tiles.all_nearer(0, 0, 0, 0, 0.5f, [&](int, int, int, int) { return ++asked, 1.0f; }));
        CHECK(asked == 2);
        CHECK(tiles.all_nearer(0, 0, 0, 0, 0.9f, [&](int, int, int, int) { return ++asked, 0.0f; }));
        CHECK(asked == 2);  // known from before
        tiles.clear({});
        CHECK(tiles.all_nearer(0, 0, 0, 0, 0.9f, [&](int, int, int, int) { return ++asked, 0.0f; }));
        CHECK(asked == 2);
        tiles.clear({0, 0, 1, 1});
        CHECK_FALSE(tiles.all_nearer(0, 0, 0, 0, 0.9f, [&](int, int, int, int) { return ++asked, 0.0f; }));
        CHECK(asked == 3);
    }
}
