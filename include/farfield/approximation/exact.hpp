// No approximation: every primitive in the frustum is drawn. The reference that the others are measured against.
#pragma once

#include "farfield/settings.hpp"

#include "farfield/approximation.hpp"

namespace farfield {

/// Cells are split only where frustum culling pays (see HierarchyBuilder). A subtree inside the frustum is drawn as
/// one run.
struct Exact {
    struct stand_in_data {};
    static constexpr ApproximationFacts facts{.file_tag = 0x45580001u};
};

}  // namespace farfield
