// The answer is that of every sample of the rectangle.
#include "farfield/raster/samples/depth_pyramid.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "catch.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

namespace {

/// Brings one sample nearer, through the block that it lies in.
void set(SampleBlocks& blocks, int x, int y, float q) {
    const int column = x / SampleBlocks::side, row = y / SampleBlocks::side;
    const std::size_t at = blocks.index(column, row);
    blocks.opened(at, column, row).depth[y % SampleBlocks::side * SampleBlocks::side + x % SampleBlocks::side] = q;
    blocks.add_drawn(x, y, x + 1, y + 1);
    blocks.filled(at, q);
}

bool each_nearer(const std::vector<float>& depth, int width, int x0, int y0, int x1, int y1, float q) {
    for (int y = y0; y <= y1; ++y) {
        for (int x = x0; x <= x1; ++x) {
            if (!(depth[std::size_t(y * width + x)] > q)) return false;
        }
    }
    return true;
}

}  // namespace

TEST_CASE("depth pyramid: answers are those of every sample", "[raster]") {
    Random random(430);
    for (const auto& size : {std::pair{1, 1}, {8, 8}, {9, 17}, {64, 64}, {65, 3}, {200, 130}, {3, 530}}) {
        const int width = size.first, height = size.second;
        std::vector<float> depth(std::size_t(width * height));
        SampleBlocks blocks;
        blocks.resize(width, height, {});
        DepthPyramid pyramid;
        for (int frame = 0; frame < 3; ++frame) {
            std::fill(depth.begin(), depth.end(), -INFINITY);
            blocks.clear();
            pyramid.begin(blocks);
            int yes = 0, wrong = 0;
            for (int i = 0; i < 1500; ++i) {
                const auto rectangle = [&](int& a, int& b, int size_on_axis) {
                    a = int(random.below(std::uint32_t(size_on_axis)));
                    b = int(random.below(std::uint32_t(size_on_axis)));
                    if (a > b) std::swap(a, b);
                };
                int x0, x1, y0, y1;
                rectangle(x0, x1, width);
                rectangle(y0, y1, height);
                // Only ever nearer. The picture as a whole closes by and by.
                const bool is_all = i % 100 == 0;
                const float at_least = is_all ? float(i) / 2000 : random.unit();
                for (int y = is_all ? 0 : y0; y <= (is_all ? height - 1 : y1); ++y) {
                    for (int x = is_all ? 0 : x0; x <= (is_all ? width - 1 : x1); ++x) {
                        float& d = depth[std::size_t(y * width + x)];
                        d = std::max(d, at_least);
                        set(blocks, x, y, d);
                    }
                }
                for (int k = 0; k < 10; ++k) {
                    rectangle(x0, x1, width);
                    rectangle(y0, y1, height);
                    const float q = random.unit();
                    const bool answer = pyramid.all_nearer(x0, y0, x1, y1, q);
                    wrong += answer != each_nearer(depth, width, x0, y0, x1, y1, q);
                    yes += answer;
                }
            }
            INFO(width << " x " << height);
            CHECK(wrong == 0);
            CHECK(yes > 1000);
        }
    }
}

TEST_CASE("depth pyramid: one sample of many is enough to be seen", "[raster]") {
    const int width = 150, height = 140;
    SampleBlocks blocks;
    blocks.resize(width, height, {});
    DepthPyramid pyramid;
    const auto fill = [&] {
        blocks.clear();
        pyramid.begin(blocks);
        for (int y = 0; y < height; ++y) {
            for (int x = 0; x < width; ++x) set(blocks, x, y, 1);
        }
    };
    fill();
    CHECK(pyramid.all_nearer(0, 0, width - 1, height - 1, 0.5f));
    CHECK_FALSE(pyramid.all_nearer(0, 0, width - 1, height - 1, 1));  // as near is not nearer
    Random random(431);
    for (int i = 0; i < 200; ++i) {
        blocks.clear();
        pyramid.begin(blocks);
        const int x = int(random.below(std::uint32_t(width))), y = int(random.below(std::uint32_t(height)));
        for (int v = 0; v < height; ++v) {
            for (int u = 0; u < width; ++u) set(blocks, u, v, u == x && v == y ? 0.25f : 1.0f);
        }
        CHECK_FALSE(pyramid.all_nearer(0, 0, width - 1, height - 1, 0.5f));
        CHECK(pyramid.all_nearer(0, 0, width - 1, height - 1, 0.2f));
        if (x > 0) CHECK(pyramid.all_nearer(0, 0, x - 1, height - 1, 0.5f));
        if (y + 1 < height) CHECK(pyramid.all_nearer(0, y + 1, width - 1, height - 1, 0.5f));
        set(blocks, x, y, 1);
        CHECK(pyramid.all_nearer(0, 0, width - 1, height - 1, 0.5f));
    }
}
