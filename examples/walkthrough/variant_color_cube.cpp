// The variants that are one type and differ in their options.
#include "farfield/approximation/color_cube.hpp"
#include "farfield/cost/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "scenes/placed_scene.hpp"
#include "variants.hpp"

namespace walkthrough {
namespace {

using farfield::ColorCube;
using farfield::Octree;
using Scene = farfield::scenes::PlacedScene<farfield::SpatialHierarchy<Octree, ColorCube, farfield::TriangleCount>>;

Octree adaptive(std::size_t) {
    return {};
}

/// Surfaces fill four cells of eight. As deep as leaves a cell some ten triangles, the price of a splat: deeper ones
/// have no stand-in that pays.
Octree uniform(std::size_t primitives) {
    Octree octree{.uniform_depth = 1};
    for (std::size_t cells = 4; cells * 10 < primitives; cells *= 4) ++octree.uniform_depth;
    return octree;
}

}  // namespace

std::unique_ptr<farfield::scenes::BuiltScene> build_color_cube(const farfield::scenes::Scene& scene) {
    return std::make_unique<Scene>(scene, adaptive, ColorCube{});
}

std::unique_ptr<farfield::scenes::BuiltScene> build_color_cube_direct(const farfield::scenes::Scene& scene) {
    return std::make_unique<Scene>(scene, adaptive, ColorCube{.inner = ColorCube::Inner::direct});
}

std::unique_ptr<farfield::scenes::BuiltScene> build_color_cube_1995(const farfield::scenes::Scene& scene) {
    return std::make_unique<Scene>(scene, uniform, ColorCube{.opacity = ColorCube::Opacity::thresholded});
}

}  // namespace walkthrough
