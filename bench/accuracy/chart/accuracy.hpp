// Time against error: every variant at every tolerance, from every distance, in one scene.
#pragma once

#include <string>
#include <vector>

#include "options.hpp"
#include "output.hpp"
#include "schedule.hpp"
#include "variants.hpp"

namespace farfield::bench {

/// Those of the chart in full, as far as the catalog has them. Not the molecule: to build all variants over its five
/// million triangles takes longer than all the rest (--scenes molecule, with a few --variants).
std::vector<std::string> default_scenes();

/// Rows of `accuracy` and pictures, until all is measured or the run was interrupted.
class AccuracyRun {
  public:
    AccuracyRun(const Options& options, const std::vector<const AnyVariant*>& variants, Output& output,
                Schedule& schedule)
        : options_(options), variants_(variants), output_(output), schedule_(schedule) {}

    /// How long it may take; to be told to the schedule before anything is measured.
    double guess_seconds(const std::string& scene) const;
    void measure(const std::string& scene);

  private:
    const Options& options_;
    const std::vector<const AnyVariant*>& variants_;
    Output& output_;
    Schedule& schedule_;
};

}  // namespace farfield::bench
