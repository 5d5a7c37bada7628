#include "farfield/approximation/exact.hpp"
#include "farfield/cost/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "scenes/placed_scene.hpp"
#include "variants.hpp"

namespace walkthrough {

std::unique_ptr<farfield::scenes::BuiltScene> build_exact(const farfield::scenes::Scene& scene) {
    using Hierarchy = farfield::SpatialHierarchy<farfield::Octree, farfield::Exact, farfield::TriangleCount>;
    return std::make_unique<farfield::scenes::PlacedScene<Hierarchy>>(
        scene, [](std::size_t) { return farfield::Octree{}; }, farfield::Exact{});
}

}  // namespace walkthrough
