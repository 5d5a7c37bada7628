// What one of a thing takes, everything included: a stand-in, a small triangle that is deposited, a pick. A stand-in's
// visits, projection, shape and deposit are in its price, and so is what a frame takes without any.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <vector>

#include "farfield/approximation/area_splat.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/geometry/ray.hpp"
#include "farfield/pick.hpp"
#include "farfield/primitive/instance.hpp"
#include "farfield/view/pixel_ray.hpp"
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

/// What lies under points all over a picture; one in ten thousand takes longest. A ray that hits nothing takes less.
template <class H, class P>
void pick_points(benchmark::State& state, const H& hierarchy, const std::vector<P>& primitives, const View& view) {
    scenes::Random random(1);
    std::vector<double> took;
    for (auto _ : state) {
        const glm::dvec2 pixel(random.between(0, float(view.width)), random.between(0, float(view.height)));
        bool hits = false;
        const double s = seconds([&] { hits = pick(hierarchy, primitives, view, pixel).has_value(); });
        if (hits) took.push_back(s);
    }
    if (took.empty()) return state.SkipWithError("no ray hits anything");
    std::sort(took.begin(), took.end());
    state.counters["hits"] = double(took.size());
    state.counters["median_us"] = 1e6 * took[took.size() / 2];
    state.counters["p99_us"] = 1e6 * took[took.size() * 99 / 100];
    state.counters["longest_us"] = 1e6 * took.back();
}
View picking_view(const Box& bounds, double distance) {
    View view = table_view(bounds, distance, 30, 512);
    // From above: a board seen from its side is nothing.
    const glm::dvec3 center(bounds.center()), eye = view.camera.eye + glm::dvec3(0, 0.3 * bounds.largest_side(), 0);
    view.camera = Camera::perspective(eye, center, {0, 1, 0}, 1.04719755f);
    return view;
}
void pick_under_a_point(benchmark::State& state, const char* scene, double distance) {
    const Built<ExactHierarchy> built(triangles_of(scene));
    pick_points(state, built.hierarchy, built.primitives, picking_view(built.hierarchy.bounds(), distance));
}
BENCHMARK_CAPTURE(pick_under_a_point, tree, "tree", 2.5)->Iterations(10'000)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(pick_under_a_point, chessboard, "chessboard", 2.5)->Iterations(10'000)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(pick_under_a_point, forest, "forest", 2.5)->Iterations(10'000)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(pick_under_a_point, forest_from_within, "forest", 0.5)
    ->Iterations(10'000)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(pick_under_a_point, molecule, "molecule", 2.5)->Iterations(10'000)->Unit(benchmark::kMicrosecond);

/// The same where trees are instances.
void pick_in_instances(benchmark::State& state, double distance) {
    using Placed = Instance<ExactHierarchy, Primitive>;
    const scenes::Scene scene = scenes::make("forest-instanced");
    std::vector<Built<ExactHierarchy>> kinds;
    for (const auto& group : scene.groups) {
        if (group.placements.empty()) kinds.emplace_back(group.triangles);
    }
    std::vector<Placed> trees;
    for (const auto& p : scene.groups.back().placements) {
        trees.push_back({&kinds.at(p.group).hierarchy, kinds[p.group].primitives, Similarity(p.to_parent)});
    }
    const auto forest = build_in_place<ExactHierarchy>(trees);
    pick_points(state, forest, trees, picking_view(forest.bounds(), distance));
}
BENCHMARK_CAPTURE(pick_in_instances, forest, 2.5)->Iterations(10'000)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(pick_in_instances, forest_from_within, 0.5)->Iterations(10'000)->Unit(benchmark::kMicrosecond);

/// Picks that are other than a loop over all triangles finds (Möller and Trumbore 1997: another formula than the
/// library's); triangles at one distance, but for rounding, are one.
void pick_or_look_at_all(benchmark::State& state, const char* scene) {
    const Built<ExactHierarchy> built(triangles_of(scene));
    const View view = picking_view(built.hierarchy.bounds(), 1.2);
    scenes::Random random(1);
    std::size_t hits = 0, wrong = 0;
    for (auto _ : state) {
        const Ray ray = ray_through(view, {random.between(0, 512), random.between(0, 512)});
        double nearest = std::numeric_limits<double>::infinity();
        for (const Primitive& t : built.primitives) {
            const glm::dvec3 a(t.vertices[0]), e(glm::dvec3(t.vertices[1]) - a), f(glm::dvec3(t.vertices[2]) - a),
                p = glm::cross(ray.direction, f), s = ray.origin - a, q = glm::cross(s, e);
            const double area = glm::dot(e, p), u = glm::dot(s, p) / area, v = glm::dot(ray.direction, q) / area,
                         distance = glm::dot(f, q) / area;
            if (area != 0 && u >= 0 && v >= 0 && u + v <= 1 && distance >= 0) nearest = std::min(nearest, distance);
        }
        const auto picked = pick(built.hierarchy, built.primitives, ray);
        hits += picked.has_value();
        wrong += picked.has_value() != std::isfinite(nearest) ||
                 (picked && std::abs(picked->distance - nearest) > 1e-9 * nearest);
    }
    state.counters["hits"] = double(hits);
    state.counters["wrong"] = double(wrong);
}
BENCHMARK_CAPTURE(pick_or_look_at_all, tree, "tree")->Iterations(10'000)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(pick_or_look_at_all, chessboard, "chessboard")->Iterations(10'000)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace farfield::bench
