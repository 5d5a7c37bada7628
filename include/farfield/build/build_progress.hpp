// A build says how far it has come, and can be stopped.
#pragma once

#include "farfield/settings.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <stdexcept>

namespace farfield {

enum class BuildPhase : std::uint8_t {
    splitting,  ///< `done` of `total` primitives, or pieces of them, lie in their last cell; there may come more
    sampling,   ///< `done` of `total` groups of cells have been looked at for their stand-ins
    // Of builds outside of memory (build_pages.hpp), which tell of primitives.
    reading,  ///< `total` is not known, and 0
    counting,
    moving,  ///< to where those near them lie
    building
};

struct BuildProgress {
    BuildPhase phase = BuildPhase::splitting;
    std::size_t done = 0, total = 0;
};

/// Gets called on the thread that called build(), some hundred times a phase at most; what it throws ends the build and
/// reaches the caller. Returning false cancels the build.
using ProgressCallback = std::function<bool(const BuildProgress&)>;

/// Thrown by build() where the progress callback returned false. Nothing of the hierarchy is left, and the primitives
/// are as they were.
class BuildCanceled : public std::runtime_error {
  public:
    BuildCanceled() : std::runtime_error("farfield: the build was canceled by its progress callback") {}
};

}  // namespace farfield
