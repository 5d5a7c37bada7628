// A build says what it did.
#pragma once

#include "farfield/settings.hpp"

#include <cstdint>

namespace farfield {

/// Counts of what was built, what was refused and what stopped early.
struct BuildReport {
    std::uint64_t primitives = 0;
    std::uint64_t items = 0;  ///< primitives counted once for every cell that has them; of what is cut, fragments
    /// Polygons that a partition was given to cut, and pieces that became of them: pieces / polygons is how much more
    /// there is to draw. 0 where nothing is cut. Instances are neither.
    std::uint64_t polygons = 0, pieces = 0;
    std::uint32_t nodes = 0;  ///< cells that are not empty
    std::uint32_t leaves = 0;
    std::uint32_t levels = 0;
    std::uint32_t empty_cells_pruned = 0;
    std::uint32_t splits_that_would_not_pay = 0;
    std::uint32_t cells_at_depth_limit = 0;  ///< wanted a split, but max_depth or float precision was reached
    std::uint32_t cells_that_cannot_be_told_apart = 0;  ///< wanted a split, but all their items share one center
    std::uint32_t cells_over_memory_budget = 0;         ///< wanted a split, but the memory budget was spent
    std::uint32_t stand_ins = 0;
    std::uint32_t stand_ins_that_would_not_pay = 0;
    std::uint32_t polygons_joined = 0;        ///< with the one before, before anything was cut
    std::uint32_t polygons_without_area = 0;  ///< left out before anything was cut, as they draw nothing
    /// Kept several items that no order suits from everywhere: instances that no plane tells from the rest, or what
    /// came to a limit. Of partitions that cut.
    std::uint32_t cells_out_of_order = 0;
    /// Wanted a split, but BuildOptions::most_pieces_per_polygon was reached: polygons cross one another all over.
    std::uint32_t cells_over_piece_budget = 0;
};

}  // namespace farfield
