// The tilers of the ready-made coverage renderers are compiled once, in coverage_tilers.cpp: each is four, for as many
// instruction sets, and takes most of the time of a file that draws with masks. Programs that link to scenes include
// this in place of coverage_renderer.hpp.
#pragma once

#include "farfield/renderer/coverage_renderer.hpp"

namespace farfield::detail {

extern template struct CoverageTiler<CoverageTarget<LazyCoverage>>;
extern template struct CoverageTiler<CoverageTarget<StrictCoverage>>;

}  // namespace farfield::detail
