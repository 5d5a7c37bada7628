#include "farfield/approximation/sample_set.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/gtc/matrix_transform.hpp>
#include <string>
#include <type_traits>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/measure/coverage_error.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/instance.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "support/pictures.hpp"
#include "support/random.hpp"
#include "support/recorder.hpp"
#include "support/scenes.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

template <class Inner>
using SamplesOver = SpatialHierarchy<Octree, SampleSet<Inner>, TriangleCount>;
using Samples = SamplesOver<AreaSplat>;
using Tensors = SamplesOver<OpacityTensor>;
using PlainTensors = SpatialHierarchy<Octree, OpacityTensor, TriangleCount>;

template <class H>
Image picture(const H& h, const Triangles& triangles, const View& view, int samples) {
    ZBufferRenderer renderer({.samples = samples});
    make_viewer(h, triangles, renderer).frame(view);
    return renderer.image();
}
/// Strewn leaves, as many as make a cell of a few pixels sparse.
Triangles leaves() {
    return random_triangles(60000, 11, 0.006f);
}

}  // namespace

TEST_CASE("samples and rest together cover what all covers", "[approximation]") {
    const Triangles triangles = leaves();
    const PlainTensors plain = build<PlainTensors>(triangles);
    for (const float up_to : {0.0f, 1.0f}) {
        const Tensors h = build<Tensors>(triangles, {.approximation = {.samples_up_to_px = up_to}});
        for (const double distance : {8.0, 16.0, 32.0, 64.0}) {
            const View view = looking({distance, 0.4 * distance, 0.3 * distance}, {}, 192, 1);
            View exact = view;
            exact.tolerance_px = 0;
            const Image truth = picture(h, triangles, exact, 64);
            const CoverageError e = coverage_error(picture(h, triangles, view, 64), truth),
                                of_plain = coverage_error(picture(plain, triangles, view, 64), truth);
            INFO("from " << distance << ", samples up to " << up_to << " px: " << 100 * e.bias << " %, tensors alone "
                         << 100 * of_plain.bias << " %");
            CHECK(std::abs(e.bias) < std::abs(of_plain.bias) + 0.015);
        }
    }
}

TEST_CASE("the rest covers what a part of the areas leaves of what all cover, by their law", "[approximation]") {
    struct OneSplat {
        Splat& splat;
        float splat_limit_px = 4;

        void operator()(const Splat& s) const { splat = s; }
        void operator()(const Face&) const { FAIL("a face"); }
        void operator()(OwnRun) const { FAIL("a sample"); }
    };
    Triangles triangles = leaves();
    append(triangles, sheet({-1, -1, -1}, {0, 2, 0}, {0, 0, 2}, 40, 40, {255, 0, 0}));
    const PlainTensors h = build<PlainTensors>(triangles);
    const View view = looking({12, 5, 4}, {}, 192, 4);
    const LocalView local(view, h.origin(), h.bounds());
    ZBufferRenderer renderer;
    int of_law[3] = {0, 0, 0};
    make_viewer(h, triangles, renderer).select(view).for_each([&](const auto&, const Selected& s) {
        if (s.kind != Selected::Kind::stand_in) return;
        const StoredTensor& data = h.stand_ins()[s.subtree.stand_in];
        Splat all{};
        OpacityTensor{}.draw_stand_in(data, s.subtree.cell, local, OneSplat{all});
        const double a = double(all.opacity);
        if (!(a > 0.01 && a < 0.99)) return;
        const auto law = AreaLaw(all.rgb.a);
        ++of_law[int(law)];
        const double area = law == AreaLaw::coherent ? a
                            : law == AreaLaw::mixed  ? -2 * std::log(1 - 0.5 * a)
                                                     : -std::log(1 - a);
        for (const double drawn : {0.0, 0.3, 0.8}) {
            Splat rest{};
            const auto left = std::uint16_t((1 - drawn) * 65535 + 0.5);
            SampleSet<OpacityTensor>{}.draw_stand_in({data, left}, s.subtree.cell, local, OneSplat{rest});
            const double open = double(transmitted(1, float(drawn * area), law));
            CHECK(open * (1 - double(rest.opacity)) == Approx(1 - a).margin(1e-3));
            CHECK(rest.size == all.size);
        }
    });
    CHECK(of_law[int(AreaLaw::independent)] > 20);
}

TEST_CASE("sheets one behind the other show the one in front", "[approximation]") {
    // Off the octree's planes, a gap of a thousandth: both lie in one cell at any distance.
    Triangles sheets = sheet({0.3101f, -1, -1}, {0, 2, 0}, {0, 0, 2}, 100, 100, {255, 0, 0});
    append(sheets, sheet({0.3091f, -1, -1}, {0, 2, 0}, {0, 0, 2}, 100, 100, {0, 0, 255}));
    append(sheets, random_triangles(1, 1, 0.0001f));
    const auto hidden_part = [&](const Image& image, double side) {
        int shown = 0, wrong = 0;
        for (const Rgba8 c : image.pixels()) {
            if (c.a < 250) continue;
            ++shown;
            wrong += side > 0 ? c.b > c.r : c.r > c.b;
        }
        return double(wrong) / std::max(shown, 1);
    };
    for (const float up_to : {0.0f, 1.0f}) {
        const Samples h = build<Samples>(sheets, {.approximation = {.samples_up_to_px = up_to}});
        for (const double distance : {10.0, 20.0, 30.0, -10.0, -20.0, -30.0}) {
            for (const int samples : {1, 64}) {
                INFO("from " << distance << ", samples up to " << up_to << " px, " << samples << " a pixel");
                const View view = looking({distance, 0.1, 0.2}, {}, 256, 1);
                CHECK(hidden_part(picture(h, sheets, view, samples), distance) <= 0.05);
            }
        }
    }
}

TEST_CASE("a stop draws its cell's sample where it is asked to, and nothing else", "[approximation]") {
    const Triangles triangles = random_triangles(3000, 2, 0.01f);
    const View far = looking({4000, 0, 0}, {}, 64, 1);
    for (const bool own : {false, true}) {
        const Samples h = build<Samples>(triangles, {.approximation = {.samples_up_to_px = own ? 1.0f : 0.0f}});
        Recorder recorder;
        recorder.largest_splat = 0.25f;
        const FrameStats stats = make_viewer(h, triangles, recorder).frame(far);
        CHECK(stats.approximations == 1);
        CHECK(recorder.splats.size() == 1);
        Recorder coarse;
        coarse.largest_splat = 2;  // one sample a pixel
        make_viewer(h, triangles, coarse).frame(far);
        CHECK(coarse.draws.empty());
        CHECK(recorder.draws.size() == (own ? h.stand_ins()[0].sample_size() : 0));
        CHECK(h.stand_ins()[0].sample_size() >= 14);
    }
}

TEST_CASE("instances of sample trees stay in their cells and are drawn as their contents are", "[approximation]") {
    const Triangles leaf_heap = random_triangles(3000, 9, 0.03f);
    const auto place = [&](const auto& one) {
        using H = std::remove_cvref_t<decltype(one)>;
        std::vector<Instance<H, Triangle>> placed;
        Random random(4);
        for (int i = 0; i < 200; ++i) {
            const glm::mat4 turned = glm::rotate(glm::mat4(1), random.between(0, 6), glm::vec3(0, 1, 0));
            placed.push_back({&one, leaf_heap, Similarity(glm::translate(glm::mat4(1), random.in_cube(30)) * turned)});
        }
        return placed;
    };
    const Tensors one = build<Tensors>(leaf_heap);
    const PlainTensors one_plain = build<PlainTensors>(leaf_heap);
    const auto placed = place(one);
    const auto plainly_placed = place(one_plain);
    const Tensors all = build<Tensors>(placed);
    const PlainTensors plain = build<PlainTensors>(plainly_placed);
    std::vector<std::uint32_t> order(all.order().begin(), all.order().end());
    std::sort(order.begin(), order.end());
    for (std::uint32_t i = 0; i < 200; ++i) CHECK(order[i] == i);
    const auto drawn = [](const auto& h, const auto& instances, double distance, float tolerance) {
        ZBufferRenderer renderer({.samples = 64});
        make_viewer(h, instances, renderer).frame(looking({distance, 0.3 * distance, 0}, {}, 160, tolerance));
        return renderer.image();
    };
    for (const double distance : {80.0, 200.0, 600.0}) {
        const CoverageError e = coverage_error(drawn(all, placed, distance, 1), drawn(all, placed, distance, 0)),
                            of_plain = coverage_error(drawn(plain, plainly_placed, distance, 1),
                                                      drawn(plain, plainly_placed, distance, 0));
        INFO("from " << distance << ": " << 100 * e.bias << " %, tensors alone " << 100 * of_plain.bias << " %");
        CHECK(std::abs(e.bias) < std::abs(of_plain.bias) + 0.02);
    }
}

TEST_CASE("a frozen camera shows the same picture, and a tolerance of 0 every primitive", "[approximation]") {
    const Triangles triangles = mixed_triangles(4000, 6);
    const Samples h = build<Samples>(triangles);
    const View view = looking({5, 2, 3}, {}, 128, 4);
    ZBufferRenderer renderer;
    auto viewer = make_viewer(h, triangles, renderer);
    viewer.frame(view);
    const Image first = renderer.image();
    viewer.frame(view);
    CHECK(renderer.image() == first);
    View exact = view;
    exact.tolerance_px = 0;
    CHECK(picture(h, triangles, exact, 1) == plain_picture(std::span<const Triangle>(triangles), exact));
}

TEST_CASE("cells are finer where their samples are drawn, and nowhere else", "[approximation]") {
    const Triangles triangles = leaves();
    const Tensors h = build<Tensors>(triangles);
    const View view = looking({30, 4, 3}, {}, 96, 1);
    LocalView local(view, h.origin(), h.bounds());
    const auto error = [&](float splat_limit_px) {
        local.splat_limit_px = splat_limit_px;
        return h.approximation_policy().error_px(h.stand_ins()[0], h.root_cell(), local);
    };
    CHECK(error(0.25f) == 1.5f * error(2));
    CHECK(error(0) == error(0.25f));
    local.tolerance_px = 3;
    CHECK(error(0.25f) == error(2));
    const auto stops = [&](int samples) {
        ZBufferRenderer renderer({.samples = samples});
        const FrameStats stats = make_viewer(h, triangles, renderer).frame(view);
        double depth = 0;
        for (int i = 0; i < FrameStats::max_levels; ++i) depth += i * double(stats.approximations_by_level[i]);
        return depth / double(std::max<std::uint64_t>(stats.approximations, 1));
    };
    CHECK(stops(1) < stops(64));
}

TEST_CASE("sample sets whose options make no sense are refused by name", "[approximation]") {
    CHECK(std::string(SampleSet<>{.c = 0}.wrong_option()) == "SampleSet: c must lie above 0 and at most at 1000");
    CHECK(SampleSet<>{.c = NAN}.wrong_option() != nullptr);
    CHECK(std::string(SampleSet<>{.inner = {.samples = 9}}.wrong_option()).find("AreaSplat") == 0);
    CHECK(SampleSet<>{}.wrong_option() == nullptr);
}

namespace {
/// The same, one at a time.
struct OneByOne : SampleSet<OpacityTensor> {
    template <class Sink>
    void draw_stand_in(const stand_in_data& data, const Cell& cell, const LocalView& view, Sink&& sink) const {
        SampleSet<OpacityTensor>::draw_stand_in(data, cell, view, sink);
    }
};
}  // namespace

TEST_CASE("many stand-ins at once are drawn as one by one", "[approximation]") {
    static_assert(detail::DrawsPlaced<SampleSet<OpacityTensor>>);
    static_assert(!detail::DrawsPlaced<SampleSet<AreaSplat>>);
    static_assert(!detail::DrawsPlaced<OneByOne>);
    const Triangles triangles = leaves();
    const Tensors h = build<Tensors>(triangles);
    const auto one_by_one = build<SpatialHierarchy<Octree, OneByOne, TriangleCount>>(triangles);
    for (const int samples : {1, 9}) {
        for (const float tolerance : {1.0f, 3.0f}) {
            const View view = looking({9, 4, 6}, {}, 128, tolerance);
            CHECK(picture(h, triangles, view, samples) == picture(one_by_one, triangles, view, samples));
        }
    }
}
