#include "support/variants_of.hpp"

namespace farfield::test {

std::vector<Variant> cluster_of_four_variants() {
    return variants_of("ColorCubeCluster<4>", static_cast<HierarchiesWith<ColorCubeCluster<4>>*>(nullptr));
}

}  // namespace farfield::test
