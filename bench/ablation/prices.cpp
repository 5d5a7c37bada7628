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

/// Leaves in a ball, through which half of the light comes, however many there are.
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

View view_of_leaves(int size, float tolerance_px) {
    View view{.camera = Camera::perspective({0.7, 0.6, 2}, {0, 0, 0}, {0, 1, 0}, 0.9f), .width = size, .height = size};
    view.tolerance_px = tolerance_px;
    view.wanted = WantedError::any();
    return view;
}

/// So many leaves a cell of 2 pixels that hardly a triangle is drawn. All that the frame of 64 pixels reads lies in the
/// cache.
template <class H>
void stand_in(benchmark::State& state) {
    const auto count = std::uint32_t(state.range(0));
    const Built<H> built(leaves(count));
    ZBufferRenderer renderer;
    auto viewer = make_viewer(built.hierarchy, built.primitives, renderer);
    const View view = view_of_leaves(int(state.range(1)), 2);
    FrameStats stats;
    double total_seconds = 0;
    for (auto _ : state) total_seconds += seconds([&] { stats = viewer.frame(view); });
    state.counters["stand_ins"] = double(stats.approximations);
    state.counters["triangles"] = double(stats.primitives);
    state.counters["ns_per_stand_in"] = total_seconds * 1e9 / double(state.iterations()) / double(stats.approximations);
}
BENCHMARK(stand_in<Tensors>)->Args({2'000'000, 64})->Args({2'000'000, 128})->Unit(benchmark::kMicrosecond);
BENCHMARK(stand_in<CubeHierarchy>)->Args({2'000'000, 64})->Args({2'000'000, 128})->Unit(benchmark::kMicrosecond);
BENCHMARK(stand_in<Splats>)->Args({2'000'000, 64})->Args({2'000'000, 128})->Unit(benchmark::kMicrosecond);

/// At a tolerance that no cell keeps: every triangle is deposited by the law of the cell that it lies in. Cells are the
/// smaller, and runs the shorter, the less they are said to cost (in 16ths). Into 64 pixels most of 20,000 leaves are
/// deposited as squares, into 16 in single lanes.
void deposited_triangle(benchmark::State& state) {
    const auto count = std::uint32_t(state.range(0));
    std::vector<Primitive> triangles = leaves(count);
    BuildOptions<Tensors> options;
    const float price = float(state.range(2)) / 16;
    options.cost_model = {
        .triangles_per_splat = 8 * price, .triangles_per_cell = 4 * price, .triangles_per_run = 4 * price};
    const auto hierarchy = build_in_place<Tensors>(triangles, options);
    ZBufferRenderer renderer;
    auto viewer = make_viewer(hierarchy, triangles, renderer);
    const View view = view_of_leaves(int(state.range(1)), 1e-3f);
    FrameStats stats;
    double total_seconds = 0;
    for (auto _ : state) total_seconds += seconds([&] { stats = viewer.frame(view); });
    state.counters["stand_ins"] = double(stats.approximations);
    state.counters["triangles_a_run"] = double(stats.primitives) / double(stats.runs);
    state.counters["ns_per_triangle"] = total_seconds * 1e9 / double(state.iterations()) / double(stats.primitives);
}
BENCHMARK(deposited_triangle)
    ->ArgNames({"leaves", "pixels", "price"})
    ->ArgsProduct({{20'000}, {16, 64}, {1, 4, 16, 256}})
    ->ArgsProduct({{1'000'000}, {512}, {1, 4, 16, 256}})
    ->Unit(benchmark::kMicrosecond);

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
