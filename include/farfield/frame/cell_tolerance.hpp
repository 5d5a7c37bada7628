// The error that a cell's stand-in may have: the view's tolerance, or a part of it that is the cell's own.
#pragma once

#include "farfield/settings.hpp"

#include <cstdint>

#include "farfield/geometry/mixed.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield::detail {

/// Where a level of detail changes at one distance, all of it changes in one frame of a flight towards something far
/// away: a pop. With thresholds of their own a hundredth of the cells changes in each of a hundred frames, and the
/// change is a tenth of that in the root mean square. A cell keeps its threshold from frame to frame; a fade instead
/// would have to draw both, which for primitives needs renderers that draw a part of their samples.
inline float cell_tolerance(const LocalView& view, std::uint64_t path, std::uint32_t node) {
    if (view.tolerance_jitter == 0) return view.tolerance_px;
    const float part = float(mixed(mixed(path, 0x746f6c), node) >> 40) * 0x1p-24f;
    return view.tolerance_px * (1 - view.tolerance_jitter * part);
}

}  // namespace farfield::detail
