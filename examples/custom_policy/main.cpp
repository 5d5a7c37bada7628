// Policies of your own, composed with each other and with the library's: eight hierarchies over one scene, each drawn
// and compared with drawing everything. Exits with 1 if one of them is wrong.
#include <cmath>
#include <cstdio>
#include <span>
#include <vector>

#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/measure/coverage_error.hpp"
#include "farfield/measure/image_error.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "mean_color_box.hpp"
#include "median_split.hpp"
#include "triangle_energy.hpp"

using namespace farfield;

namespace {

/// Leaves all over a ball, one triangle each.
std::vector<Triangle> leaves() {
    std::vector<Triangle> result;
    constexpr int count = 60'000;
    for (int i = 0; i < count; ++i) {
        const float depth = 0.5f + 0.5f * float(i * 7 % 10) / 9;
        const float y = 2 * float(i) / count - 1, radius = std::sqrt(1 - y * y), angle = 2.39996f * float(i);
        const glm::vec3 at = depth * glm::vec3(radius * std::cos(angle), y, radius * std::sin(angle));
        const float turn = float(i * 13 % 1009);
        const glm::vec3 along(0.03f * std::sin(turn), -0.01f, 0.03f * std::cos(turn)), across(0.01f, 0.03f, 0);
        result.push_back({{at, at + along, at + across}, {60, std::uint8_t(110 + 12 * (i % 10)), 50}});
    }
    return result;
}

/// Far enough for leaves to be smaller than pixels.
View far_view() {
    return {.camera = Camera::perspective({20, 15, 35}, {0, 0, 0}, {0, 1, 0}, 0.4f), .width = 160, .height = 120};
}

struct Drawn {
    FrameStats stats;
    Image image;
};

template <class H>
Drawn draw(const H& hierarchy, const std::vector<Triangle>& triangles, int samples) {
    ZBufferRenderer renderer({.samples = samples, .light = {}});
    auto viewer = make_viewer(hierarchy, triangles, renderer);
    Drawn drawn{viewer.frame(far_view()), {}};
    drawn.image = renderer.image();
    return drawn;
}

template <class P, class A, class C>
auto hierarchy_of(const std::vector<Triangle>& triangles) {
    static_assert(Composable<P, A, C>);
    return build<SpatialHierarchy<P, A, C>>(triangles);
}

template <class P, class A, class C>
bool good(const char* name, const std::vector<Triangle>& triangles, const Image& reference) {
    const auto hierarchy = hierarchy_of<P, A, C>(triangles);
    const Drawn drawn = draw(hierarchy, triangles, 1);
    const double error = std::sqrt(mse(drawn.image, reference)), bias = coverage_error(drawn.image, reference).bias;
    std::printf("%-40s %7zu bytes  %6llu triangles and %5llu stand-ins drawn  rmse %.4f  coverage %+5.1f %%\n", name,
                hierarchy.bytes(), static_cast<unsigned long long>(drawn.stats.primitives),
                static_cast<unsigned long long>(drawn.stats.approximations), error, 100 * bias);
    return drawn.stats.approximations > 0 && drawn.stats.primitives < triangles.size() / 2 && error < 0.05 &&
           std::abs(bias) < 0.25;
}

}  // namespace

int main() {
    const std::vector<Triangle> triangles = leaves();
    const auto everything = hierarchy_of<Octree, Exact, TriangleCount>(triangles);
    const Image reference = draw(everything, triangles, 64).image;

    bool all = true;
    all &= good<Octree, ColorCube, TriangleCount>("Octree, ColorCube, TriangleCount", triangles, reference);
    all &= good<Octree, ColorCube, TriangleEnergy>("Octree, ColorCube, TriangleEnergy", triangles, reference);
    all &= good<Octree, MeanColorBox, TriangleCount>("Octree, MeanColorBox, TriangleCount", triangles, reference);
    all &= good<Octree, MeanColorBox, TriangleEnergy>("Octree, MeanColorBox, TriangleEnergy", triangles, reference);
    all &= good<MedianSplit, ColorCube, TriangleCount>("MedianSplit, ColorCube, TriangleCount", triangles, reference);
    all &= good<MedianSplit, ColorCube, TriangleEnergy>("MedianSplit, ColorCube, TriangleEnergy", triangles, reference);
    all &= good<MedianSplit, MeanColorBox, TriangleCount>("MedianSplit, MeanColorBox, TriangleCount", triangles,
                                                          reference);
    all &= good<MedianSplit, MeanColorBox, TriangleEnergy>("MedianSplit, MeanColorBox, TriangleEnergy", triangles,
                                                           reference);

    // However space is divided, drawing everything gives the same picture to the last bit.
    const auto divided_otherwise = hierarchy_of<MedianSplit, Exact, TriangleEnergy>(triangles);
    if (draw(divided_otherwise, triangles, 1).image != draw(everything, triangles, 1).image) {
        std::puts("wrong: MedianSplit loses or adds triangles");
        all = false;
    }
    if (!all) std::puts("wrong: a picture is too far from the reference, or nothing stands in");
    return all ? 0 : 1;
}
