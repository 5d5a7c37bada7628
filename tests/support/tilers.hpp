// Tilers of coverage masks are compiled once, in tilers.cpp: each is four, for as many instruction sets. Files that
// draw with the ready-made renderers include this.
#pragma once

#include "farfield/renderer/coverage_renderer.hpp"

namespace farfield::detail {

extern template struct CoverageTiler<CoverageTarget<LazyCoverage>>;
extern template struct CoverageTiler<CoverageTarget<StrictCoverage>>;

}  // namespace farfield::detail
