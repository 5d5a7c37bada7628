// A phase of a build where samples have moved up: nodes go that nothing is gained by.
#pragma once

#include "farfield/settings.hpp"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "farfield/build/build_node.hpp"
#include "farfield/hierarchy/node.hpp"

namespace farfield::detail {

template <class BuildNode_>
class IdleNodes {
  public:
    /// Nodes come parents before children.
    explicit IdleNodes(std::span<BuildNode_> nodes) : nodes_(nodes) {}

    /// Takes away nodes that moving has emptied, and those below which nothing stands in any more and culling does not
    /// pay. Returns their number.
    std::uint32_t drop() {
        std::vector<char> stands_in_below(nodes_.size(), 0);
        for (std::size_t n = nodes_.size(); n-- > 0;) {
            BuildNode_& node = nodes_[n];
            const auto children = nodes_.subspan(node.first_child, std::size_t(std::popcount(node.child_mask)));
            for (std::size_t c = 0; c < children.size(); ++c) {
                const bool stands_in =
                    stands_in_below[node.first_child + c] != 0 || children[c].stand_in != no_stand_in;
                if (stands_in) stands_in_below[n] = 1;
            }
            if (stands_in_below[n] == 0 && node.end_item - node.first_item <= max_items_unculled) {
                drop_descendants(node);
                continue;
            }
            unsigned mask = node.child_mask;
            std::uint32_t first_left = 0;
            for (BuildNode_& child : children) {
                const unsigned bit = mask & (0u - mask);
                mask &= mask - 1;
                if (child.first_item == child.end_item) {
                    drop(child);
                    node.child_mask = std::uint8_t(node.child_mask & ~bit);
                } else if (first_left == 0) {
                    first_left = std::uint32_t(&child - nodes_.data());
                }
            }
            node.first_child = first_left;
        }
        return dropped_;
    }

  private:
    /// The items of a node's descendants follow its own and become its own.
    void drop_descendants(BuildNode_& node) {
        for (std::uint32_t n = node.first_child; node.child_mask != 0; ++n) {
            if (nodes_[n].is_pruned) continue;
            node.child_mask = std::uint8_t(node.child_mask & (node.child_mask - 1));
            drop(nodes_[n]);
        }
        node.first_child = 0;
    }
    void drop(BuildNode_& node) {
        drop_descendants(node);
        node.is_pruned = true;
        ++dropped_;
    }

    std::span<BuildNode_> nodes_;
    std::uint32_t dropped_ = 0;
};

}  // namespace farfield::detail
