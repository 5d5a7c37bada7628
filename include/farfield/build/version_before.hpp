// Parts of a hierarchy's arrays, copied into another hierarchy's.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "farfield/hierarchy/hierarchy_data.hpp"
#include "farfield/hierarchy/node.hpp"

namespace farfield::detail {

template <class Arrays, class Data>
class VersionBefore {
    static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

  public:
    explicit VersionBefore(const Arrays& arrays) : before_(arrays) {}

    struct Subtree {
        std::uint32_t node = none, end_item = 0;
        bool exists() const { return node != none; }
    };
    Subtree whole() const {
        if (before_.nodes.empty()) return {};
        return {0, std::uint32_t(before_.order.size())};
    }
    Subtree child(const Subtree& parent, unsigned c) const {
        if (!parent.exists() || (before_.nodes[parent.node].child_mask >> c & 1) == 0) return {};
        const Node& node = before_.nodes[parent.node];
        const auto rank = std::uint32_t(std::popcount(node.child_mask & ((1u << c) - 1)));
        Subtree child{node.first_child + rank, parent.end_item};
        if ((node.child_mask >> c) > 1) child.end_item = before_.nodes[child.node + 1].first_item;
        return child;
    }

    /// Node `at` of `data` becomes the subtree's; all that lies in it and below is appended. Its own stand-in, which
    /// lies with those of its siblings, is not.
    void copy(const Subtree& old, bool has_stand_in, std::uint32_t at, Data& data) const {
        const Node& top = before_.nodes[old.node];
        const auto below =
            top.child_mask == 0
                ? std::span<const Node>()
                : before_.nodes.subspan(top.first_child, end_of_nodes_below(before_.nodes, old.node) - top.first_child);
        // Stand-ins below lie in one piece too, but in another order than nodes.
        std::uint32_t first_stand_in = none, stand_ins = 0;
        const auto look_at = [&](const Node& node) {
            if (node.stand_in_mask == 0) return;
            first_stand_in = std::min(first_stand_in, node.first_child_data);
            stand_ins += std::uint32_t(std::popcount(node.stand_in_mask));
        };
        look_at(top);
        for (const Node& node : below) look_at(node);
        const auto nodes_by = std::uint32_t(data.nodes.size()) - top.first_child,
                   items_by = std::uint32_t(data.order.size()) - top.first_item,
                   stand_ins_by = std::uint32_t(data.stand_ins.size()) - first_stand_in;
        const auto moved = [&](Node node) {
            if (node.child_mask != 0) node.first_child += nodes_by;
            node.first_item += items_by;
            if (node.stand_in_mask != 0) node.first_child_data += stand_ins_by;
            return node;
        };
        data.nodes[at] = moved(top);
        // Its own stand-in counts where there are none below, and its parent may have taken it away.
        std::uint8_t& levels = data.nodes[at].stand_in_levels_below;
        if (levels == 0 || levels == Node::nothing_below) levels = has_stand_in ? 0 : Node::nothing_below;
        for (const Node& node : below) data.nodes.push_back(moved(node));
        if (stand_ins != 0) {
            const auto from = before_.stand_ins.begin() + first_stand_in;
            data.stand_ins.insert(data.stand_ins.end(), from, from + stand_ins);
        }
        const auto from = before_.order.begin() + top.first_item;
        data.order.insert(data.order.end(), from, from + (old.end_item - top.first_item));
    }

  private:
    Arrays before_;
};

}  // namespace farfield::detail
