// From masks to pixels: pictures are what the filters make of the samples that brute force finds, in strict order or
// with some taken back and said anew.
#include "farfield/coverage/pixels/mask_samples.hpp"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "catch.hpp"
#include "farfield/coverage/pixels/cosine_hump_filter.hpp"
#include "support/masks.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {
template <class Filter>
struct LazyFiltered : LazyCoverage {
    using samples = PixelSamples<Filter>;
};
struct StrictHumps : StrictCoverage {
    using samples = PixelSamples<CosineHumpFilter>;
};
struct LazyPoints : LazyCoverage {
    using samples = SinglePixels;
};
constexpr Rgba8 background{20, 40, 60, 80};

/// What a filter makes of samples that come one by one.
template <class Filter>
Image filtered(const SampleFrame& frame, const std::vector<Rgba8>& samples) {
    Filter filter;
    filter.begin(frame.width_px, frame.height_px);
    for (int y = 0; y < frame.height_px; ++y) {
        for (int x = 0; x < frame.width_px; ++x) {
            for (int k = 0; k < 64; ++k) {
                filter.add(x, y, std::uint64_t(1) << k, samples[frame.at(8 * x + k % 8, 8 * y + k / 8)], k == 0);
            }
        }
    }
    Image image;
    filter.resolve(image);
    return image;
}

template <class Traits>
const Image& drawn(TiledFrames<Traits>& frames, const SampleFrame& frame, const std::vector<TilePolygon>& polygons) {
    frames.begin(frame);
    for (const TilePolygon& p : polygons) frames.tile(p);
    return frames.end(background);
}

/// Polygons all over the image among smaller ones, so that blocks are filled and then drawn into.
std::vector<TilePolygon> layers(Random& random, const SampleFrame& frame, std::uint32_t count) {
    std::vector<TilePolygon> polygons = random_polygons(random, frame, count);
    for (std::uint32_t i = 0; i < 3; ++i) {
        const std::int32_t x = 140 * frame.width(), y = 140 * frame.height(), slope = 100 * std::int32_t(i);
        const float q = random.between(0.1f, 0.6f);
        polygons.insert(polygons.begin() + random.below(std::uint32_t(polygons.size()) + 1),
                        tile_polygon({{-x, -y}, {x, -y + slope}, {x / 2, y}, {-x, y}}, {q, q, q}, numbered(500 + i)));
    }
    return polygons;
}
constexpr int sizes[][2] = {{1, 1}, {7, 3}, {8, 8}, {40, 33}, {8, 8}, {65, 9}, {24, 24}};
}  // namespace

TEST_CASE("pixels of 64 samples are their mean, in any order of polygons", "[coverage]") {
    Random random(830);
    std::vector<TiledFrames<LazyFiltered<BoxFilter>>> frames;
    for (const Simd simd : all_simd) frames.emplace_back(simd);
    for (int round = 0; round < 5; ++round) {
        for (const auto& [width, height] : sizes) {
            const SampleFrame frame{width, height, 8};
            const std::vector<TilePolygon> polygons = layers(random, frame, 1 + random.below(30));
            BruteForce brute(frame, background);
            for (const TilePolygon& p : polygons) brute.draw_lazy(p);
            const Image expected = filtered<BoxFilter>(frame, brute.colors());
            for (auto& f : frames) REQUIRE(drawn(f, frame, polygons) == expected);
        }
    }
}

TEST_CASE("single pixels are their samples, in any order of polygons", "[coverage]") {
    Random random(831);
    std::vector<TiledFrames<LazyPoints>> frames;
    for (const Simd simd : all_simd) frames.emplace_back(simd);
    for (int round = 0; round < 20; ++round) {
        for (const auto& [width, height] : sizes) {
            const SampleFrame frame{width * (1 + round % 4), height * (1 + round % 3), 1};
            const std::vector<TilePolygon> polygons = layers(random, frame, 1 + random.below(30));
            BruteForce brute(frame, background);
            for (const TilePolygon& p : polygons) brute.draw_lazy(p);
            for (auto& f : frames) REQUIRE(different_samples(drawn(f, frame, polygons), brute.colors()) == 0);
        }
    }
}

TEST_CASE("under a cosine hump too, lazy pictures are strict ones", "[coverage]") {
    Random random(832);
    std::vector<TiledFrames<LazyFiltered<CosineHumpFilter>>> frames;
    for (const Simd simd : all_simd) frames.emplace_back(simd);
    TiledFrames<StrictHumps> strict(Simd::automatic);
    for (int round = 0; round < 5; ++round) {
        for (const auto& [width, height] : sizes) {
            const SampleFrame frame{width, height, 8};
            std::vector<TilePolygon> polygons = layers(random, frame, 1 + random.below(30));
            BruteForce brute(frame, background);
            for (const TilePolygon& p : polygons) brute.draw_lazy(p);
            const Image expected = filtered<CosineHumpFilter>(frame, brute.colors());
            for (auto& f : frames) REQUIRE(drawn(f, frame, polygons) == expected);
            // In layers one behind the other strict order gives the same.
            for (std::size_t i = 0; i < polygons.size(); ++i) {
                DepthPlane& d = polygons[i].surface.depth;
                d.by_x = d.by_y = 0;
                d.at_corner = d.lowest = d.highest = 1 - 0.01f * float(i);
            }
            const Image in_order = drawn(strict, frame, polygons);
            random.shuffle(polygons);
            for (auto& f : frames) REQUIRE(drawn(f, frame, polygons) == in_order);
        }
    }
}
