// The asymptotic experiment of Chamberlain et al. 1996, section 5.2: "we created a sequence of increasingly complex
// scenes by recursively instancing the tree model", here from 1 to 16,384 trees, 859 million triangles. At eye level
// and from above; color cubes, opacity tensors, the exact z-buffer with instances culled, and the peer's loop over all
// triangles.
#include "scenes/generate/quadrupled_forest.hpp"

#include <benchmark/benchmark.h>

#include <map>
#include <memory>

#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/measure/image_error.hpp"
#include "peers/plain_renderer.hpp"
#include "scenes/placed_scene.hpp"
#include "support/subject.hpp"

namespace farfield::bench {
namespace {

constexpr int size_px = 512;

template <class H>
std::unique_ptr<scenes::BuiltScene> built(const scenes::Scene& scene) {
    return std::make_unique<scenes::PlacedScene<H>>(
        scene, [](std::size_t) { return Octree{}; }, typename H::approximation_type{});
}

/// The same forest in three hierarchies.
struct Forest {
    scenes::QuadrupledForestOptions options;
    scenes::Scene scene;
    std::unique_ptr<scenes::BuiltScene> exact, cubes, tensors;

    explicit Forest(std::uint32_t levels) {
        options.levels = levels;
        scene = scenes::quadrupled_forest(options);
        exact = built<ExactHierarchy>(scene);
        cubes = built<CubeHierarchy>(scene);
        tensors = built<SpatialHierarchy<Octree, OpacityTensor, TriangleCount>>(scene);
    }
    View view(bool from_above, float tolerance_px) const {
        return {.camera = from_above ? scenes::aerial(options) : scenes::eye_level(options),
                .width = size_px,
                .height = size_px,
                .tolerance_px = tolerance_px};
    }
};

const Forest& forest(std::uint32_t levels) {
    static std::map<std::uint32_t, std::unique_ptr<Forest>> forests;
    auto& f = forests[levels];
    if (!f) f = std::make_unique<Forest>(levels);
    return *f;
}

using FarField = std::unique_ptr<scenes::BuiltScene> Forest::*;

double frame_seconds(scenes::SceneViewer& viewer, const View& view) {
    return seconds([&] { viewer.frame(view); });
}

/// Pairs of 64 trees and the number asked for, in turns: `against_64` is the paper's claim of logarithmic time.
void grow(benchmark::State& state, FarField far, bool from_above) {
    const auto levels = std::uint32_t(state.range(0));
    const float tolerance_px = float(state.range(1));
    const Forest &small = forest(3), &large = forest(levels);
    const auto small_viewer = (small.*far)->viewer({}), viewer = (large.*far)->viewer({});
    const View small_view = small.view(from_above, tolerance_px), view = large.view(from_above, tolerance_px);
    viewer->frame(view);
    small_viewer->frame(small_view);
    std::vector<double> frame, ratio;
    for (auto _ : state) {
        const double with_64 = frame_seconds(*small_viewer, small_view);
        frame.push_back(frame_seconds(*viewer, view));
        ratio.push_back(frame.back() / with_64);
        state.SetIterationTime(frame.back());
    }
    const FrameStats stats = viewer->frame(view);
    state.counters["trees"] = double(1u << (2 * levels));
    state.counters["frame_ms"] = median(frame) * 1e3;
    state.counters["against_64"] = median(ratio);
    state.counters["stand_ins"] = double(stats.approximations);
    state.counters["triangles"] = double(stats.primitives);
    state.counters["instances"] = double(stats.instances);
    state.counters["hierarchy_kB"] = double((large.*far)->facts().bytes) / 1e3;
}
#define FARFIELD_GROW(far, view, from_above)                      \
    BENCHMARK_CAPTURE(grow, far / view, &Forest::far, from_above) \
        ->ArgsProduct({{0, 1, 2, 3, 4, 5, 6, 7}, {1, 2, 4}})      \
        ->ArgNames({"levels", "tolerance_px"})                    \
        ->UseManualTime()                                         \
        ->Iterations(9)                                           \
        ->Unit(benchmark::kMillisecond)
FARFIELD_GROW(cubes, eye_level, false);
FARFIELD_GROW(cubes, from_above, true);
FARFIELD_GROW(tensors, eye_level, false);
FARFIELD_GROW(tensors, from_above, true);

/// What the far field saves against the exact frame, which draws every instance in the frustum, and how right both are.
void speed_up(benchmark::State& state, FarField far_field, bool from_above) {
    const auto levels = std::uint32_t(state.range(0));
    const Forest& f = forest(levels);
    const View view = f.view(from_above, float(state.range(1)));
    const auto exact = f.exact->viewer({}), far = (f.*far_field)->viewer({}), finest = f.exact->viewer({.samples = 64});
    far->frame(view);
    std::vector<double> ratio;
    double exact_seconds = 0;
    for (auto _ : state) {
        const double far_seconds = frame_seconds(*far, view);
        exact_seconds = frame_seconds(*exact, view);
        ratio.push_back(exact_seconds / far_seconds);
        state.SetIterationTime(far_seconds);
    }
    finest->frame(view);
    state.counters["trees"] = double(1u << (2 * levels));
    state.counters["exact_ms"] = exact_seconds * 1e3;
    state.counters["speedup"] = median(ratio);
    state.counters["rmse"] = rmse(far->image(), finest->image());
    state.counters["rmse_exact"] = rmse(exact->image(), finest->image());
}
#define FARFIELD_SPEED_UP(far, view, from_above)                      \
    BENCHMARK_CAPTURE(speed_up, far / view, &Forest::far, from_above) \
        ->ArgsProduct({{3, 7}, {1, 2, 4}})                            \
        ->ArgNames({"levels", "tolerance_px"})                        \
        ->UseManualTime()                                             \
        ->Iterations(3)                                               \
        ->Unit(benchmark::kMillisecond)
FARFIELD_SPEED_UP(cubes, eye_level, false);
FARFIELD_SPEED_UP(cubes, from_above, true);
FARFIELD_SPEED_UP(tensors, eye_level, false);
FARFIELD_SPEED_UP(tensors, from_above, true);

/// Every triangle of every tree goes down the pipeline, whether it is in view or not, as in the paper's comparison.
double peer_seconds(const Forest& f, const View& view) {
    std::vector<std::vector<PlainTriangle>> groups;
    for (const scenes::Group& g : f.scene.groups) groups.push_back(plain_triangles(g.triangles));
    const auto peer = native_plain_z_buffer(1);
    const auto draw = [&](auto&& self, std::size_t group, const LocalView& local) -> void {
        peer->set_view(local);
        peer->draw(groups[group]);
        for (const auto& placement : f.scene.groups[group].placements) {
            self(self, placement.group, local.inside(Similarity(placement.to_parent), glm::dvec3(0), glm::dvec3(0)));
        }
    };
    const LocalView outermost(view, glm::dvec3(0), scenes::bounds(f.scene));
    return seconds([&] {
        peer->begin_frame(outermost);
        draw(draw, groups.size() - 1, outermost);
        peer->end_frame();
    });
}

void peer(benchmark::State& state, bool from_above) {
    const Forest& f = forest(std::uint32_t(state.range(0)));
    const View view = f.view(from_above, float(state.range(1)));
    const auto far = f.cubes->viewer({});
    far->frame(view);
    for (auto _ : state) {
        std::vector<double> far_seconds;
        for (int i = 0; i < 5; ++i) far_seconds.push_back(frame_seconds(*far, view));
        const double taken = peer_seconds(f, view);
        state.SetIterationTime(taken);
        state.counters["peer_over_cubes"] = taken / median(far_seconds);
    }
}
BENCHMARK_CAPTURE(peer, eye_level, false)
    ->Args({7, 1})
    ->ArgNames({"levels", "tolerance_px"})
    ->UseManualTime()
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(peer, from_above, true)
    ->Args({7, 1})
    ->ArgNames({"levels", "tolerance_px"})
    ->UseManualTime()
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace farfield::bench
