// Table 2 of Chamberlain et al. 1996: the tree and the molecule from four distances, colour cubes against everything.
//
// Every iteration draws the same view exactly, with color cubes and (rarely, for it is slow) in the peer's loop
// over all triangles, so that all sides of a ratio see the same machine. Medians; `speedup` is exact time / color-cube
// time, both with frustum culling in the same renderer at one sample a pixel. Rows "peer" compare the exact renderer
// with the peer over the same hierarchy, in flat colors: shares of the peer's time at 1 and 64 samples.
#include <benchmark/benchmark.h>

#include <map>
#include <memory>

#include "farfield/measure/coverage_error.hpp"
#include "farfield/measure/image_error.hpp"
#include "peers/plain_renderer.hpp"
#include "support/drawer.hpp"
#include "support/subject.hpp"

namespace farfield::bench {
namespace {

struct Pair {
    Built<ExactHierarchy> exact;
    Built<CubeHierarchy> cubes;
    bool is_closed;
};

const Pair& pair_of(const std::string& scene) {
    static std::map<std::string, std::unique_ptr<Pair>> pairs;
    auto& pair = pairs[scene];
    if (!pair) {
        const std::vector<Primitive> triangles = triangles_of(scene);
        pair.reset(new Pair{Built<ExactHierarchy>(triangles), Built<CubeHierarchy>(triangles), scene == "molecule"});
    }
    return *pair;
}

void table2(benchmark::State& state, const std::string& scene, double angle_degrees, double distance) {
    const Pair& pair = pair_of(scene);
    const ZBufferOptions options{.culls_back_faces = pair.is_closed};
    ZBufferOptions finest = options;
    finest.samples = 64;
    ZBufferRenderer exact_renderer(options), cube_renderer(options), reference_renderer(finest);
    auto exact = make_viewer(pair.exact.hierarchy, pair.exact.primitives, exact_renderer);
    auto cubes = make_viewer(pair.cubes.hierarchy, pair.cubes.primitives, cube_renderer);
    const View view = table_view(pair.exact.hierarchy.bounds(), distance, angle_degrees, 124);
    FrameStats stats;
    exact.frame(view);
    cubes.frame(view);
    std::vector<double> exact_seconds, cube_seconds, peer_seconds, ratios;
    for (auto _ : state) {
        exact_seconds.push_back(seconds([&] { exact.frame(view); }));
        cube_seconds.push_back(seconds([&] { stats = cubes.frame(view); }));
        ratios.push_back(exact_seconds.back() / cube_seconds.back());
        state.SetIterationTime(cube_seconds.back());
    }
    const auto peer = list_drawer<PlainRenderer>(pair.exact.primitives, PlainOptions{});
    peer->frame(view);
    for (int i = 0; i < 3; ++i) peer_seconds.push_back(seconds([&] { peer->frame(view); }));
    auto reference = make_viewer(pair.exact.hierarchy, pair.exact.primitives, reference_renderer);
    reference.frame(view);
    state.counters["exact_ms"] = median(exact_seconds) * 1e3;
    state.counters["cube_ms"] = median(cube_seconds) * 1e3;
    state.counters["speedup"] = median(ratios);
    state.counters["peer_over_cube"] = median(peer_seconds) / median(cube_seconds);
    state.counters["cubes"] = double(stats.approximations);
    state.counters["triangles"] = double(stats.primitives);
    state.counters["rmse_cube"] = rmse(cube_renderer.image(), reference_renderer.image());
    state.counters["rmse_exact"] = rmse(exact_renderer.image(), reference_renderer.image());
    state.counters["coverage_bias"] = coverage_error(cube_renderer.image(), reference_renderer.image()).bias;
}

/// The paper's views: scene, degrees off axis, distance in radii.
#define FARFIELD_EACH_VIEW(row) \
    row(tree, 30, 1.75);        \
    row(tree, 30, 3.5);         \
    row(tree, 30, 7);           \
    row(tree, 30, 14);          \
    row(molecule, 25, 1.75);    \
    row(molecule, 25, 3.5);     \
    row(molecule, 25, 7);       \
    row(molecule, 25, 14);
#define FARFIELD_TABLE2(scene, angle, distance)                              \
    BENCHMARK_CAPTURE(table2, scene / d = distance, #scene, angle, distance) \
        ->UseManualTime()                                                    \
        ->Iterations(31)                                                     \
        ->Unit(benchmark::kMillisecond)
FARFIELD_EACH_VIEW(FARFIELD_TABLE2)

/// The z-buffer's share of the peer's time.
void peer(benchmark::State& state, const std::string& scene, double angle_degrees, double distance) {
    static std::map<std::string, std::unique_ptr<Built<ExactHierarchy>>> scenes;
    auto& flat = scenes[scene];
    if (!flat) flat = std::make_unique<Built<ExactHierarchy>>(in_flat_colors(triangles_of(scene)));
    const View view = table_view(flat->hierarchy.bounds(), distance, angle_degrees, 124);
    for (auto _ : state) {
        double seconds = 0;
        for (const auto& [samples, name] : {std::pair{1, "share_1"}, {64, "share_64"}}) {
            const auto ours = drawer<ZBufferRenderer>(flat->hierarchy, flat->primitives, ZBufferOptions{samples});
            const auto other = drawer<PlainRenderer>(flat->hierarchy, flat->primitives, PlainOptions{samples});
            const PairTimes times = in_turns(
                Patience{}, [&] { ours->frame(view); }, [&] { other->frame(view); });
            state.counters[name] = 1 / times.speedup;
            seconds += 1e-3 * times.ms;
        }
        state.SetIterationTime(seconds);
    }
}
#define FARFIELD_PEER(scene, angle, distance)                              \
    BENCHMARK_CAPTURE(peer, scene / d = distance, #scene, angle, distance) \
        ->UseManualTime()                                                  \
        ->Iterations(1)                                                    \
        ->Unit(benchmark::kMillisecond)
FARFIELD_EACH_VIEW(FARFIELD_PEER)

/// Seconds for the whole hierarchy with color cubes on one core, and what it weighs.
void build(benchmark::State& state, const std::string& scene) {
    const std::vector<Primitive> triangles = triangles_of(scene);
    double bytes = 0, nodes = 0, levels = 0;
    for (auto _ : state) {
        const Built<CubeHierarchy> built(triangles);
        state.SetIterationTime(built.build_seconds);
        bytes = built.bytes_per_triangle();
        nodes = double(built.hierarchy.nodes().size());
        levels = double(built.hierarchy.report().levels);
    }
    state.counters["triangles_per_s"] =
        benchmark::Counter(double(triangles.size()) * double(state.iterations()), benchmark::Counter::kIsRate);
    state.counters["bytes_per_triangle"] = bytes;
    state.counters["nodes"] = nodes;
    state.counters["levels"] = levels;
}
BENCHMARK_CAPTURE(build, tree, "tree")->UseManualTime()->Iterations(11)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(build, molecule, "molecule")->UseManualTime()->Iterations(3)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace farfield::bench
