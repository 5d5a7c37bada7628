// Blocks against one depth and one color a sample.
#include "farfield/raster/samples/sample_blocks.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include "catch.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

TEST_CASE("surfaces and samples are read as they were written, and bounds hold", "[raster]") {
    constexpr float nothing = -std::numeric_limits<float>::infinity();
    constexpr int side = SampleBlocks::side;
    Random random(790);
    SampleBlocks blocks;
    for (const auto& size : {std::pair{1, 1}, {8, 8}, {23, 17}, {40, 9}}) {
        const int width = size.first, height = size.second, first_x = -width / 2, first_y = -height / 2;
        const Rgba8 background{1, 2, 3, 255};
        blocks.resize(width, height, background);
        blocks.place(first_x, first_y);
        for (int frame = 0; frame < 5; ++frame) {
            blocks.clear();
            const auto count = std::size_t(width * height);
            std::vector<float> depth(count, nothing);
            std::vector<Rgba8> color(count, background);
            for (int i = 0; i < 60; ++i) {
                const int x = int(random.below(std::uint32_t(width))), y = int(random.below(std::uint32_t(height)));
                const int column = x / side, row = y / side;
                const std::size_t block = blocks.index(column, row);
                const Rgba8 c = random.color();
                blocks.add_drawn(x, y, x + 1, y + 1);
                if (random.below(4) == 0) {
                    const DepthPlane plane(random.unit() + float(i), random.between(-1, 1), random.between(-1, 1), 0,
                                           1000);
                    float farthest = std::numeric_limits<float>::infinity(), nearest = nothing;
                    for (int v = row * side; v < row * side + side; ++v) {
                        for (int u = column * side; u < column * side + side; ++u) {
                            const float q = plane.at(plane.row(v + first_y), u + first_x);
                            farthest = std::min(farthest, q);
                            nearest = std::max(nearest, q);
                            if (u >= width || v >= height) continue;
                            depth[std::size_t(v * width + u)] = q;
                            color[std::size_t(v * width + u)] = c;
                        }
                    }
                    blocks.set_surface(block, plane, c, farthest, nearest);
                } else {
                    float& d = depth[std::size_t(y * width + x)];
                    const float q = std::max(d, 0.0f) + random.unit();
                    SampleBlocks::Samples& samples = blocks.opened(block, column, row);
                    samples.depth[y % side * side + x % side] = d = q;
                    samples.color[y % side * side + x % side] = color[std::size_t(y * width + x)] = c;
                    blocks.filled(block, q);
                }
                const bool is_exact = random.below(2) == 0;
                const float bound = is_exact ? blocks.exact_farthest(block) : blocks.farthest(block);
                float least = std::numeric_limits<float>::infinity(), most = nothing;
                for (int v = row * side; v < std::min(row * side + side, height); ++v) {
                    for (int u = column * side; u < std::min(column * side + side, width); ++u) {
                        least = std::min(least, depth[std::size_t(v * width + u)]);
                        most = std::max(most, depth[std::size_t(v * width + u)]);
                    }
                }
                CHECK(bound <= least);
                // A surface goes on beyond the picture's border.
                if (is_exact && !blocks.block(block).is_surface) CHECK(bound == least);
                CHECK(blocks.block(block).nearest >= most);
            }
            int wrong = 0;
            std::vector<Rgba8> line(std::size_t(width), Rgba8{0, 0, 0, 0});
            for (int y = 0; y < height; ++y) {
                const int begin = int(random.below(std::uint32_t(width)));
                blocks.colors(y, begin, width, line.data());
                const float q_here = 60 * random.unit() * random.unit(), q_step = random.between(-0.2f, 0.2f);
                const auto q = [&](int x) { return q_here + q_step * float(x); };
                const std::uint64_t wanted = random.bits() & ((std::uint64_t(1) << width) - 1);
                const int in_block = y % side * side;
                std::uint64_t farther = 0, farther_than_first = 0;
                for (int x = 0; x < width; x += side) {
                    const std::uint64_t here = (wanted >> x & 255) << in_block;
                    farther |= blocks.farther_in_row(x, y, here, q) >> in_block << x;
                    farther_than_first |= blocks.farther(x, y - y % side, here, q_here) >> in_block << x;
                }
                for (int x = 0; x < width; ++x) {
                    const auto at = std::size_t(y * width + x);
                    const bool is_wanted = (wanted >> x & 1) != 0;
                    wrong += (farther >> x & 1) != (is_wanted && depth[at] < q(x) ? 1u : 0u);
                    wrong += (farther_than_first >> x & 1) != (is_wanted && depth[at] < q_here ? 1u : 0u);
                    const SampleBlocks::Sample sample = blocks.sample(x, y);
                    wrong += sample.depth != depth[at] || sample.color != color[at];
                    wrong += blocks.depth(x, y) != depth[at];
                    wrong += blocks.color(x, y) != color[at];
                    wrong += x >= begin && line[std::size_t(x - begin)] != color[at];
                }
            }
            CHECK(wrong == 0);
        }
    }
}
