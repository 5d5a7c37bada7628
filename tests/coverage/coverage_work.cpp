// Counts of visits, and where they were.
#include "farfield/coverage/coverage_work.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include "catch.hpp"
#include "support/masks.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {
struct StrictWork : StrictCoverage {
    using samples = RecordedSamples<8>;
    using work = CoverageWorkImage;
};
struct LazyWork : LazyCoverage {
    using samples = RecordedSamples<8>;
    using work = CoverageWorkImage;
};

double sum(const std::vector<float>& v) {
    return std::accumulate(v.begin(), v.end(), 0.0);
}

template <class Traits>
void check_sums(std::uint64_t seed) {
    Random random(seed);
    TiledFrames<Traits> frames(Simd::automatic);
    for (int round = 0; round < 30; ++round) {
        const int width = 1 + int(random.below(80)), height = 1 + int(random.below(80));
        const SampleFrame frame{width, height, 8};
        frames.begin(frame);
        std::uint64_t drawn = 0;
        for (std::uint32_t i = 0; i < 20; ++i) {
            drawn += frames.tile(random_polygon(random, frame, i)) ? 1u : 0u;
            frames.is_seen(random_polygon(random, frame, i), 0.5f, 8);
        }
        const CoverageWorkImage& work = frames.target().work;
        REQUIRE(work.columns() == width);
        REQUIRE(work.rows() == height);
        REQUIRE(work.tiled().size() == std::size_t(width * height));
        CHECK(sum(work.tiled()) == Approx(double(work.cells_tiled)).epsilon(1e-4));
        CHECK(sum(work.asked()) == Approx(double(work.cells_asked)).epsilon(1e-4));
        CHECK(work.polygons_tiled >= drawn);
        CHECK(work.polygons_tiled <= 20);
        CHECK(work.cells_tiled >= work.polygons_tiled);
        frames.end();
    }
}
}  // namespace

TEST_CASE("visits of large cells are shared by the pixels that they cover inside the image", "[coverage]") {
    CoveragePyramid pyramid;
    CoverageWorkImage work;
    pyramid.begin(8 * 20, 8 * 9);  // in masks: 20 x 9
    work.begin(pyramid);
    work.tiles(0, 3, 2);
    work.tiles(1, 2, 1);  // masks (16, 8) to (19, 8)
    work.asks(2, 0, 0);
    work.tiles_masks(1, 0, 0x8001, 2);  // masks (8, 0) and (15, 1)
    CHECK(work.cells_tiled == 4);
    CHECK(work.cells_asked == 1);
    const auto tiled = [&](int x, int y) { return work.tiled()[std::size_t(y * 20 + x)]; };
    CHECK(tiled(3, 2) == 1);
    CHECK(tiled(16, 8) == 0.25f);
    CHECK(tiled(19, 8) == 0.25f);
    CHECK(tiled(8, 0) == 1);
    CHECK(tiled(15, 1) == 1);
    CHECK(sum(work.tiled()) == 4);
    CHECK(std::count(work.asked().begin(), work.asked().end(), 1.0f / 180) == 180);
    work.begin(pyramid);
    CHECK(work.cells_tiled + work.cells_asked + work.polygons_tiled + work.masks_z_buffered == 0);
    CHECK(sum(work.tiled()) + sum(work.asked()) == 0);
}

TEST_CASE("the sums of work images are the counts", "[coverage]") {
    check_sums<StrictWork>(840);
    check_sums<LazyWork>(841);
}

TEST_CASE("cells visited for a large polygon go by its outline, not by its area", "[coverage]") {
    const SampleFrame frame{256, 256, 8};
    TiledFrames<StrictWork> frames(Simd::automatic);
    double before = 0;
    for (const std::int32_t half : {60, 120, 240, 480, 960}) {  // samples
        frames.begin(frame);
        const std::int32_t r = 256 * half, s = r / 3;
        frames.tile(tile_polygon({{-r, s}, {-s, -r}, {r, -s}, {s, r}}, {1, 1, 1}, numbered(1)));
        const auto visited = double(frames.target().work.cells_tiled);
        CAPTURE(half, visited);
        // An outline of 4 x 1.5 half sides, in masks of 8 samples; half as many again where it is oblique.
        const double outline = 4 * 1.5 * half / 8;
        CHECK(visited > outline);
        CHECK(visited < 2 * outline + 70);
        if (before > 0) CHECK(visited < 2.2 * before);
        before = visited;
    }
}

TEST_CASE("what is hidden by its bounding box visits nothing", "[coverage]") {
    const SampleFrame frame{64, 64, 8};
    const std::int32_t far = 1 << 20;
    const TilePolygon wall = tile_polygon({{-far, -far}, {far, -far}, {far, far}, {-far, far}}, {1, 1, 1}, numbered(0));
    TilePolygon small = tile_polygon({{100, 100}, {9000, 200}, {300, 9000}}, {0.5f, 0.5f, 0.5f}, numbered(1));
    TiledFrames<StrictWork> strict(Simd::automatic);
    TiledFrames<LazyWork> lazy(Simd::automatic);
    strict.begin(frame);
    lazy.begin(frame);
    strict.tile(wall);
    lazy.tile(wall);
    const std::uint64_t one = strict.target().work.cells_tiled;
    CHECK(lazy.target().work.cells_tiled == one);
    CHECK(one < 70);
    for (int i = 0; i < 5; ++i) {
        CHECK_FALSE(strict.tile(small));
        CHECK_FALSE(lazy.tile(small));
    }
    CHECK(strict.target().work.cells_tiled == one);
    CHECK(strict.target().work.polygons_tiled == 1);
    CHECK(lazy.target().work.cells_tiled == one);
    CHECK(lazy.target().work.polygons_tiled == 1);
    CHECK(lazy.target().work.masks_z_buffered == 0);
}
