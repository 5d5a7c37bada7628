#include "farfield/approximation/exact.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "recipe.hpp"

namespace walkthrough {

Recipe exact() {
    using namespace farfield;
    return recipe<SpatialHierarchy<Octree, Exact, TriangleCount>>();
}

}  // namespace walkthrough
