// A phase of a build: samples of what lies below a cell move up into it (Klein et al. 2002, section 5.2).
//
// Keys are drawn once a primitive, and the m primitives of the least keys are a sample of size m: a race of exponential
// clocks (Efraimidis and Spirakis 2006). Samples of a cell are then samples of its children first, whatever the order
// of moving, and the tree is a function of the contents alone. The paper draws anew at every cell.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "farfield/approximation.hpp"
#include "farfield/build/build_control.hpp"
#include "farfield/build/build_node.hpp"
#include "farfield/build/sample_race.hpp"

namespace farfield::detail {

/// Finds the cell that holds each item once samples have moved. Nodes come parents before children, with items depth
/// first.
template <class A, class BuildNode_>
class MoveUp {
  public:
    /// `order` has the indices of primitives by position.
    MoveUp(const SampleRace<A>& race, std::span<const BuildNode_> nodes, std::span<const std::uint32_t> order,
           const BuildControl& control)
        : race_(race), nodes_(nodes), order_(order), control_(control), levels_(levels_of(nodes)) {}

    /// Cells of one level have nothing in common: they are looked at at once, level after level, first bottom up for
    /// the lists of the least keys, then top down for who holds what is in several.
    void find_samples() {
        lists_.resize(nodes_.size());
        holder_.assign(order_.size(), no_holder);
        for (std::size_t level = levels_.size(); level-- > 0;) {
            in_chunks(level, [&](std::size_t begin, std::size_t end, std::vector<std::uint32_t>& kept) {
                std::vector<std::uint32_t> list;
                for (std::size_t n = begin; n < end; ++n) make_list(n, list, kept);
            });
        }
        for (std::size_t level = 0; level < levels_.size(); ++level) {
            in_chunks(level, [&](std::size_t begin, std::size_t end, std::vector<std::uint32_t>& kept) {
                for (std::size_t n = begin; n < end; ++n) hold(n, kept);
            });
        }
    }

    /// The indices of what node n holds now: its sample in the order of its keys, then what never was in one.
    std::span<const std::uint32_t> run(std::size_t n) const { return lists_[n].run.in(buffers_); }

    /// What moving has left of each node's cell.
    std::vector<SampledCell> sampled_cells() const {
        std::vector<LeftOfCell> left(nodes_.size());
        std::vector<SampledCell> out(nodes_.size());
        run_bottom_up(control_, levels_, [&](std::size_t n) {
            left[n] = race_.left_of(nodes_[n].cell, lists_[n].about.area, run(n), lists_[n].sampled, lists_[n].owned,
                                    [&](auto&& take) { for_each_child(n, [&](std::size_t c) { take(left[c]); }); });
            out[n] = left[n].cell;
        });
        return out;
    }

  private:
    static constexpr std::uint32_t no_holder = std::numeric_limits<std::uint32_t>::max();
    using Buffers = std::vector<std::vector<std::uint32_t>>;

    /// Primitives somewhere in the buffers.
    struct Slice {
        std::uint32_t buffer = 0, count = 0;
        std::size_t first = 0;
        std::span<const std::uint32_t> in(const Buffers& buffers) const {
            return std::span(buffers[buffer]).subspan(first, count);
        }
    };
    struct List {
        Slice least, run;
        std::uint32_t sampled = 0;  ///< those of its sample that the node has kept
        std::uint32_t owned = 0;    ///< what it held before
        SampleList about;
    };

    /// Calls f(begin, end, buffer) for parts of a level, each with a buffer of its own.
    template <class F>
    void in_chunks(std::size_t level, F&& f) {
        constexpr std::size_t chunk = 256;
        const std::size_t begin = level == 0 ? 0 : levels_[level - 1], end = levels_[level];
        const std::size_t chunks = (end - begin + chunk - 1) / chunk, first_buffer = buffers_.size();
        buffers_.resize(first_buffer + chunks);
        control_.run_quietly(chunks, [&](std::size_t i) {
            const std::size_t from = begin + i * chunk, to = std::min(from + chunk, end);
            f(from, to, buffers_[first_buffer + i]);
        });
    }
    Slice kept_slice(std::vector<std::uint32_t>& kept, std::size_t first) const {
        return {std::uint32_t(&kept - buffers_.data()), std::uint32_t(kept.size() - first), first};
    }

    template <class F>
    void for_each_child(std::size_t n, F&& f) const {
        const BuildNode_& node = nodes_[n];
        for (int c = 0; c < std::popcount(node.child_mask); ++c) f(node.first_child + std::size_t(c));
    }
    /// Before anything moves.
    std::span<const std::uint32_t> own(const BuildNode_& node) const {
        return order_.subspan(node.first_item, node.count);
    }

    void make_list(std::size_t n, std::vector<std::uint32_t>& list, std::vector<std::uint32_t>& kept) {
        const BuildNode_& node = nodes_[n];
        std::array<typename SampleRace<A>::Child, 8> children;
        std::size_t count = 0;
        for_each_child(n, [&](std::size_t child) {
            children[count++] = {lists_[child].least.in(buffers_), lists_[child].about};
        });
        lists_[n].about = race_.make_list(
            node.cell, own(node), {children.data(), count},
            [&](auto&& add) { add(order_.subspan(node.first_item, node.end_item - node.first_item)); }, list);
        const std::size_t first = kept.size();
        kept.insert(kept.end(), list.begin(), list.end());
        lists_[n].least = kept_slice(kept, first);
    }

    void hold(std::size_t n, std::vector<std::uint32_t>& kept) {
        List& l = lists_[n];
        const std::size_t first = kept.size();
        const std::span<const std::uint32_t> least = l.least.in(buffers_);
        for (std::size_t i = 0; i < least.size(); ++i) {
            if (holder_[least[i]] != no_holder) continue;
            holder_[least[i]] = std::uint32_t(n);
            kept.push_back(least[i]);
            l.sampled += i < l.about.sample;
        }
        for (const std::uint32_t p : own(nodes_[n])) {
            if (holder_[p] == no_holder) kept.push_back(p);
        }
        l.owned = std::uint32_t(own(nodes_[n]).size());
        l.run = kept_slice(kept, first);
    }

    const SampleRace<A>& race_;
    std::span<const BuildNode_> nodes_;
    std::span<const std::uint32_t> order_;
    const BuildControl& control_;
    std::vector<std::size_t> levels_;  ///< where each ends

    std::vector<List> lists_;  ///< by node
    Buffers buffers_;
    std::vector<std::uint32_t> holder_;  ///< by primitive: the node whose sample it is in
};

}  // namespace farfield::detail
