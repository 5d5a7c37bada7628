#include "farfield/approximation/sample_set.hpp"
#include "farfield/approximation/sided_tensor.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "recipe.hpp"

namespace walkthrough {

Recipe sample_tree_sided() {
    using namespace farfield;
    return recipe<SpatialHierarchy<Octree, SampleSet<SidedTensor>, TriangleCount>>();
}

}  // namespace walkthrough
