// A phase of a build: samples of what lies below a cell move up into it (Klein et al. 2002, section 5.2).
//
// Keys are drawn once a primitive, and the m primitives of the least keys are a sample of size m: a race of exponential
// clocks (Efraimidis and Spirakis 2006). Samples of a cell are then samples of its children first, whatever the order
// of moving, and the tree is a function of the contents alone. The paper draws anew at every cell.
#pragma once

#include "farfield/settings.hpp"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "farfield/approximation.hpp"
#include "farfield/build/build_node.hpp"
#include "farfield/build/sample_race.hpp"

namespace farfield::detail {

/// Finds the cell that holds each item once samples have moved. Nodes come parents before children, with items depth
/// first.
template <class A, class BuildNode_>
class MoveUp {
  public:
    /// `order` has the indices of primitives by position.
    MoveUp(const SampleRace<A>& race, std::span<const BuildNode_> nodes, std::span<const std::uint32_t> order)
        : race_(race), nodes_(nodes), order_(order) {}

    void find_samples() {
        lists_.resize(nodes_.size());
        for (std::size_t n = nodes_.size(); n-- > 0;) make_list(n);
        give_to_highest();
    }

    /// Appends the indices of what node n holds now: its sample in the order of its keys, then what never was in one.
    void append_items(std::size_t n, std::vector<std::uint32_t>& out) {
        List& l = lists_[n];
        const std::span<const std::uint32_t> least = list(n);
        for (std::size_t i = 0; i < least.size(); ++i) {
            if (holder_[least[i]] != n) continue;
            out.push_back(least[i]);
            l.sampled += i < l.about.sample;
        }
        for (const std::uint32_t p : order_.subspan(l.first_own, l.own)) {
            if (holder_[p] == no_holder) out.push_back(p);
        }
    }

    /// What moving has left of each node's cell, given the order that append_items() made.
    std::vector<SampledCell> sampled_cells(std::span<const std::uint32_t> moved) const {
        std::vector<LeftOfCell> left(nodes_.size());
        std::vector<SampledCell> out(nodes_.size());
        for (std::size_t n = nodes_.size(); n-- > 0;) {
            left[n] = race_.left_of(nodes_[n].cell, lists_[n].about.area,
                                    moved.subspan(nodes_[n].first_item, nodes_[n].count), lists_[n].sampled,
                                    [&](auto&& take) { for_each_child(n, [&](std::size_t c) { take(left[c]); }); });
            out[n] = left[n].cell;
        }
        return out;
    }

  private:
    static constexpr std::uint32_t no_holder = std::numeric_limits<std::uint32_t>::max();

    struct List {
        std::size_t first = 0;
        std::uint32_t count = 0;
        std::uint32_t sampled = 0;  ///< those of its sample that the node has kept
        /// Positions that the node held before anything moved. Its own fields change while items are put in order.
        std::uint32_t first_own = 0, own = 0;
        SampleList about;
    };

    template <class F>
    void for_each_child(std::size_t n, F&& f) const {
        const BuildNode_& node = nodes_[n];
        for (int c = 0; c < std::popcount(node.child_mask); ++c) f(node.first_child + std::size_t(c));
    }
    std::span<const std::uint32_t> list(std::size_t n) const {
        return std::span(listed_).subspan(lists_[n].first, lists_[n].count);
    }

    void make_list(std::size_t n) {
        const BuildNode_& node = nodes_[n];
        std::array<typename SampleRace<A>::Child, 8> children;
        std::size_t count = 0;
        for_each_child(n, [&](std::size_t child) { children[count++] = {list(child), lists_[child].about}; });
        List& l = lists_[n];
        l.first_own = node.first_item;
        l.own = std::uint32_t(node.count);
        l.about = race_.make_list(
            node.cell, order_.subspan(l.first_own, l.own), {children.data(), count},
            [&](auto&& add) { add(order_.subspan(node.first_item, node.end_item - node.first_item)); }, candidates_);
        l.first = listed_.size();
        l.count = std::uint32_t(candidates_.size());
        listed_.insert(listed_.end(), candidates_.begin(), candidates_.end());
    }

    void give_to_highest() {
        holder_.assign(order_.size(), no_holder);
        for (std::size_t n = 0; n < nodes_.size(); ++n) {
            for (const std::uint32_t p : list(n)) {
                if (holder_[p] == no_holder) holder_[p] = std::uint32_t(n);
            }
        }
    }

    const SampleRace<A>& race_;
    std::span<const BuildNode_> nodes_;
    std::span<const std::uint32_t> order_;

    std::vector<List> lists_;                ///< by node
    std::vector<std::uint32_t> listed_;      ///< primitives
    std::vector<std::uint32_t> candidates_;  ///< of one node
    std::vector<std::uint32_t> holder_;      ///< by primitive: the node whose sample it is in
};

}  // namespace farfield::detail
