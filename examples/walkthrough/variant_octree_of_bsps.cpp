#include "farfield/approximation/exact.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/nested.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/partition/polygon_bsp.hpp"
#include "recipe.hpp"

namespace walkthrough {

Recipe octree_of_bsps() {
    using namespace farfield;
    return recipe<SpatialHierarchy<Nested<Octree, PolygonBsp>, Exact, TriangleCount>>();
}

}  // namespace walkthrough
