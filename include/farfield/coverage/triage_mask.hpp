// Triage coverage masks: 8 x 8 subcells of a cell of the screen, each covered, vacant or active (Greene 1996,
// section 3 and figure 1).
#pragma once

#include "farfield/settings.hpp"

#include <cstdint>

namespace farfield {

inline constexpr std::uint64_t no_subcells = 0;
inline constexpr std::uint64_t all_subcells = ~std::uint64_t(0);

/// A subcell is bit 8 * row + column, rows downwards, of at most one of the words; in neither it is active: some of its
/// samples are covered, or that is not known.
struct TriageMask {
    std::uint64_t covered = no_subcells;
    std::uint64_t vacant = all_subcells;

    std::uint64_t active() const { return ~(covered | vacant); }
    friend bool operator==(const TriageMask&, const TriageMask&) = default;
};
static_assert(sizeof(TriageMask) == 16);

/// The subcells of columns [x0, x1] and rows [y0, y1], each 0 to 7, ends included.
inline std::uint64_t subcells_of_rect(int x0, int y0, int x1, int y1) {
    const std::uint64_t columns = ((2u << x1) - (1u << x0)) * 0x0101010101010101u;
    return columns & all_subcells << (8 * y0) & all_subcells >> (56 - 8 * y1);
}

}  // namespace farfield
