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
#include <numeric>
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

/// OpenGL alone; the same where stand-ins are shaped by the processor and sent; and with a z-buffer on the processor
/// that says what is hidden.
struct Viewers {
    std::unique_ptr<scenes::SceneViewer> alone, sent, culled;

    explicit Viewers(const scenes::BuiltScene& of)
        : alone(of.viewer({.kind = scenes::RendererKind::opengl, .draws_hidden = true})),
          sent(of.viewer({.kind = scenes::RendererKind::opengl, .draws_hidden = true, .shapes_here = true})),
          culled(of.viewer({.kind = scenes::RendererKind::opengl})) {}
};

unsigned long long stand_ins(const FrameStats& stats) {
    return stats.splats + stats.faces;
}

double median(std::vector<double> values) {
    std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(values.size() / 2), values.end());
    return values[values.size() / 2];
}

/// Of the frames of one viewer.
struct Measured {
    std::vector<double> all_ms{}, all_bytes{};
    FrameStats stats{};

    void draw(scenes::SceneViewer& viewer, const View& view) {
        all_ms.push_back(milliseconds(viewer, view, stats));
        all_bytes.push_back(double(viewer.sent_bytes()));
    }
    void forget() { all_ms.clear(), all_bytes.clear(); }
    double ms() const { return median(all_ms); }
    double kilobytes() const {
        return std::accumulate(all_bytes.begin(), all_bytes.end(), 0.0) / (1000 * double(all_bytes.size()));
    }
};

/// Frames of all in turns, in rows of five as a user's follow one another; each from a step farther to the right, so
/// that what changes is sent. Medians and mean bytes, a first row left out, which sends everything.
struct InTurns {
    Measured alone, sent, culled;

    InTurns(
        Viewers& viewers, View view, double step, const std::function<void(const View&)>& between_rows = [](auto&) {}) {
        for (int i = 0; i < 20; ++i) {
            if (i == 5) alone.forget(), sent.forget(), culled.forget();
            if (i % 5 == 0) between_rows(view);
            view.camera.eye += glm::dvec3(view.camera.right) * step;
            alone.draw(*viewers.alone, view);
            sent.draw(*viewers.sent, view);
            culled.draw(*viewers.culled, view);
        }
    }
};

void compare(const char* what, scenes::SceneViewer& one_call, Viewers& far, const View& view, double step) {
    std::vector<double> exact;
    FrameStats stats;
    const InTurns m(far, view, step, [&](View all) {
        all.tolerance_px = 0;
        exact.push_back(milliseconds(one_call, all, stats));
    });
    exact.erase(exact.begin());
    const double exact_ms = median(exact);
    std::printf("| %s, %g px, %s | %.1f | %.2f | %.0f | %llu | %.1f | %.2f; %.1f | %.2f | %.0f | %llu | %.1f |\n", what,
                double(view.tolerance_px), step == 0 ? "still" : "moving", exact_ms, m.alone.ms(),
                exact_ms / m.alone.ms(), stand_ins(m.alone.stats), m.alone.kilobytes(), m.sent.ms(), m.sent.kilobytes(),
                m.culled.ms(), exact_ms / m.culled.ms(), stand_ins(m.culled.stats), m.culled.kilobytes());
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
    Viewers of_cubes(*cubes), of_tensors(*tensors);
    std::printf(
        "| molecule, 14 radii | one call, ms | OpenGL alone, ms | times | stand-ins | kB a frame | shaped by the "
        "processor, ms; kB | culled in software, ms | times | stand-ins | kB |\n"
        "|---|---|---|---|---|---|---|---|---|---|---|\n");
    for (const float tolerance : {1.0f, 2.0f, 4.0f}) {
        view.tolerance_px = tolerance;
        for (const double step : {0.0, 0.001 * radius}) {
            compare("cubes", *one_call, of_cubes, view, step);
            compare("tensors", *one_call, of_tensors, view, step);
        }
    }
}

void print(const Measured& m) {
    std::printf(" %.1f | %.1f | %llu | %llu | %.1f |", m.ms(), 1000 / m.ms(), stand_ins(m.stats),
                static_cast<unsigned long long>(m.stats.primitives), m.kilobytes());
}

void draw_forest(const std::string& only) {
    const scenes::Scene scene = scenes::quadrupled_forest();
    std::printf(
        "\n| quadrupled forest | alone, ms | frames a second | stand-ins | triangles | kB | shaped by the processor, "
        "ms; "
        "kB | culled in software, ms | frames a second | stand-ins | triangles | kB |\n"
        "|---|---|---|---|---|---|---|---|---|---|---|---|\n");
    const auto draw = [&](const char* name, const scenes::BuiltScene& of) {
        Viewers viewers(of);
        for (const bool is_aerial : {true, false}) {
            for (const float tolerance : {1.0f, 2.0f, 4.0f}) {
                const View view{.camera = is_aerial ? scenes::aerial({}) : scenes::eye_level({}),
                                .width = 640,
                                .height = 360,
                                .tolerance_px = tolerance};
                const InTurns m(viewers, view, 0.05);
                std::printf("| %s, %s, %g px |", name, is_aerial ? "from above" : "eye level", double(tolerance));
                print(m.alone);
                std::printf(" %.1f; %.1f |", m.sent.ms(), m.sent.kilobytes());
                print(m.culled);
                std::printf("\n");
                std::fflush(stdout);
            }
        }
    };
    if (only != "tensors") draw("cubes", *built<ColorCube>(scene));
    if (only != "cubes") draw("tensors", *built<OpacityTensor>(scene));
}

}  // namespace

/// The molecule, or the forest, or both; of the forest tensors or cubes, or both.
int main(int argc, char** argv) {
    setenv("LP_NUM_THREADS", "0", /*overwrite=*/0);  // llvmpipe draws on one thread, as all else here does
    const std::string only = argc > 1 ? argv[1] : "";
    if (only != "forest") draw_molecule();
    if (only != "molecule") draw_forest(argc > 2 ? argv[2] : "");
}
