#include "farfield/approximation/exact.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/polygon_bsp.hpp"
#include "recipe.hpp"

namespace walkthrough {

Recipe bsp() {
    using namespace farfield;
    return recipe<SpatialHierarchy<PolygonBsp, Exact, TriangleCount>>();
}

}  // namespace walkthrough
