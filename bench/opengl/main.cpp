// What OpenGL gains by stand-ins: frames of the molecule against one call that draws all of its triangles from one
// static vertex buffer, and the quadrupled forest. From the first call of a frame to the end of glFinish.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
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

/// The least of some frames of each, in turns.
void compare(const std::string& what, scenes::SceneViewer& one_call, scenes::SceneViewer& far, View view, int turns) {
    double exact_ms = 1e9, far_ms = 1e9;
    FrameStats stats;
    for (int i = 0; i < turns; ++i) {
        View all = view;
        all.tolerance_px = 0;
        exact_ms = std::min(exact_ms, milliseconds(one_call, all, stats));
        for (int k = 0; k < 5; ++k) far_ms = std::min(far_ms, milliseconds(far, view, stats));
    }
    std::printf("| %s, %g px | %.1f | %.2f | %.0f | %llu |\n", what.c_str(), double(view.tolerance_px), exact_ms,
                far_ms, exact_ms / far_ms, static_cast<unsigned long long>(stats.splats + stats.faces));
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
    const auto one_call = exact->viewer(opengl), of_cubes = cubes->viewer(opengl), of_tensors = tensors->viewer(opengl);
    std::printf("| molecule, 14 radii | one call, ms | far field, ms | times | stand-ins |\n|---|---|---|---|---|\n");
    for (const float tolerance : {1.0f, 2.0f, 4.0f}) {
        view.tolerance_px = tolerance;
        compare("cubes", *one_call, *of_cubes, view, 5);
        compare("tensors", *one_call, *of_tensors, view, 5);
    }
}

void draw_forest() {
    const scenes::Scene scene = scenes::quadrupled_forest();
    std::printf("\n| quadrupled forest | ms | frames a second | stand-ins | triangles |\n|---|---|---|---|---|\n");
    const auto draw = [&](const char* name, const scenes::BuiltScene& of) {
        const auto viewer = of.viewer({.kind = scenes::RendererKind::opengl});
        for (const bool is_aerial : {true, false}) {
            for (const float tolerance : {1.0f, 2.0f, 4.0f}) {
                const View view{.camera = is_aerial ? scenes::aerial({}) : scenes::eye_level({}),
                                .width = 640,
                                .height = 360,
                                .tolerance_px = tolerance};
                double ms = 1e9;
                FrameStats stats;
                for (int i = 0; i < 5; ++i) ms = std::min(ms, milliseconds(*viewer, view, stats));
                std::printf("| %s, %s, %g px | %.1f | %.1f | %llu | %llu |\n", name,
                            is_aerial ? "from above" : "eye level", double(tolerance), ms, 1000 / ms,
                            static_cast<unsigned long long>(stats.splats + stats.faces),
                            static_cast<unsigned long long>(stats.primitives));
            }
        }
    };
    draw("cubes", *built<ColorCube>(scene));
    draw("tensors", *built<OpacityTensor>(scene));
}

}  // namespace

int main() {
    draw_molecule();
    draw_forest();
}
