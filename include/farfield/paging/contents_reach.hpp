// How far the contents of a cell stick out of it, in a byte that is read without them: what is missing is drawn over
// all that may show it, and the bounds of a loose cell, where contents may lie, have four times the outline of the
// cell.
#pragma once

#include "farfield/settings.hpp"

#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include "farfield/geometry/box.hpp"
#include "farfield/geometry/cell.hpp"

namespace farfield::detail {

/// 1 to 255: from the cell's box to its bounds in equal steps. 0, as files written before have it: the bounds.
///
/// No box is smaller than the cell's: stand-ins below it, whose place the missing one takes, may lie anywhere in there.
/// (Thinner boxes were tried, a third of the cell for what lies in a sheet. They took as long to draw.)
class ContentsReach {
  public:
    constexpr ContentsReach() = default;
    explicit constexpr ContentsReach(std::uint8_t byte) : byte_(byte) {}
    /// The least that holds a box, if the cell's bounds do.
    ContentsReach(const Box& contents, const Cell& cell) {
        unsigned below = 0, enough = 256;
        while (enough - below > 1) {
            const unsigned middle = (below + enough) / 2;
            // With the numbers that box() will have, so that no rounding lets anything out.
            const Box b = ContentsReach(std::uint8_t(middle)).box(cell);
            const bool holds = contents.is_empty() || (b.contains(contents.lower) && b.contains(contents.upper));
            (holds ? enough : below) = middle;
        }
        byte_ = std::uint8_t(enough);  // 256: none
    }
    /// What holds the contents of the cell, and the cell itself.
    Box box(const Cell& cell) const {
        const Box inner = cell.box(), outer = cell.bounds();
        if (byte_ == 0 || byte_ == 255) return outer;
        const float t = float(byte_ - 1) / 254;
        return {glm::max(inner.lower + t * (outer.lower - inner.lower), outer.lower),
                glm::min(inner.upper + t * (outer.upper - inner.upper), outer.upper)};
    }
    std::uint8_t byte() const { return byte_; }

  private:
    std::uint8_t byte_ = 0;
};

}  // namespace farfield::detail
