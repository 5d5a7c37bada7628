#include "farfield/approximation/color_cube.hpp"
#include "farfield/cost/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "scenes/placed_scene.hpp"
#include "variants.hpp"

namespace walkthrough {

std::unique_ptr<farfield::scenes::BuiltScene> build_color_cube_shared(const farfield::scenes::Scene& scene) {
    using farfield::SharedOctree;
    using Hierarchy = farfield::SpatialHierarchy<SharedOctree, farfield::ColorCube, farfield::TriangleCount>;
    return std::make_unique<farfield::scenes::PlacedScene<Hierarchy>>(
        scene, [](std::size_t) { return SharedOctree{}; }, farfield::ColorCube{});
}

}  // namespace walkthrough
