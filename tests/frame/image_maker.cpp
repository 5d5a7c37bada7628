// Where images of cells fail, if they do: surfaces that are split, views that change, renewals.
#include "farfield/frame/image_maker.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <type_traits>
#include <vector>

#include "catch.hpp"
#include "farfield/partition/gap_bsp.hpp"
#include "support/image_walk.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

/// Pixels of a walk along a surface where something is to be seen, and of these where nothing is, although exact
/// geometry is there and all around.
struct Lost {
    int pixels = 0, lost = 0;
    std::uint64_t images = 0;
};

template <class Partition>
Lost walk_along(const Triangles& surface, const Partition& partition, float threshold, bool is_wall) {
    const auto cached = build<SpatialHierarchy<Partition, ImageCache<Exact>, MeasuredTime>>(
        surface, {.partition = partition,
                  .approximation = with({.threshold_px = threshold, .least_items = 256}),
                  .cost_model = free_images()});
    const Plain plain = build<Plain>(surface);
    ZBufferRenderer renderer, plain_renderer;
    auto viewer = make_viewer(cached, surface, renderer);
    auto plain_viewer = make_viewer(plain, surface, plain_renderer);
    Lost lost;
    for (int f = 0; f < 30; ++f) {
        const View view = is_wall ? seen_from({0.1 * f, 0.03 * f, 0}, {0, 0, -33})
                                  : seen_from({0.1 * f, 4, -0.05 * f}, {0.1 * f, 0, -30});
        lost.images += viewer.frame(view).images;
        plain_viewer.frame(view);
        const CoveredPixels pixels = covered_pixels(plain_renderer.image(), renderer.image());
        lost.pixels += pixels.all;
        lost.lost += pixels.lost;
    }
    return lost;
}

Triangles terrain() {
    Triangles ground = sheet({-40, 0, -4}, {80, 0, 0}, {0, 0, -80}, 128, 128, {90, 140, 60, 255});
    for (Triangle& t : ground) {
        for (glm::vec3& v : t.vertices) v.y = 1.5f * std::sin(0.31f * v.x) * std::cos(0.23f * v.z);
    }
    return ground;
}

/// Outside of the picture, so that what is in the picture is a cell below the root.
void add_something_aside(Triangles& all) {
    const Triangles aside = sheet({200, 0, -20}, {1, 0, 0}, {0, 1, 0}, 32, 32, {1, 2, 3, 255});
    all.insert(all.end(), aside.begin(), aside.end());
}

}  // namespace

TEST_CASE("a surface split into images opens by what the threshold lets it, and hardly where cells overlap",
          "[image_maker]") {
    // Shared cells hold what reaches into them, so that their images overlap by a triangle; inflated ones by more.
    int apart_lost = 0, overlapping_lost = 0, inflated_lost = 0;
    for (const bool is_wall : {true, false}) {
        const Triangles surface = is_wall ? wall() : terrain();
        const GapBsp apart = is_wall ? GapBsp::along_axes() : GapBsp();
        SharedGapBsp overlapping;
        overlapping.directions = apart.directions;
        CHECK(walk_along(surface, apart, 0, is_wall).lost == 0);
        for (const float threshold : {0.5f, 2.0f}) {
            INFO((is_wall ? "wall, " : "terrain, ") << threshold << " pixels");
            const Lost lost = walk_along(surface, apart, threshold, is_wall);
            CHECK(lost.images > 20);
            CHECK(lost.lost <= lost.pixels / 100);
            apart_lost += lost.lost;
            overlapping.inflation = 0;
            const Lost less = walk_along(surface, overlapping, threshold, is_wall);
            CHECK(less.images >= lost.images);
            CHECK(less.lost <= less.pixels / 2000);
            overlapping_lost += less.lost;
            overlapping.inflation = 0.2f;
            inflated_lost += walk_along(surface, overlapping, threshold, is_wall).lost;
        }
    }
    INFO(apart_lost << " pixels apart, " << overlapping_lost << " overlapping, " << inflated_lost << " inflated");
    CHECK(apart_lost > 1000);
    CHECK(10 * overlapping_lost < apart_lost);
    CHECK(10 * inflated_lost < apart_lost);
}

TEST_CASE("field of view and size may change in the middle of a walk", "[image_maker]") {
    Walk<> changing, steady;
    double worst = 0, worst_steady = 0;
    std::uint64_t made = 0, made_steady = 0;
    for (int f = 0; f < 60; ++f) {
        View view = seen_from({0.02 * f, 0, 0});
        made_steady += steady.frame(view).images_made;
        worst_steady = std::max(worst_steady, difference(steady.image(), steady.exact(view)));
        const int part = f / 10;  // changes six times
        view.camera = Camera::perspective({0.02 * f, 0, 0}, {0, 0, -50}, {0, 1, 0}, part % 2 == 0 ? 0.7f : 0.5f);
        if (part % 3 == 2) view.width = 200, view.height = 160;
        made += changing.frame(view).images_made;
        const double off = difference(changing.image(), changing.exact(view));
        // What was made for another view is not good in this one, or no worse than the threshold.
        worst = std::max(worst, off);
    }
    INFO("made " << made << ", without changes " << made_steady << "; worst " << worst << ", " << worst_steady);
    CHECK(worst < 1.5 * worst_steady);
    CHECK(made <= 8 * made_steady);
}

TEST_CASE("a viewer that swings over the edge of safety zones makes few images in any frame", "[image_maker]") {
    Walk<> walk;
    walk.frame(seen_from({0, 0, 0}));
    const std::uint64_t cells = walk.frame(seen_from({0, 0, 0})).images;
    REQUIRE(cells > 4);
    std::uint64_t made = 0;
    int busy = 0;
    for (int f = 0; f < 200; ++f) {
        // Half a unit is about where images of the nearest cells end.
        const std::uint64_t in_frame = walk.frame(seen_from({0.45 + 0.1 * (f % 2), 0, 0})).images_made;
        made += in_frame;
        busy += in_frame > 0;
    }
    CHECK(made <= 2 * cells);
    CHECK(busy <= 10);
}

TEST_CASE("renewed images fade in, and the picture's largest jump becomes smaller", "[image_maker]") {
    Triangles cloud = random_triangles(3000, 7, 0.3f);
    for (Triangle& t : cloud) {
        for (glm::vec3& v : t.vertices) v = v * 1.5f - glm::vec3(0, 0, 12);
    }
    add_something_aside(cloud);
    constexpr std::array<std::uint32_t, 3> fades{0, 4, 12};
    std::array<double, 3> jump{}, worst{};
    const Plain plain = build<Plain>(cloud);
    ZBufferRenderer plain_renderer;
    auto plain_viewer = make_viewer(plain, cloud, plain_renderer);
    for (std::size_t i = 0; i < fades.size(); ++i) {
        const auto cached = build<SpatialHierarchy<GapBsp, ImageCache<Exact>, MeasuredTime>>(
            cloud, {.approximation = with({.least_items = 2000, .most_overhead = 4, .fade_frames = fades[i]}),
                    .cost_model = free_images()});
        ZBufferRenderer renderer;
        auto viewer = make_viewer(cached, cloud, renderer);
        Image last, last_exact;
        std::uint64_t made = 0;
        for (int f = 0; f < 300; ++f) {
            const double x = 0.01 * f - 1.5;
            const View view = seen_from({x, 0, 0}, {x, 0, -12});
            const FrameStats stats = viewer.frame(view);
            CHECK(stats.images == 1);
            made += stats.images_made;
            plain_viewer.frame(view);
            const Image& exact = plain_renderer.image();
            if (f > 0) {
                // Over what exact geometry changes by.
                const double step = difference(renderer.image(), last), own = difference(exact, last_exact);
                jump[i] = std::max(jump[i], std::sqrt(std::max(0.0, step * step - own * own)));
            }
            last = renderer.image();
            last_exact = exact;
            worst[i] = std::max(worst[i], difference(last, exact));
        }
        CHECK(made >= 3);
    }
    INFO("largest jump " << jump[0] << ", " << jump[1] << ", " << jump[2]);
    CHECK(jump[1] < 0.7 * jump[0]);
    CHECK(jump[2] < jump[1]);
    CHECK(worst[1] < 1.25 * worst[0]);
    CHECK(worst[2] < 1.25 * worst[0]);
}

TEST_CASE("fading ends, takes no memory over the budget, and leaves no image behind", "[image_maker]") {
    std::uint64_t working_set = 0;
    for (const int part : {0, 1, 2}) {
        const std::uint64_t budget = part == 0 ? std::uint64_t(64) << 20 : working_set / std::uint64_t(part);
        Walk<CountedImages> walk({.least_items = 64, .budget_bytes = budget, .most_overhead = 4, .fade_frames = 5},
                                 free_images());
        for (int f = 0; f < 80; ++f) {
            const FrameStats stats = walk.frame(seen_from({0.1 * f, 0, 0}));
            REQUIRE(stats.image_bytes <= budget);
            working_set = std::max(working_set, stats.image_bytes);
        }
        const View last = seen_from({8, 0, 0});
        for (int f = 0; f < 12; ++f) walk.frame(last);
        const Image settled = walk.image();
        const std::uint64_t bytes = walk.frame(last).image_bytes;
        for (int f = 0; f < 8; ++f) {
            const FrameStats stats = walk.frame(last);
            CHECK(stats.images_made == 0);
            CHECK(stats.image_bytes == bytes);
            CHECK(walk.image() == settled);
        }
        CHECK(walk.renderer.alive > 0);
        walk.viewer.forget_images();
        CHECK(walk.renderer.alive == 0);
        walk.frame(last);
        walk.frame(seen_from({8.2, 0, 0}));
        walk.viewer.forget_images();
        CHECK(walk.renderer.alive == 0);
    }
}

TEST_CASE("what fades is the same on every run, whatever the width of vectors", "[image_maker]") {
    std::vector<Image> expected;
    for (const Simd simd : {Simd::scalar, Simd::four_lanes, Simd::eight_lanes, Simd::automatic}) {
        const CachedImages hierarchy = build<CachedImages>(
            balls(), {.approximation = with({.least_items = 64, .most_overhead = 4, .fade_frames = 3}),
                      .cost_model = free_images()});
        ZBufferRenderer renderer{ZBufferOptions{.simd = simd}};
        auto viewer = make_viewer(hierarchy, balls(), renderer);
        for (int f = 0; f < 40; ++f) {
            viewer.frame(seen_from({0.2 * f, 0, 0}));
            if (simd == Simd::scalar) {
                expected.push_back(renderer.image());
            } else {
                REQUIRE(renderer.image() == expected[std::size_t(f)]);
            }
        }
    }
}
