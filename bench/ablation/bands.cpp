// What drawing one picture on all cores gains: frames of a Viewer and of a BandedViewer in turns, by the clock on the
// wall. Run it while nothing else runs. The last column has both on one thread: what bands cost, because a cell that
// two bands show is visited twice.
//
//     bench_bands [THREADS]      default: as many as the machine runs at once
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <string>
#include <vector>

#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/banded_viewer.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/executor.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/instance.hpp"
#include "farfield/renderer/coverage_renderer.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "scenes/generate/tree.hpp"
#include "support/pair.hpp"
#include "support/seconds.hpp"

namespace farfield::bench {
namespace {

constexpr std::size_t bands_a_thread = 4;

template <class Hierarchy>
struct Forest {
    using Tree = SpatialHierarchy<Octree, typename Hierarchy::approximation_type, TriangleCount>;
    using Primitive = Instance<Tree, VertexColoredTriangle>;

    std::vector<VertexColoredTriangle> leaves = scenes::tree().groups.back().triangles;
    Tree tree = build<Tree>(leaves);
    std::vector<Primitive> trees = placed();
    Hierarchy hierarchy = build<Hierarchy>(trees);

    std::vector<Primitive> placed() const {
        std::vector<Primitive> result;
        const float step = 1.5f * glm::length(tree.bounds().size());
        for (int z = 0; z < 20; ++z) {
            for (int x = 0; x < 20; ++x) {
                Similarity place;
                place.translation = {step * float(x - 10), 0, step * float(z - 10)};
                result.push_back({&tree, leaves, place});
            }
        }
        return result;
    }
    std::vector<View> views(float tolerance_px) const {
        const glm::vec3 size = hierarchy.bounds().size(), center = hierarchy.bounds().center();
        std::vector<View> result;
        for (const float height : {0.02f, 0.1f, 0.3f}) {
            const glm::vec3 eye = center + glm::vec3(0.35f, height, 0.4f) * size.x;
            result.push_back({.camera = Camera::perspective(eye, center, {0, 1, 0}, std::numbers::pi_v<float> / 4),
                              .width = 640,
                              .height = 360,
                              .tolerance_px = tolerance_px});
        }
        return result;
    }
};

/// Medians over views of medians over turns.
template <class R, class Hierarchy, class P, class Options>
void add(const std::string& name, const Hierarchy& hierarchy, const std::vector<P>& primitives,
         const std::vector<View>& views, const Options& options, unsigned threads) {
    R renderer(options);
    auto whole = make_viewer(hierarchy, primitives, renderer);
    auto banded =
        make_banded_viewer(hierarchy, primitives, bands_a_thread * threads, [&](std::size_t) { return R(options); });
    const ThreadExecutor executor(threads);
    std::vector<double> ms, speedups, costs;
    for (const View& view : views) {
        std::vector<double> one, bands, all;
        for (int turn = 0; turn < 7; ++turn) {
            one.push_back(seconds([&] { whole.frame(view); }));
            bands.push_back(seconds([&] { banded.frame(view); }));
            all.push_back(seconds([&] { banded.frame(view, executor); }));
        }
        // Buffers grew in the first turn.
        for (auto* times : {&one, &bands, &all}) times->erase(times->begin());
        std::vector<double> gained, cost;
        for (std::size_t i = 0; i < one.size(); ++i) {
            gained.push_back(one[i] / all[i]);
            cost.push_back(bands[i] / one[i]);
        }
        ms.push_back(1e3 * middle(one));
        speedups.push_back(middle(gained));
        costs.push_back(middle(cost));
        const auto pixels = renderer.image().pixels(), others = banded.image().pixels();
        if (!std::equal(pixels.begin(), pixels.end(), others.begin(), others.end())) {
            std::printf("bench_bands: %s: the pictures differ\n", name.c_str());
            std::exit(1);
        }
    }
    std::printf("| %s | %.3g | %.2f, %.2f | %.2f |\n", name.c_str(), middle(ms), middle(speedups),
                *std::min_element(speedups.begin(), speedups.end()), middle(costs));
    std::fflush(stdout);
}

template <class Hierarchy>
void add_all(const std::string& name, float tolerance_px, unsigned threads) {
    const Forest<Hierarchy> forest;
    const auto views = forest.views(tolerance_px);
    add<ZBufferRenderer>(name + ", z-buffer", forest.hierarchy, forest.trees, views, ZBufferOptions{}, threads);
    add<ZBufferRenderer>(name + ", z-buffer of 16 samples", forest.hierarchy, forest.trees, views,
                         ZBufferOptions{.samples = 16}, threads);
    add<CoverageRenderer>(name + ", masks of 64", forest.hierarchy, forest.trees, views, CoverageOptions{}, threads);
}

}  // namespace
}  // namespace farfield::bench

int main(int argc, char** argv) {
    using namespace farfield::bench;
    using namespace farfield;
    const unsigned threads = argc > 1 ? unsigned(std::max(1, std::atoi(argv[1]))) : ThreadExecutor().threads();
    std::printf("| 400 trees | one thread, ms | speed-up on %u: median, worst | bands on one thread, part |\n",
                threads);
    std::puts("|---|---|---|---|");
    add_all<SpatialHierarchy<Octree, Exact, TriangleCount>>("exact", 0, threads);
    add_all<SpatialHierarchy<Octree, ColorCube, TriangleCount>>("cubes, 2 px", 2, threads);
    add_all<SpatialHierarchy<Octree, OpacityTensor, TriangleCount>>("tensors, 2 px", 2, threads);
}
