// Time against number of primitives: scenes that grow while the picture stays the same.
#pragma once

#include <string>
#include <vector>

#include "options.hpp"
#include "output.hpp"
#include "schedule.hpp"
#include "variants.hpp"

namespace farfield::bench {

/// tree: one tree of ever finer leaves; chessboard: ever smaller squares; quadrupled-forest: ever more trees.
std::vector<std::string> growth_names();

/// Rows of `growth`, at a tolerance of 1 pixel, until all is measured or the run was interrupted. The peer is
/// timed up to a few million triangles; beyond, its rows are extrapolated from the largest that was, and say so.
class GrowthRun {
  public:
    GrowthRun(const Options& options, const std::vector<const AnyVariant*>& variants, Output& output,
              Schedule& schedule)
        : options_(options), variants_(variants), output_(output), schedule_(schedule) {}

    /// How long it may take; to be told to the schedule before anything is measured.
    double guess_seconds(const std::string& series) const;
    void measure(const std::string& series);

  private:
    const Options& options_;
    const std::vector<const AnyVariant*>& variants_;
    Output& output_;
    Schedule& schedule_;
};

}  // namespace farfield::bench
