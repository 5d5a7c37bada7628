#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/approximation/sample_set.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "recipe.hpp"

namespace walkthrough {

Recipe sample_tree() {
    using namespace farfield;
    return recipe<SpatialHierarchy<Octree, SampleSet<OpacityTensor>, TriangleCount>>();
}

Recipe sample_tree_splats() {
    using namespace farfield;
    return recipe<SpatialHierarchy<Octree, SampleSet<AreaSplat>, TriangleCount>>();
}

}  // namespace walkthrough
