// What it costs to keep a primitive in every cell it touches (the papers' way) instead of in one loose cell.
#include <benchmark/benchmark.h>

#include <memory>

#include "support/subject.hpp"

namespace farfield::bench {
namespace {

using SharedCubes = SpatialHierarchy<SharedOctree, ColorCube, TriangleCount>;
using UniqueCubes = CubeHierarchy;

/// Built without reordering the primitives, for shared items cannot be: both sides pay for their lists of indices.
template <class H>
void assignment(benchmark::State& state, const std::string& scene, double distance) {
    const std::vector<Primitive> triangles = triangles_of(scene);
    H hierarchy;
    const double build_seconds = seconds([&] { hierarchy = build<H>(triangles); });
    ZBufferRenderer renderer;
    auto viewer = make_viewer(hierarchy, triangles, renderer);
    const View view = table_view(hierarchy.bounds(), distance, 30, 124);
    FrameStats stats;
    for (auto _ : state) stats = viewer.frame(view);
    state.counters["build_ms"] = build_seconds * 1e3;
    state.counters["bytes_per_triangle"] = double(hierarchy.bytes()) / double(triangles.size());
    state.counters["items_per_triangle"] = double(hierarchy.item_count()) / double(triangles.size());
    state.counters["runs"] = double(stats.runs);
    state.counters["triangles"] = double(stats.primitives);
    state.counters["cubes"] = double(stats.approximations);
}

void unique_cells(benchmark::State& state, double distance) {
    assignment<UniqueCubes>(state, "tree", distance);
}
void shared_cells(benchmark::State& state, double distance) {
    assignment<SharedCubes>(state, "tree", distance);
}

BENCHMARK_CAPTURE(unique_cells, d = 1.75, 1.75)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(shared_cells, d = 1.75, 1.75)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(unique_cells, d = 7, 7)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(shared_cells, d = 7, 7)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(unique_cells, d = 14, 14)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(shared_cells, d = 14, 14)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace farfield::bench
