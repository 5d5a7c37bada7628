// What the z-buffer itself takes: a forest of a million triangles at 512 x 512 and one sample, from inside and from
// afar. The exact side of every ratio is only honest if these are small.
#include <benchmark/benchmark.h>

#include "support/subject.hpp"

namespace farfield::bench {
namespace {

const Built<ExactHierarchy>& forest() {
    static const Built<ExactHierarchy> built(triangles_of("forest"));
    return built;
}

/// Nanoseconds of a frame for each triangle of the scene, with frustum culling.
void forest_exact(benchmark::State& state, bool is_near) {
    const Built<ExactHierarchy>& built = forest();
    ZBufferRenderer renderer;
    auto viewer = make_viewer(built.hierarchy, built.primitives, renderer);
    const Box& bounds = built.hierarchy.bounds();
    View view = table_view(bounds, 6, 30, 512);
    if (is_near) {
        // Among the trees, at the height of a person's eyes.
        const glm::dvec3 eye(bounds.lower.x + 0.15 * bounds.size().x, bounds.lower.y + 1.7,
                             bounds.lower.z + 0.15 * bounds.size().z);
        view.camera = Camera::perspective(eye, glm::dvec3(bounds.center()), {0, 1, 0}, 1.04719755f);
    }
    FrameStats stats;
    double total_seconds = 0;
    for (auto _ : state) total_seconds += seconds([&] { stats = viewer.frame(view); });
    state.counters["ns_per_triangle"] =
        total_seconds * 1e9 / double(state.iterations()) / double(built.primitives.size());
    state.counters["triangles_in_frustum"] = double(stats.primitives);
}
BENCHMARK_CAPTURE(forest_exact, near, true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(forest_exact, far, false)->Unit(benchmark::kMillisecond);

/// The same kernel at each width; all give the same picture.
void forest_simd(benchmark::State& state, Simd simd) {
    const Built<ExactHierarchy>& built = forest();
    ZBufferRenderer renderer({.simd = simd});
    auto viewer = make_viewer(built.hierarchy, built.primitives, renderer);
    const View view = table_view(built.hierarchy.bounds(), 6, 30, 512);
    for (auto _ : state) viewer.frame(view);
}
BENCHMARK_CAPTURE(forest_simd, scalar, Simd::scalar)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(forest_simd, four_lanes, Simd::four_lanes)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(forest_simd, eight_lanes, Simd::eight_lanes)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace farfield::bench
