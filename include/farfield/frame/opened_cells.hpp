// Which cells a budget has paid for, and the cut that they make.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "farfield/frame/subtree.hpp"
#include "farfield/geometry/mixed.hpp"
#include "farfield/hierarchy/node.hpp"

namespace farfield::detail {

/// Cells that were opened, by hashes of their places.
class OpenedCells {
  public:
    void clear() {
        for (const std::size_t at : used_) slots_[at] = 0;
        used_.clear();
    }
    void add(std::uint64_t place) {
        if (2 * (used_.size() + 1) > slots_.size()) grow();
        put(place | 1);
    }
    bool has(std::uint64_t place) const {
        if (slots_.empty()) return false;
        for (std::size_t at = place >> shift_;; at = (at + 1) & (slots_.size() - 1)) {
            if (slots_[at] == (place | 1)) return true;
            if (slots_[at] == 0) return false;
        }
    }

  private:
    void put(std::uint64_t key) {
        std::size_t at = key >> shift_;
        while (slots_[at] != 0) at = (at + 1) & (slots_.size() - 1);
        slots_[at] = key;
        used_.push_back(at);
    }
    void grow() {
        std::vector<std::uint64_t> keys;
        for (const std::size_t at : used_) keys.push_back(slots_[at]);
        const std::size_t size = std::max<std::size_t>(1024, 2 * slots_.size());
        slots_.assign(size, 0);
        shift_ = 64 - int(std::bit_width(size - 1));
        used_.clear();
        for (const std::uint64_t key : keys) put(key);
    }

    std::vector<std::uint64_t> slots_{};  ///< a power of two of them, at most half of them used; 0: free
    std::vector<std::size_t> used_{};
    int shift_ = 64;
};

/// The cut that a budget has paid for.
struct WithinBudget {
    static constexpr bool is_limited = true;
    const OpenedCells* opened = nullptr;

    template <class V>
    bool opens(const V& v, const Subtree& subtree) const {
        using A = typename V::hierarchy_type::approximation_type;
        // What has no stand-in belongs to what was opened above it.
        if (A::facts.stands_in && !subtree.has_stand_in()) return true;
        return opened->has(mixed(v.path, subtree.node));
    }
    template <class V>
    static bool may_stop_below(const V&, const Node& node) {
        if (!V::hierarchy_type::approximation_type::facts.stands_in) return true;
        return node.stand_in_levels_below != Node::nothing_below && node.stand_in_levels_below != 0;
    }
};

}  // namespace farfield::detail
