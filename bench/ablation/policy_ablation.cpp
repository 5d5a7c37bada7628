// What each part of the model buys: bytes, time and error with and without it, in turns in one run. "Model no more than
// a scene needs": a default is on because its row here says so.
//
// Each variant differs from the first, which has the defaults, in one thing. Policies that are defaults with a part
// missing are written here, not in the library.
#include <benchmark/benchmark.h>

#include <array>
#include <functional>
#include <memory>
#include <utility>

#include "farfield/build.hpp"
#include "farfield/measure/coverage_error.hpp"
#include "farfield/measure/image_error.hpp"
#include "farfield/measure/projected_rect.hpp"
#include "farfield/tuning/variants.hpp"
#include "support/subject.hpp"

namespace farfield::bench {
namespace {

/// The cost test of 1996 left out: cells are split down to ten primitives, whatever a stand-in costs, and all are kept.
struct NoCostTest : ColorCube {
    Work expected_work() const { return {}; }
    Work work(const stand_in_data&) const { return {}; }
};
struct TenPrimitives : Octree {
    Split choose(const Cell& cell, std::span<const Item> items, node_data& data) const {
        return items.size() <= 10 ? Split::no : Octree::choose(cell, items, data);
    }
};

/// Stand-ins that cost more than what they stand for are kept. They are only drawn where they are chosen.
struct KeepsAll : ColorCube {
    Work work(const stand_in_data&) const { return {}; }
};

/// All six faces are drawn, those behind too. In their order the three in front come last, so that front to back the
/// others would be seen through them.
struct AllFaces : ColorCube {
    template <class Sink>
    void draw_stand_in(const stand_in_data& data, const Cell& cell, const LocalView& view, Sink&& sink) const {
        ColorCube::draw_stand_in(data, cell, view, sink);
        // The view from the other side of the cell: what it sees are the backs.
        LocalView opposite = view;
        opposite.eye = 2.0f * cell.center - view.eye;
        opposite.forward = -view.forward;
        ColorCube::draw_stand_in(data, cell, opposite, sink);
    }
};

Octree uniform(std::size_t primitives) {
    Octree octree{.uniform_depth = 1};
    for (std::size_t cells = 4; cells * 10 < primitives; cells *= 4) ++octree.uniform_depth;
    return octree;
}

auto ablations(std::size_t primitives) {
    const Named costs{"", TriangleCount{}};
    const auto with = [&](const char* name, auto approximation, auto partition) {
        return std::get<0>(
            variants_of(std::tuple{Named{"", partition}}, std::tuple{Named{name, approximation}}, std::tuple{costs}));
    };
    return std::tuple{
        with("defaults", ColorCube{}, Octree{}),
        with("uniform_depth", ColorCube{}, uniform(primitives)),
        with("no_cost_test", NoCostTest{}, TenPrimitives{}),
        with("keeps_stand_ins_that_do_not_pay", KeepsAll{}, Octree{}),
        with("back_faces_too", AllFaces{}, Octree{}),
        with("one_sample_a_side", ColorCube{.samples = 1}, Octree{}),
        with("two_samples_a_side", ColorCube{.samples = 2}, Octree{}),
        with("eight_samples_a_side", ColorCube{.samples = 8}, Octree{}),
        with("analytic", ColorCube{.samples = 0}, Octree{}),
        with("inner_cells_drawn", ColorCube{.inner = ColorCube::Inner::direct}, Octree{}),
        with("thresholded", ColorCube{.opacity = ColorCube::Opacity::thresholded}, Octree{}),
        with("tells_every_story", ColorCube{.redundancy_tolerance = -1}, Octree{}),
        with("same_story_10_percent", ColorCube{.redundancy_tolerance = 0.1f}, Octree{}),
        with("in_every_cell_touched", ColorCube{}, SharedOctree{}),
    };
}
constexpr std::size_t ablation_count = std::tuple_size_v<decltype(ablations(0))>;

/// One ablation as the loop below sees it.
struct Subject {
    std::string name;
    double build_seconds = 0;
    std::size_t bytes = 0, stand_ins = 0;
    std::function<FrameStats(const View&)> frame;
    std::function<const Image&()> image;
};

template <class V>
Subject subject_of(const V& variant, std::span<const Primitive> triangles) {
    using H = typename V::hierarchy_type;
    struct Drawn {
        H hierarchy;
        ZBufferRenderer renderer;
        Viewer<H, Primitive, ZBufferRenderer> viewer;
        Drawn(H h, std::span<const Primitive> t) : hierarchy(std::move(h)), viewer(hierarchy, t, renderer) {}
    };
    Subject s;
    s.name = variant.name;
    H hierarchy;
    s.build_seconds = seconds([&] { hierarchy = variant.build(triangles); });
    s.bytes = hierarchy.bytes();
    s.stand_ins = hierarchy.stand_ins().size();
    const auto drawn = std::make_shared<Drawn>(std::move(hierarchy), triangles);
    s.frame = [drawn](const View& view) { return drawn->viewer.frame(view); };
    s.image = [drawn]() -> const Image& { return drawn->renderer.image(); };
    return s;
}

struct Scene {
    std::vector<Primitive> triangles;
    Built<ExactHierarchy> exact;
    std::vector<Subject> subjects;

    explicit Scene(const std::string& name) : triangles(triangles_of(name)), exact(triangles) {
        for_each_variant(ablations(triangles.size()),
                         [&](const auto& v) { subjects.push_back(subject_of(v, triangles)); });
    }
};

/// One at a time: all its variants take gigabytes.
const Scene& scene_of(const std::string& name) {
    static std::string current;
    static std::unique_ptr<Scene> scene;
    if (current != name) {
        scene.reset();
        scene = std::make_unique<Scene>(name);
        current = name;
    }
    return *scene;
}

/// From 7 and 28 radii, off every axis, averaged: where cubes are drawn, and where they are few.
constexpr std::array<double, 2> distances{7, 28};

void ablation(benchmark::State& state, const std::string& name, std::size_t which) {
    const Scene& scene = scene_of(name);
    const Subject &subject = scene.subjects[which], &defaults = scene.subjects[0];
    std::vector<double> ratios, frame_seconds;
    std::vector<View> views;
    for (const double distance : distances)
        views.push_back(table_view(scene.exact.hierarchy.bounds(), distance, 30, 256));
    for (const View& view : views) subject.frame(view), defaults.frame(view);
    for (auto _ : state) {
        double with = 0, without = 0;
        for (const View& view : views) {
            with += seconds([&] { defaults.frame(view); });
            without += seconds([&] { subject.frame(view); });
        }
        frame_seconds.push_back(without);
        ratios.push_back(without / with);
        state.SetIterationTime(without);
    }
    ZBufferRenderer finest({.samples = 64});
    auto exact = make_viewer(scene.exact.hierarchy, scene.exact.primitives, finest);
    double mse_sum = 0, bias = 0;
    for (const View& view : views) {
        exact.frame(view);
        subject.frame(view);
        const auto& bounds = scene.exact.hierarchy.bounds();
        const auto rect = projected_rect(bounds, view);
        mse_sum += mse(subject.image(), finest.image(), rect) / double(views.size());
        bias += coverage_error(subject.image(), finest.image(), rect).bias / double(views.size());
    }
    const double triangles = double(scene.triangles.size());
    state.counters["time_against_defaults"] = median(ratios);
    state.counters["rmse"] = std::sqrt(mse_sum);
    state.counters["coverage_bias"] = bias;
    // Of it 4 are a list of indices, which building in place saves where every primitive is in one cell.
    state.counters["bytes_per_triangle"] = double(subject.bytes) / triangles;
    state.counters["stand_ins"] = double(subject.stand_ins);
    state.counters["build_against_defaults"] = subject.build_seconds / defaults.build_seconds;
}

const bool registered = [] {
    const auto names = [] {
        std::vector<std::string> all;
        for_each_variant(ablations(1000), [&](const auto& v) { all.push_back(v.name); });
        return all;
    }();
    for (const char* scene : {"tree", "molecule", "building"}) {
        for (std::size_t i = 0; i < ablation_count; ++i) {
            benchmark::RegisterBenchmark((std::string("ablation/") + scene + "/" + names[i]).c_str(), ablation,
                                         std::string(scene), i)
                ->UseManualTime()
                ->Iterations(15)
                ->Unit(benchmark::kMillisecond);
        }
    }
    return true;
}();

}  // namespace
}  // namespace farfield::bench
