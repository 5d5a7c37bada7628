#include "support/variants_of.hpp"

namespace farfield::test {

std::vector<Variant> exact_variants() {
    return variants_of("Exact", static_cast<HierarchiesWith<Exact>*>(nullptr));
}

}  // namespace farfield::test
