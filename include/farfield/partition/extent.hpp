// What things take up along a line, their ends, and counts of these.
#pragma once

#include "farfield/settings.hpp"

#include <cstdint>

namespace farfield::detail {

/// A thing lies from `lower` to `upper`.
struct Extent {
    float lower = 0, upper = 0;
    float weight = 0;     ///< its share in the balance
    bool blocks = false;  ///< no plane may cross it
};

/// Where a thing begins or ends.
struct EndOfExtent {
    float at, weight;
    bool blocks, is_flat;  ///< flat: it begins where it ends
};

/// Things that have begun, or ended, so far.
struct CountedEnds {
    double weight = 0;
    std::uint32_t things = 0, blocking = 0;

    void add(const EndOfExtent& end) {
        weight += double(end.weight);
        ++things;
        blocking += end.blocks;
    }
    void add(const CountedEnds& other) {
        weight += other.weight;
        things += other.things;
        blocking += other.blocking;
    }
};

}  // namespace farfield::detail
