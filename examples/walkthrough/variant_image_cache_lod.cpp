#include "farfield/approximation/image_cache.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/cost_model/measured_time.hpp"
#include "farfield/partition/gap_bsp.hpp"
#include "farfield/partition/octree.hpp"
#include "recipe.hpp"

namespace walkthrough {

Recipe image_cache_lod() {
    using namespace farfield;
    using A = ImageCache<OpacityTensor>;
    // Cells between gaps are long, and few of their tensors are good at several pixels: in what is placed, as trees
    // are, the far field is an octree's.
    return recipe<SpatialHierarchy<GapBsp, A, MeasuredTime>, SpatialHierarchy<Octree, A, MeasuredTime>>();
}

}  // namespace walkthrough
