#include "support/variants_of.hpp"

namespace farfield::test {

std::vector<Variant> opacity_tensor_variants() {
    return variants_of("OpacityTensor", static_cast<HierarchiesWith<OpacityTensor>*>(nullptr));
}

}  // namespace farfield::test
