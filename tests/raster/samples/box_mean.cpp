// The box filter against sums in double.
#include "farfield/raster/samples/box_mean.hpp"

#include <cmath>
#include <vector>

#include "catch.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

TEST_CASE("sample mean: rounded to nearest, channel by channel", "[raster]") {
    Random random(450);
    for (int side = 1; side <= 8; ++side) {
        const std::size_t stride = std::size_t(side) + random.below(5);
        std::vector<Rgba8> samples(stride * std::size_t(side));
        for (int round = 0; round < 300; ++round) {
            double sum[4] = {};
            for (Rgba8& c : samples) {
                c = random.color();
                c.a = std::uint8_t(random.below(256));
                if (round == 0) c = {255, 255, 255, 255};
                if (round == 1) c = {0, 255, 0, 255};
            }
            for (int y = 0; y < side; ++y) {
                for (int x = 0; x < side; ++x) {
                    const Rgba8 c = samples[std::size_t(y) * stride + std::size_t(x)];
                    sum[0] += c.r, sum[1] += c.g, sum[2] += c.b, sum[3] += c.a;
                }
            }
            const Rgba8 mean = mean_of_samples(samples.data(), stride, side);
            const int got[4] = {mean.r, mean.g, mean.b, mean.a};
            for (int k = 0; k < 4; ++k) CHECK(std::abs(got[k] - sum[k] / (side * side)) <= 0.501);
        }
    }
}
