#include "farfield/approximation/color_cube.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "recipe.hpp"

namespace walkthrough {

Recipe color_cube_shared() {
    using namespace farfield;
    return recipe<SpatialHierarchy<SharedOctree, ColorCube, TriangleCount>>();
}

}  // namespace walkthrough
