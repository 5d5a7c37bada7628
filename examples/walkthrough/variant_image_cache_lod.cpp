#include "farfield/approximation/image_cache.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/cost_model/measured_time.hpp"
#include "farfield/partition/gap_bsp.hpp"
#include "recipe.hpp"

namespace walkthrough {

Recipe image_cache_lod() {
    using namespace farfield;
    return recipe<SpatialHierarchy<GapBsp, ImageCache<OpacityTensor>, MeasuredTime>>();
}

}  // namespace walkthrough
