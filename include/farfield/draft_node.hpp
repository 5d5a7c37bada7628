// A cell between the phases of a build.
#pragma once

#include <cstddef>
#include <cstdint>

#include "farfield/cell.hpp"
#include "farfield/policy.hpp"

namespace farfield::detail {

/// A cell while the hierarchy is built.
template <class NodeData>
struct DraftNode {
    Cell cell;
    NodeData data{};
    std::size_t first = 0, count = 0;  ///< its items in this level's array; of a finished node in kept_
    float cost = 0;                    ///< of its own run, later of its subtree
    std::uint32_t first_child = 0;
    std::uint8_t child_mask = 0;
    Split answer = Split::no;
    bool is_leaf = true;
};

}  // namespace farfield::detail
