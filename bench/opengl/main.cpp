// What OpenGL gains by stand-ins: frames of the molecule against one call that draws all of its triangles from one
// static vertex buffer, and the quadrupled forest, over which the camera moves 5 cm a frame. From the first call of a
// frame to the end of glFinish.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <glm/geometric.hpp>
#include <memory>
#include <string>
#include <vector>

#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "scenes/catalog.hpp"
#include "scenes/generate/quadrupled_forest.hpp"
#include "scenes/placed_scene.hpp"

namespace {

using namespace farfield;

template <class Approximation>
std::unique_ptr<scenes::BuiltScene> built(const scenes::Scene& scene) {
    using Hierarchy = SpatialHierarchy<Octree, Approximation, TriangleCount>;
    return std::make_unique<scenes::PlacedScene<Hierarchy>>(
        scene, [](std::size_t) { return Octree{}; }, Approximation{});
}

double milliseconds(scenes::SceneViewer& viewer, const View& view, FrameStats& stats) {
    const auto begin = std::chrono::steady_clock::now();
    stats = viewer.frame(view);
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

/// OpenGL alone, and with a z-buffer on the processor that says what is hidden.
struct Pair {
    std::unique_ptr<scenes::SceneViewer> alone, culled;

    explicit Pair(const scenes::BuiltScene& of)
        : alone(of.viewer({.kind = scenes::RendererKind::opengl, .draws_hidden = true})),
          culled(of.viewer({.kind = scenes::RendererKind::opengl})) {}
};

unsigned long long stand_ins(const FrameStats& stats) {
    return stats.splats + stats.faces;
}

double median(std::vector<double> values) {
    std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(values.size() / 2), values.end());
    return values[values.size() / 2];
}

/// Frames of both in turns, in rows of five as a user's follow one another; each from a step farther to the right, so
/// that what changes is sent. Medians, a first row left out, which sends everything.
struct Medians {
    double alone_ms = 0, culled_ms = 0;
    FrameStats alone, culled;

    Medians(
        Pair& pair, View view, double step, const std::function<void(const View&)>& between_rows = [](auto&) {}) {
        std::vector<double> all_alone, all_culled;
        for (int i = 0; i < 20; ++i) {
            if (i % 5 == 0) between_rows(view);
            view.camera.eye += glm::dvec3(view.camera.right) * step;
            const double alone_took = milliseconds(*pair.alone, view, alone);
            const double culled_took = milliseconds(*pair.culled, view, culled);
            if (i < 5) continue;
            all_alone.push_back(alone_took);
            all_culled.push_back(culled_took);
        }
        alone_ms = median(all_alone);
        culled_ms = median(all_culled);
    }
};

void compare(const char* what, scenes::SceneViewer& one_call, Pair& far, const View& view, double step) {
    std::vector<double> exact;
    FrameStats stats;
    const Medians m(far, view, step, [&](View all) {
        all.tolerance_px = 0;
        exact.push_back(milliseconds(one_call, all, stats));
    });
    exact.erase(exact.begin());
    const double exact_ms = median(exact);
    std::printf("| %s, %g px, %s | %.1f | %.2f | %.0f | %llu | %.2f | %.0f | %llu |\n", what, double(view.tolerance_px),
                step == 0 ? "still" : "moving", exact_ms, m.alone_ms, exact_ms / m.alone_ms, stand_ins(m.alone),
                m.culled_ms, exact_ms / m.culled_ms, stand_ins(m.culled));
    std::fflush(stdout);
}

void draw_molecule() {
    const scenes::Scene scene = scenes::make("molecule");
    const Box bounds = scenes::bounds(scene);
    const glm::dvec3 center(bounds.center());
    const double radius = 0.5 * double(glm::length(bounds.size()));
    View view{.camera = Camera::perspective(center + glm::normalize(glm::dvec3(0.3, 0.4, 1)) * (14 * radius), center,
                                            {0, 1, 0}, 0.8f),
              .width = 640,
              .height = 360};
    const auto exact = built<Exact>(scene), cubes = built<ColorCube>(scene), tensors = built<OpacityTensor>(scene);
    const scenes::RendererChoice opengl{.kind = scenes::RendererKind::opengl};
    const auto one_call = exact->viewer(opengl);
    Pair of_cubes(*cubes), of_tensors(*tensors);
    std::printf(
        "| molecule, 14 radii | one call, ms | OpenGL alone, ms | times | stand-ins | culled in software, ms | "
        "times | stand-ins |\n|---|---|---|---|---|---|---|---|\n");
    for (const float tolerance : {1.0f, 2.0f, 4.0f}) {
        view.tolerance_px = tolerance;
        for (const double step : {0.0, 0.001 * radius}) {
            compare("cubes", *one_call, of_cubes, view, step);
            compare("tensors", *one_call, of_tensors, view, step);
        }
    }
}

void print(double ms, const FrameStats& stats) {
    std::printf(" %.1f | %.1f | %llu | %llu |", ms, 1000 / ms, stand_ins(stats),
                static_cast<unsigned long long>(stats.primitives));
}

void draw_forest() {
    const scenes::Scene scene = scenes::quadrupled_forest();
    std::printf(
        "\n| quadrupled forest | alone, ms | frames a second | stand-ins | triangles | culled in software, ms | "
        "frames a second | stand-ins | triangles |\n|---|---|---|---|---|---|---|---|---|\n");
    const auto draw = [&](const char* name, const scenes::BuiltScene& of) {
        Pair pair(of);
        for (const bool is_aerial : {true, false}) {
            for (const float tolerance : {1.0f, 2.0f, 4.0f}) {
                const View view{.camera = is_aerial ? scenes::aerial({}) : scenes::eye_level({}),
                                .width = 640,
                                .height = 360,
                                .tolerance_px = tolerance};
                const Medians m(pair, view, 0.05);
                std::printf("| %s, %s, %g px |", name, is_aerial ? "from above" : "eye level", double(tolerance));
                print(m.alone_ms, m.alone);
                print(m.culled_ms, m.culled);
                std::printf("\n");
                std::fflush(stdout);
            }
        }
    };
    draw("cubes", *built<ColorCube>(scene));
    draw("tensors", *built<OpacityTensor>(scene));
}

}  // namespace

/// The molecule, or the forest, or both.
int main(int argc, char** argv) {
    setenv("LP_NUM_THREADS", "0", /*overwrite=*/0);  // llvmpipe draws on one thread, as all else here does
    const std::string only = argc > 1 ? argv[1] : "";
    if (only != "forest") draw_molecule();
    if (only != "molecule") draw_forest();
}
