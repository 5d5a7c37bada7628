#include "support/variants_of.hpp"

namespace farfield::test {

std::vector<Variant> color_cube_variants() {
    return variants_of("ColorCube", static_cast<HierarchiesWith<ColorCube>*>(nullptr));
}

}  // namespace farfield::test
