#include "support/variants_of.hpp"

namespace farfield::test {

std::vector<Variant> cluster_of_two_variants() {
    return variants_of("ColorCubeCluster<2>", static_cast<HierarchiesWith<ColorCubeCluster<2>>*>(nullptr));
}

}  // namespace farfield::test
