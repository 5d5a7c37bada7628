#include "scenes/renderers/coverage_tilers.hpp"

namespace farfield::detail {

template struct CoverageTiler<CoverageTarget<LazyCoverage>>;
template struct CoverageTiler<CoverageTarget<StrictCoverage>>;

}  // namespace farfield::detail
