// What one of a thing takes, everything included: a stand-in, a small triangle that is deposited, a pick. A stand-in's
// visits, projection, shape and deposit are in its price, and so is what a frame takes without any.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "farfield/approximation/area_splat.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/pick.hpp"
#include "scenes/generate/random.hpp"
#include "support/subject.hpp"

namespace farfield::bench {
namespace {

using Tensors = SpatialHierarchy<Octree, OpacityTensor, TriangleCount>;
using Splats = SpatialHierarchy<Octree, AreaSplat, TriangleCount>;

/// Leaves in a ball: with 10,000 of them all that a frame reads lies in the cache, with a million little does.
std::vector<Primitive> leaves(std::uint32_t count) {
    scenes::Random random(1);
    const float size = 2 / std::sqrt(float(count));
    std::vector<Primitive> out;
    while (out.size() < count) {
        const glm::vec3 at = std::cbrt(random.unit()) * random.direction();
        const Rgba8 green{60, std::uint8_t(150 + 80 * at.y), 40, 255};
        out.push_back({{at, at + size * random.direction(), at + size * random.direction()}, {green, green, green}});
    }
    return out;
}

/// 64 x 64 pixels for each 1,000 leaves, so that many stand in and few pixels are cleared.
View view_of_leaves(std::uint32_t count, float tolerance_px) {
    const int size = int(std::lround(64 * std::sqrt(count / 10'000.0)));
    return {.camera = Camera::perspective({0.7, 0.6, 2}, {0, 0, 0}, {0, 1, 0}, 0.9f),
            .width = size,
            .height = size,
            .tolerance_px = tolerance_px};
}

template <class H>
void stand_in(benchmark::State& state) {
    const auto count = std::uint32_t(state.range(0));
    const Built<H> built(leaves(count));
    ZBufferRenderer renderer;
    auto viewer = make_viewer(built.hierarchy, built.primitives, renderer);
    const View view = view_of_leaves(count, 4);
    FrameStats stats;
    double total_seconds = 0;
    for (auto _ : state) total_seconds += seconds([&] { stats = viewer.frame(view); });
    state.counters["stand_ins"] = double(stats.approximations);
    state.counters["triangles"] = double(stats.primitives);
    state.counters["ns_per_stand_in"] = total_seconds * 1e9 / double(state.iterations()) / double(stats.approximations);
}
BENCHMARK(stand_in<Tensors>)->Arg(10'000)->Arg(1'000'000)->Unit(benchmark::kMicrosecond);
BENCHMARK(stand_in<CubeHierarchy>)->Arg(10'000)->Arg(1'000'000)->Unit(benchmark::kMicrosecond);
BENCHMARK(stand_in<Splats>)->Arg(10'000)->Arg(1'000'000)->Unit(benchmark::kMicrosecond);

/// At a tolerance that no cell keeps: every triangle is deposited by the law of the cell that it lies in.
void deposited_triangle(benchmark::State& state) {
    const auto count = std::uint32_t(state.range(0));
    const Built<Tensors> built(leaves(count));
    ZBufferRenderer renderer;
    auto viewer = make_viewer(built.hierarchy, built.primitives, renderer);
    const View view = view_of_leaves(count, 1e-3f);
    FrameStats stats;
    double total_seconds = 0;
    for (auto _ : state) total_seconds += seconds([&] { stats = viewer.frame(view); });
    state.counters["runs"] = double(stats.runs);
    state.counters["ns_per_triangle"] = total_seconds * 1e9 / double(state.iterations()) / double(stats.primitives);
}
BENCHMARK(deposited_triangle)->Arg(10'000)->Arg(1'000'000)->Unit(benchmark::kMicrosecond);

/// What lies under points all over a picture; one in ten thousand takes longest.
void pick_under_a_point(benchmark::State& state, const char* scene) {
    const Built<ExactHierarchy> built(triangles_of(scene));
    const View view = table_view(built.hierarchy.bounds(), 2.5, 30, 512);
    scenes::Random random(1);
    std::vector<double> took;
    std::size_t hits = 0;
    for (auto _ : state) {
        const glm::dvec2 pixel(random.between(0, 512), random.between(0, 512));
        took.push_back(seconds([&] { hits += pick(built.hierarchy, built.primitives, view, pixel).has_value(); }));
    }
    std::sort(took.begin(), took.end());
    state.counters["hits"] = double(hits) / double(took.size());
    state.counters["median_us"] = 1e6 * took[took.size() / 2];
    state.counters["p99_us"] = 1e6 * took[took.size() * 99 / 100];
    state.counters["longest_us"] = 1e6 * took.back();
}
BENCHMARK_CAPTURE(pick_under_a_point, tree, "tree")->Iterations(10'000)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(pick_under_a_point, forest, "forest")->Iterations(10'000)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(pick_under_a_point, molecule, "molecule")->Iterations(10'000)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace farfield::bench
