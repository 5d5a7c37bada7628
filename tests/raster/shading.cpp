#include "farfield/raster/shading.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "catch.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

TEST_CASE("a triangle's hash is its own, whichever corner comes first", "[raster]") {
    Random random(790);
    std::size_t same = 0;
    for (int i = 0; i < 2000; ++i) {
        const glm::vec3 a = random.in_cube(1), b = random.in_cube(1), c = random.in_cube(1);
        const std::uint32_t hash = hash_of_triangle(a, b, c);
        CHECK(hash_of_triangle(b, c, a) == hash);
        CHECK(hash_of_triangle(c, a, b) == hash);
        same += hash_of_triangle(a, b, c + 1e-6f) == hash;
    }
    CHECK(same <= 1);
}

TEST_CASE("of a translucent triangle as many samples are covered as alpha says, in no pattern", "[raster]") {
    Random random(791);
    for (const int alpha : {0, 1, 32, 64, 128, 192, 255}) {
        std::size_t covered = 0, neighbors = 0;
        constexpr std::size_t side = 200;
        const auto hash = std::uint32_t(random.bits());
        for (int y = -100; y < 100; ++y) {
            for (int x = -100; x < 100; ++x) {
                const bool is = covered_by_hash(x, y, hash, std::uint8_t(alpha));
                covered += is;
                neighbors += is && covered_by_hash(x + 1, y, hash, std::uint8_t(alpha));
            }
        }
        const double part = alpha / 256.0, n = double(side) * side;
        CHECK(std::abs(double(covered) - n * part) <= 4 * std::sqrt(n * part * (1 - part)) + 1);
        CHECK(std::abs(double(neighbors) - n * part * part) <= 8 * std::sqrt(n * part * part) + 1);
    }
}

TEST_CASE("more alpha never uncovers a sample", "[raster]") {
    for (int x = 0; x < 100; ++x) {
        bool was = false;
        for (int alpha = 0; alpha < 256; ++alpha) {
            const bool is = covered_by_hash(x, 3 * x, 12345, std::uint8_t(alpha));
            CHECK(is >= was);
            was = is;
        }
    }
}

TEST_CASE("colors are those of the corners there, and their mean in the middle of an orthographic view", "[raster]") {
    // Corners on centers of samples.
    const SnappedTriangle t{{128, 128 + 256 * 60, 128}, {128, 128, 128 + 256 * 60}, {0.5f, 0.5f, 0.5f}};
    const Rgba8 colors[3] = {{255, 0, 0, 255}, {0, 255, 0, 255}, {0, 0, 255, 100}};
    for (const ColorWeight weight : {ColorWeight{0, 1}, ColorWeight{1, 0}}) {
        const ColorPlane plane(t, t.doubled_area(), weight);
        CHECK(plane.at(0, 0, colors) == colors[0]);
        CHECK(plane.at(60, 0, colors) == colors[1]);
        CHECK(plane.at(0, 60, colors) == colors[2]);
        CHECK(plane.at(20, 20, colors) == Rgba8{85, 85, 85, 203});
    }
}

TEST_CASE("between corners of different depths colors are perspectively right", "[raster]") {
    // Along the first edge from depth 1 to depth 3: halfway over the screen a quarter of the way in space.
    const SnappedTriangle t{{128, 128 + 256 * 60, 128}, {128, 128, 128 + 256 * 60}, {1, 1.0f / 3, 1}};
    const Rgba8 colors[3] = {{0, 0, 0, 255}, {200, 0, 0, 255}, {0, 0, 0, 255}};
    CHECK(ColorPlane(t, t.doubled_area(), {1, 0}).at(30, 0, colors).r == 50);
    CHECK(ColorPlane(t, t.doubled_area(), {0, 1}).at(30, 0, colors).r == 100);
}
