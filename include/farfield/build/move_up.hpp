// A phase of a build: samples of what lies below a cell move up into it (Klein et al. 2002, section 5.2).
//
// Keys are drawn once a primitive, and the m primitives of the least keys are a sample of size m: a race of exponential
// clocks (Efraimidis and Spirakis 2006). Samples of a cell are then samples of its children first, whatever the order
// of moving, and the tree is a function of the contents alone. The paper draws anew at every cell.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "farfield/approximation.hpp"
#include "farfield/build/build_node.hpp"

namespace farfield::detail {

/// Finds the cell that holds each item once samples have moved. Nodes come parents before children, with items depth
/// first.
template <class A, class BuildNode_>
class MoveUp {
  public:
    /// Indices of primitives, their keys and their areas are by position; areas are in squares of 1 / `scale`.
    MoveUp(const A& approximation, std::span<const BuildNode_> nodes, std::span<const std::uint32_t> order,
           std::span<const float> keys, std::span<const float> areas, float scale)
        : approximation_(approximation), nodes_(nodes), order_(order), keys_(keys), areas_(areas), scale_(scale) {}

    void find_samples() {
        lists_.resize(nodes_.size());
        cells_area_.assign(nodes_.size(), 0);
        for (std::size_t n = nodes_.size(); n-- > 0;) make_list(n);
        give_to_highest();
    }

    /// Appends the indices of what node n holds now: its sample in the order of its keys, then what never was in one.
    void append_items(std::size_t n, std::vector<std::uint32_t>& out) const {
        for_each_own(n, [&](std::uint32_t at) { out.push_back(order_[at]); });
    }

    /// What moving has left of each node's cell.
    std::vector<SampledCell> sampled_cells() const {
        std::vector<double> left(nodes_.size(), 0);
        std::vector<SampledCell> out(nodes_.size());
        for (std::size_t n = nodes_.size(); n-- > 0;) {
            double sample = 0;
            for (const std::uint32_t at : list(n).first(lists_[n].sample)) {
                if (holder_[at] != n) continue;
                sample += double(areas_[at]);
                ++out[n].sample_size;
            }
            for_each_own(n, [&](std::uint32_t at) {
                left[n] += double(areas_[at]);
                ++out[n].items;
                out[n].fixed += !(keys_[at] < std::numeric_limits<float>::infinity());
            });
            for_each_child(n, [&](std::size_t child) {
                left[n] += left[child];
                out[n].items += out[child].items;
                out[n].fixed += out[child].fixed;
            });
            const double all = cells_area_[n];
            if (!(all > 0)) continue;
            out[n].areas_per_side = float(per_side(n, all));
            out[n].left = float(std::min(left[n] / all, 1.0));  // sums were rounded in different orders
            out[n].sample = std::min(float(sample / all), out[n].left);
        }
        return out;
    }

  private:
    static constexpr std::uint32_t no_holder = std::numeric_limits<std::uint32_t>::max();

    struct List {
        std::size_t first = 0;
        std::uint32_t count = 0;
        std::uint32_t sample = 0;  ///< the first of them: all of an inner node's
        /// Positions that the node held before anything moved. Its own fields change while items are put in order.
        std::uint32_t first_own = 0, own = 0;
        bool is_all = false;  ///< it holds all of the subtree that may move
    };

    /// An area in squares of the cell's side.
    double per_side(std::size_t n, double area) const {
        const double side = double(nodes_[n].cell.largest_side()) * double(scale_);
        return side > 0 ? area / (side * side) : 0;
    }
    template <class F>
    void for_each_child(std::size_t n, F&& f) const {
        const BuildNode_& node = nodes_[n];
        for (int c = 0; c < std::popcount(node.child_mask); ++c) f(node.first_child + std::size_t(c));
    }
    /// Positions of what node n holds, its sample first.
    template <class F>
    void for_each_own(std::size_t n, F&& f) const {
        for (const std::uint32_t at : list(n)) {
            if (holder_[at] == n) f(at);
        }
        const List& l = lists_[n];
        for (std::uint32_t at = l.first_own; at < l.first_own + l.own; ++at) {
            if (holder_[at] == no_holder) f(at);
        }
    }
    std::span<const std::uint32_t> list(std::size_t n) const {
        return std::span(listed_).subspan(lists_[n].first, lists_[n].count);
    }
    bool wins(std::uint32_t a, std::uint32_t b) const {
        return keys_[a] != keys_[b] ? keys_[a] < keys_[b] : order_[a] < order_[b];
    }

    /// Positions of the least keys in node n's subtree, ascending: all of a leaf's that have one, else as many as its
    /// sample asks for.
    void make_list(std::size_t n) {
        const BuildNode_& node = nodes_[n];
        candidates_.clear();
        add_candidates(node.first_item, node.first_item + std::uint32_t(node.count));
        double area = 0;
        for (std::uint32_t at = node.first_item; at < node.first_item + node.count; ++at) area += double(areas_[at]);
        bool is_all = true;
        for_each_child(n, [&](std::size_t child) {
            area += cells_area_[child];
            const auto below = list(child);
            candidates_.insert(candidates_.end(), below.begin(), below.end());
            is_all = is_all && lists_[child].is_all;
        });
        cells_area_[n] = area;
        const std::size_t wanted = approximation_.sample_size(per_side(n, area));
        std::size_t count = node.child_mask != 0 ? wanted : candidates_.size();
        choose(count);
        if (!is_all && some_child_is_short(n, count)) {
            // A child's whole list is among the least keys, and so may be what its list left out.
            candidates_.clear();
            add_candidates(node.first_item, node.end_item);
            is_all = true;
            choose(count);
        }
        is_all = is_all && candidates_.size() <= count;
        count = std::min(count, candidates_.size());
        lists_[n] = {.first = listed_.size(),
                     .count = std::uint32_t(count),
                     .sample = std::uint32_t(std::min(count, wanted)),
                     .first_own = node.first_item,
                     .own = std::uint32_t(node.count),
                     .is_all = is_all};
        listed_.insert(listed_.end(), candidates_.begin(), candidates_.begin() + std::ptrdiff_t(count));
    }

    void add_candidates(std::uint32_t first, std::uint32_t end) {
        for (std::uint32_t at = first; at < end; ++at) {
            if (keys_[at] < std::numeric_limits<float>::infinity()) candidates_.push_back(at);
        }
    }

    /// Puts the least `count` first, in order.
    void choose(std::size_t count) {
        const auto by_key = [this](std::uint32_t a, std::uint32_t b) { return wins(a, b); };
        const auto middle = candidates_.begin() + std::ptrdiff_t(std::min(count, candidates_.size()));
        if (middle != candidates_.end()) std::nth_element(candidates_.begin(), middle, candidates_.end(), by_key);
        std::sort(candidates_.begin(), middle, by_key);
    }

    bool some_child_is_short(std::size_t n, std::size_t count) const {
        if (count == 0 || candidates_.empty()) return false;
        const bool takes_all = candidates_.size() <= count;
        const std::uint32_t last = candidates_[std::min(count, candidates_.size()) - 1];
        bool is_short = false;
        for_each_child(n, [&](std::size_t child) {
            if (lists_[child].is_all || lists_[child].count == 0) return;
            is_short = is_short || takes_all || !wins(last, list(child).back());
        });
        return is_short;
    }

    void give_to_highest() {
        holder_.assign(order_.size(), no_holder);
        for (std::size_t n = 0; n < nodes_.size(); ++n) {
            for (const std::uint32_t at : list(n)) {
                if (holder_[at] == no_holder) holder_[at] = std::uint32_t(n);
            }
        }
    }

    const A& approximation_;
    std::span<const BuildNode_> nodes_;
    std::span<const std::uint32_t> order_;
    std::span<const float> keys_, areas_;
    float scale_;

    std::vector<double> cells_area_;         ///< of all in a node's subtree
    std::vector<List> lists_;                ///< by node
    std::vector<std::uint32_t> listed_;      ///< positions
    std::vector<std::uint32_t> candidates_;  ///< of one node
    std::vector<std::uint32_t> holder_;      ///< by position: the node whose sample it is in
};

}  // namespace farfield::detail
