#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/image_cache.hpp"
#include "farfield/cost_model/measured_time.hpp"
#include "farfield/partition/gap_bsp.hpp"
#include "recipe.hpp"

namespace walkthrough {

Recipe image_cache() {
    using namespace farfield;
    return recipe<SpatialHierarchy<GapBsp, ImageCache<Exact>, MeasuredTime>>();
}

}  // namespace walkthrough
