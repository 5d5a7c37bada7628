#include "support/variants_of.hpp"

namespace farfield::test {

std::vector<Variant> sample_set_variants() {
    std::vector<Variant> v =
        variants_of("SampleSet<AreaSplat>", static_cast<HierarchiesWith<SampleSet<AreaSplat>>*>(nullptr));
    const auto tensors =
        variants_of("SampleSet<OpacityTensor>", static_cast<HierarchiesWith<SampleSet<OpacityTensor>>*>(nullptr));
    v.insert(v.end(), tensors.begin(), tensors.end());
    return v;
}

}  // namespace farfield::test
