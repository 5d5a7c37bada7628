// Who runs a build's independent steps, and who is told how far it has come.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>

#include "farfield/build/build_progress.hpp"
#include "farfield/executor.hpp"
#include "farfield/fail.hpp"
#include "farfield/geometry/box.hpp"
#include "farfield/geometry/cell.hpp"

namespace farfield::detail {

/// What a build may take before no cell is split any more, 0: no limit; and the space that it is made for.
struct BuildBudget {
    std::uint64_t memory_bytes = 0;
    std::uint32_t pieces_per_polygon = 0;
    std::uint64_t free_pieces = std::uint64_t(1) << 19;  ///< beside those
    BoxD world = BoxD::empty();                          ///< beside all that there is
    /// Where a part of a scene is built, the cell that holds it: it is the root, as it would be a node in the whole,
    /// and has the whole's origin. Its primitives have been looked at before.
    const Cell* part = nullptr;
    glm::dvec3 origin_of_part{0};
};

/// Executor and progress callback are borrowed. The callback is called on the thread that builds, between steps.
class BuildControl {
  public:
    BuildControl(const AnyExecutor& executor, const ProgressCallback& progress)
        : executor_(executor), progress_(progress) {}

    /// Throws BuildCanceled if whoever listens wants no more of it.
    void report(BuildPhase phase, std::size_t done, std::size_t total) const {
        if (progress_ && !progress_({phase, done, total})) detail::fail<BuildCanceled>();
    }

    /// Runs f(0) ... f(count - 1), in any order and at once as far as the executor does; reports some hundred times.
    template <class F>
    void run(BuildPhase phase, std::size_t count, F&& f) const {
        run_in_slices(count, f, [&](std::size_t, std::size_t end) { report(phase, end, count); });
    }

    /// Runs f as run() does and calls after_slice(begin, end) instead of reporting.
    template <class F, class AfterSlice>
    void run_in_slices(std::size_t count, F&& f, AfterSlice&& after_slice) const {
        const std::size_t slice = progress_ ? std::max<std::size_t>(count / 100, 8) : std::max<std::size_t>(count, 1);
        for (std::size_t begin = 0; begin < count; begin += slice) {
            run_quietly(std::min(slice, count - begin), [&](std::size_t i) { f(begin + i); });
            after_slice(begin, std::min(begin + slice, count));
        }
    }

    /// Runs f as run() does, without reports: for steps that are too small.
    template <class F>
    void run_quietly(std::size_t count, F&& f) const {
        if (executor_) {
            executor_(count, f);
        } else {
            SerialExecutor()(count, f);
        }
    }

  private:
    const AnyExecutor& executor_;
    const ProgressCallback& progress_;
};

}  // namespace farfield::detail
