// Prices of frames are fitted to what frames took.
#include "farfield/tuning/measure_frame_prices.hpp"

#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "support/scenes.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {
/// Work of any mix.
std::vector<MeasuredFrame> frames_of(const FramePrices& prices, int count) {
    Random random(7);
    std::vector<MeasuredFrame> frames;
    for (int i = 0; i < count; ++i) {
        MeasuredFrame f;
        for (double& w : f.work.of) w = double(random.between(0, 1000));
        f.work = f.work.with_shown();
        f.work[FrameWork::frames] = 1;
        f.time = prices.cost(f.work);
        frames.push_back(f);
    }
    return frames;
}
}  // namespace

TEST_CASE("prices are found again from work and times") {
    const FramePrices truth{{{5000, 2, 30, 200, 90, 1, 0, 7, 30, 0.5, 900, 3, 4}}};
    const FramePrices found = fitted_frame_prices(frames_of(truth, 200));
    for (std::size_t k = 0; k < FrameWork::kinds; ++k) {
        CHECK(found.each.of[k] == Approx(truth.each.of[k]).epsilon(0.02).margin(0.1));
    }
}

TEST_CASE("prices are raised until hardly a frame takes more than was said") {
    const FramePrices truth{};
    auto frames = frames_of(truth, 100);
    frames[3].time *= 1.3;
    frames[4].time *= 1.5;
    for (std::size_t i = 10; i < 60; ++i) frames[i].time *= 1.1;
    const FramePrices found = fitted_frame_prices(frames, {.part_within = 0.9, .most_over = 1.2});
    int above = 0;
    for (const MeasuredFrame& f : frames) {
        CHECK(f.time <= 1.2001 * found.cost(f.work));
        above += f.time > found.cost(f.work);
    }
    CHECK(above <= 11);
}

TEST_CASE("where there is nothing to fit, prices are the defaults") {
    CHECK(fitted_frame_prices({}).each.of == FramePrices{}.each.of);
    CHECK(FramePrices{}.wrong_option() == nullptr);
    const std::vector<MeasuredFrame> untimed(3);
    CHECK(fitted_frame_prices(untimed).each.of == FramePrices{}.each.of);
}

TEST_CASE("frames are measured coarse and fine") {
    const Triangles triangles = mixed_triangles(2000, 178);
    using H = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
    const H h = build<H>(triangles);
    ZBufferRenderer renderer;
    auto viewer = make_viewer(h, triangles, renderer);
    const std::vector<View> views{looking({3, 1.2, 2.2}, {}, 64, 0)};
    static double now = 0;
    const FramePriceOptions options{.longest = 1e5, .clock = [] { return now += 1e4; }};
    const auto frames = measure_frames(viewer, views, options);
    REQUIRE(frames.size() >= 2);
    for (const MeasuredFrame& f : frames) CHECK(f.time == 1e4);
    const FrameWork& coarse = frames.front().work;
    const FrameWork& fine = frames.back().work;
    CHECK(coarse[FrameWork::pixels] == 64 * 64);
    CHECK(coarse[FrameWork::openings] < fine[FrameWork::openings]);
    CHECK(measure_frame_prices(viewer, views, options).wrong_option() == nullptr);
}
