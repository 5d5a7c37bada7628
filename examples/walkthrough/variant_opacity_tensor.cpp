#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/cost/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "scenes/placed_scene.hpp"
#include "variants.hpp"

namespace walkthrough {

std::unique_ptr<farfield::scenes::BuiltScene> build_opacity_tensor(const farfield::scenes::Scene& scene) {
    using farfield::OpacityTensor;
    using Hierarchy = farfield::SpatialHierarchy<farfield::Octree, OpacityTensor, farfield::TriangleCount>;
    return std::make_unique<farfield::scenes::PlacedScene<Hierarchy>>(
        scene, [](std::size_t) { return farfield::Octree{}; }, OpacityTensor{});
}

}  // namespace walkthrough
