#include "farfield/approximation/color_cube_cluster.hpp"
#include "farfield/cost/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "scenes/placed_scene.hpp"
#include "variants.hpp"

namespace walkthrough {

std::unique_ptr<farfield::scenes::BuiltScene> build_color_cube_cluster(const farfield::scenes::Scene& scene) {
    using Cluster = farfield::ColorCubeCluster<4>;
    using Hierarchy = farfield::SpatialHierarchy<farfield::Octree, Cluster, farfield::TriangleCount>;
    return std::make_unique<farfield::scenes::PlacedScene<Hierarchy>>(
        scene, [](std::size_t) { return farfield::Octree{}; }, Cluster{});
}

}  // namespace walkthrough
