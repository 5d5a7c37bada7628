// Cells have tolerances of their own, so that levels do not change all at once.
#include "farfield/frame/cell_tolerance.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/approximation/sample_set.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/frame/frame_budget.hpp"
#include "farfield/measure/flicker.hpp"
#include "farfield/measure/image_error.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "support/scenes.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {
View jittered(double distance, float jitter) {
    View view = looking({distance, 0.2 * distance, 0.1 * distance}, {}, 96, 2);
    view.tolerance_jitter = jitter;
    return view;
}
using Cubes = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
}  // namespace

TEST_CASE("a cell's tolerance is the view's, or smaller by a part of the jitter, always the same") {
    const LocalView plain(jittered(3, 0), glm::dvec3(0), 1.0f), some(jittered(3, 0.5f), glm::dvec3(0), 1.0f);
    float least = 2, most = 0, sum = 0;
    for (std::uint32_t node = 0; node < 1000; ++node) {
        CHECK(detail::cell_tolerance(plain, node % 7, node) == 2);
        const float t = detail::cell_tolerance(some, node % 7, node);
        CHECK(t == detail::cell_tolerance(some, node % 7, node));
        least = std::min(least, t);
        most = std::max(most, t);
        sum += t / 1000;
    }
    CHECK(least >= 1);
    CHECK(least < 1.02f);
    CHECK(most <= 2);
    CHECK(most > 1.98f);
    CHECK(sum == Approx(1.5f).epsilon(0.03));
}

TEST_CASE("jitter outside of 0 to 1 is refused") {
    for (const float jitter : {-0.1f, 1.1f, std::nanf("")}) {
        CHECK_THROWS_WITH(jittered(3, jitter).validate(), "farfield::View: tolerance_jitter must be 0 to 1");
    }
}

TEST_CASE("with jitter levels change cell by cell") {
    const Triangles triangles = random_triangles(6000, 179, 0.05f);
    const Cubes h = build<Cubes>(triangles);
    ZBufferRenderer renderer({.samples = 4}), exact_renderer({.samples = 4});
    auto viewer = make_viewer(h, triangles, renderer), exact = make_viewer(h, triangles, exact_renderer);
    const auto largest_pop = [&](float jitter) {
        Flicker flicker;
        std::uint64_t most_changed = 0, last = 0;
        for (int i = 0; i < 120; ++i) {
            const double distance = 10 * std::pow(16, i / 120.0);
            View view = jittered(distance, jitter);
            const FrameStats stats = viewer.frame(view);
            const std::uint64_t now = stats.approximations;
            if (i > 0) most_changed = std::max(most_changed, now > last ? now - last : last - now);
            last = now;
            view.tolerance_px = 0;
            exact.frame(view);
            flicker.add(renderer.image(), exact_renderer.image());
        }
        return std::pair(flicker.largest_pop_rms(), most_changed);
    };
    const auto [hard, hard_changed] = largest_pop(0);
    const auto [soft, soft_changed] = largest_pop(0.75f);
    CHECK(soft < 0.7 * hard);
    CHECK(soft_changed < hard_changed / 2);
}

TEST_CASE("budgets know a cell's own tolerance") {
    const Triangles triangles = random_triangles(3000, 180, 0.05f);
    const Cubes h = build<Cubes>(triangles);
    ZBufferRenderer renderer;
    auto viewer = make_viewer(h, triangles, renderer);
    Refinement refinement;
    const View view = jittered(20, 0.8f);
    viewer.frame(view, FrameBudget{.most = 1e12}, refinement);
    const Image within = renderer.image();
    CHECK(refinement.is_complete());
    viewer.frame(view);
    CHECK(renderer.image() == within);
}

TEST_CASE("a fade changes pictures little from one frame to the next") {
    const Triangles triangles = random_triangles(20000, 181, 0.02f);
    const Cubes h = build<Cubes>(triangles);
    ZBufferRenderer renderer({.samples = 16});
    auto viewer = make_viewer(h, triangles, renderer);
    Selection<Cubes, Triangle> selection;
    // What changes beside the camera: the same frame, by the cut of the last one.
    const auto largest_pop = [&](float fade) {
        double largest = 0;
        for (int i = 0; i < 150; ++i) {
            View view = jittered(40 * std::pow(6, i / 150.0), 0);
            view.fade = fade;
            viewer.frame(view);
            const Image at_once = renderer.image();
            viewer.select(view, selection);
            viewer.draw(selection);
            CHECK(renderer.image() == at_once);
            view.tolerance_px /= float(std::pow(6, 1 / 150.0));
            viewer.frame(view);
            largest = std::max(largest, mse(renderer.image(), at_once));
        }
        return std::sqrt(largest);
    };
    CHECK(largest_pop(0.5f) < 0.6 * largest_pop(0));
}

TEST_CASE("primitives come one by one as what stood for them fades") {
    const Triangles triangles = random_triangles(20000, 182, 0.02f);
    using Samples = SpatialHierarchy<Octree, SampleSet<OpacityTensor>, TriangleCount>;
    const Samples h = build<Samples>(triangles);
    ZBufferRenderer renderer({.samples = 16});
    auto viewer = make_viewer(h, triangles, renderer);
    const auto largest_step = [&](float fade) {
        double largest = 0;
        std::uint64_t largest_share = 0;
        for (int i = 0; i < 150; ++i) {
            View view = jittered(10 * std::pow(16, i / 150.0), 0);
            view.fade = fade;
            const std::uint64_t drawn = viewer.frame(view).primitives;
            const Image at_once = renderer.image();
            view.tolerance_px /= float(std::pow(16, 1 / 150.0));
            const std::uint64_t before = viewer.frame(view).primitives;
            CHECK(before >= drawn);
            largest_share = std::max(largest_share, before - drawn);
            largest = std::max(largest, mse(renderer.image(), at_once));
        }
        return std::pair(std::sqrt(largest), largest_share);
    };
    const auto [hard, hard_share] = largest_step(0);
    const auto [soft, soft_share] = largest_step(0.75f);
    INFO(soft << " of " << hard << ", " << soft_share << " of " << hard_share);
    CHECK(soft < 0.5 * hard);
    CHECK(soft_share < hard_share / 4);
}

TEST_CASE("parts of an opacity cover together what all of it does") {
    for (const float opacity : {0.1f, 0.5f, 0.9f}) {
        for (const float part : {0.2f, 0.5f, 0.7f}) {
            using detail::part_of_opacity;
            CHECK(part_of_opacity(opacity, part, AreaLaw::coherent) +
                      part_of_opacity(opacity, 1 - part, AreaLaw::coherent) ==
                  Approx(opacity));
            const float left = (1 - part_of_opacity(opacity, part, AreaLaw::independent)) *
                               (1 - part_of_opacity(opacity, 1 - part, AreaLaw::independent));
            CHECK(left == Approx(1 - opacity));
        }
    }
    View view = jittered(3, 0);
    view.fade = 1.5f;
    CHECK_THROWS_WITH(view.validate(), "farfield::View: fade must be 0 to 1");
}
