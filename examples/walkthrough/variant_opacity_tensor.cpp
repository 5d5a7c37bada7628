#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "recipe.hpp"

namespace walkthrough {

Recipe opacity_tensor() {
    using namespace farfield;
    return recipe<SpatialHierarchy<Octree, OpacityTensor, TriangleCount>>();
}

}  // namespace walkthrough
