// The variants that are one type and differ in their options.
#include "farfield/approximation/color_cube.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "recipe.hpp"

namespace walkthrough {
namespace {

using farfield::ColorCube;
using farfield::Octree;
using Hierarchy = farfield::SpatialHierarchy<Octree, ColorCube, farfield::TriangleCount>;

/// Surfaces fill four cells of eight. As deep as leaves a cell some ten triangles, the price of a splat: deeper ones
/// have no stand-in that pays.
Octree uniform(std::size_t primitives) {
    Octree octree{.uniform_depth = 1};
    for (std::size_t cells = 4; cells * 10 < primitives; cells *= 4) ++octree.uniform_depth;
    return octree;
}

}  // namespace

Recipe color_cube() {
    return recipe<Hierarchy>();
}

Recipe color_cube_direct() {
    return recipe<Hierarchy>(ColorCube{.inner = ColorCube::Inner::direct});
}

Recipe color_cube_1995() {
    return recipe<Hierarchy>(uniform, ColorCube{.opacity = ColorCube::Opacity::thresholded});
}

}  // namespace walkthrough
