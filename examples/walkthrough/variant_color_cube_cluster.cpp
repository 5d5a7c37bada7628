#include "farfield/approximation/color_cube_cluster.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "recipe.hpp"

namespace walkthrough {

Recipe color_cube_cluster() {
    using namespace farfield;
    return recipe<SpatialHierarchy<Octree, ColorCubeCluster<4>, TriangleCount>>();
}

}  // namespace walkthrough
