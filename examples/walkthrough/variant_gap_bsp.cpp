#include "farfield/approximation/exact.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/gap_bsp.hpp"
#include "recipe.hpp"

namespace walkthrough {

Recipe gap_bsp() {
    using namespace farfield;
    return recipe<SpatialHierarchy<GapBsp, Exact, TriangleCount>>();
}

}  // namespace walkthrough
