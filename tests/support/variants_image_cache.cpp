#include "farfield/approximation/image_cache.hpp"
#include "support/variants_of.hpp"

namespace farfield::test {

std::vector<Variant> image_cache_variants() {
    std::vector<Variant> v =
        variants_of("ImageCache<Exact>",
                    static_cast<std::tuple<SpatialHierarchy<GapBsp, ImageCache<Exact>, MeasuredTime>>*>(nullptr));
    const auto tensors = variants_of(
        "ImageCache<OpacityTensor>",
        static_cast<std::tuple<SpatialHierarchy<GapBsp, ImageCache<OpacityTensor>, MeasuredTime>>*>(nullptr));
    v.insert(v.end(), tensors.begin(), tensors.end());
    return v;
}

}  // namespace farfield::test
