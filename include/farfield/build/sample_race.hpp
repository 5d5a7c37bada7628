// Which primitives of a cell's subtree are its sample, and what is left of the cell once samples have moved up: what is
// asked of one cell, given its children's answers (Klein et al. 2002, section 5.2).
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "farfield/approximation.hpp"
#include "farfield/geometry/cell.hpp"
#include "farfield/geometry/polygon.hpp"
#include "farfield/primitive.hpp"

namespace farfield::detail {

/// A primitive as its sample sees it.
struct Racer {
    float key = std::numeric_limits<float>::infinity();  ///< infinity: it never moves
    float area = 0;                                      ///< in squares of 1 / SampleRace's scale

    bool moves() const { return key < std::numeric_limits<float>::infinity(); }
};

/// What a cell's parent asks about its list of the least keys in its subtree.
struct SampleList {
    double area = 0;           ///< of all that lies in the subtree
    std::uint32_t sample = 0;  ///< how many of the list are the cell's sample, the first: all of an inner cell's
    bool is_all = true;        ///< the list has all of the subtree that may move
};

/// Sums over a subtree after moving, and what an approximation is told of its cell.
struct LeftOfCell {
    double area = 0;
    SampledCell cell;
};

/// Instances stay where they are: a cell further up would draw all that is in them. An instance's area is that of its
/// stand-in.
template <class A, Primitive P>
Racer racer_of(const A& approximation, const P& primitive, std::uint32_t index, glm::dvec3 origin, float scale) {
    double doubled = 0;
    local_polygons(primitive, origin, [&](const Polygon& polygon) {
        doubled += double(glm::length(
            doubled_area<float>(polygon.vertices.size(), [&](std::size_t i) { return polygon.vertices[i] * scale; })));
    });
    Racer racer{.area = float(0.5 * doubled)};
    bool is_instance = false;
    if constexpr (PrimitiveWithInstance<P>) {
        is_instance = primitive_traits<P>::visit_instance(primitive, [](const auto&) {});
    }
    if (racer.area > 0 && !is_instance) racer.key = approximation.sample_key(index, double(racer.area));
    return racer;
}

/// Racers are by the index of the primitive, and so are all lists.
template <class A>
class SampleRace {
  public:
    SampleRace(const A& approximation, std::span<const Racer> racers, float scale)
        : approximation_(&approximation), racers_(racers), scale_(scale) {}

    const Racer& operator[](std::uint32_t primitive) const { return racers_[primitive]; }

    bool wins(std::uint32_t a, std::uint32_t b) const {
        return racers_[a].key != racers_[b].key ? racers_[a].key < racers_[b].key : a < b;
    }
    /// Whether a primitive of the subtree that a list was made of is in the list.
    bool is_in(std::span<const std::uint32_t> list, std::uint32_t primitive) const {
        return racers_[primitive].moves() && !list.empty() && !wins(list.back(), primitive);
    }

    struct Child {
        std::span<const std::uint32_t> list;
        SampleList about;
    };

    /// Makes `list` that of the least keys in a cell's subtree, ascending: all of a leaf's that have one, else as many
    /// as its sample asks for. `own` is what the cell holds before anything moves; visit_all(f) calls f(run) with all
    /// runs of the subtree.
    template <class VisitAll>
    SampleList make_list(const Cell& cell, std::span<const std::uint32_t> own, std::span<const Child> children,
                         VisitAll&& visit_all, std::vector<std::uint32_t>& list) const {
        SampleList out;
        list.clear();
        const auto add = [&](std::span<const std::uint32_t> run) {
            for (const std::uint32_t p : run) {
                if (racers_[p].moves()) list.push_back(p);
            }
        };
        add(own);
        for (const std::uint32_t p : own) out.area += double(racers_[p].area);
        for (const Child& child : children) {
            out.area += child.about.area;
            list.insert(list.end(), child.list.begin(), child.list.end());
            out.is_all = out.is_all && child.about.is_all;
        }
        const std::size_t wanted = approximation_->sample_size(per_side(cell, out.area));
        const std::size_t count = children.empty() ? list.size() : wanted;
        choose(count, list);
        if (!out.is_all && some_child_is_short(count, list, children)) {
            // A child's whole list is among the least keys but the last, and so may be what its list left out.
            list.clear();
            visit_all(add);
            out.is_all = true;
            choose(count, list);
        }
        out.is_all = out.is_all && list.size() <= count;
        list.resize(std::min(count, list.size()));
        out.sample = std::uint32_t(std::min(list.size(), wanted));
        return out;
    }

    /// `run` is what the cell holds after moving; the first `sample` of it are of its sample; `owned` lay in the cell
    /// itself before. Calls visit_children(f) for f(LeftOfCell of each child).
    template <class VisitChildren>
    LeftOfCell left_of(const Cell& cell, double whole_area, std::span<const std::uint32_t> run, std::uint32_t sample,
                       std::size_t owned, VisitChildren&& visit_children) const {
        LeftOfCell out;
        out.cell.is_in_children = owned == 0;
        double sample_area = 0;
        for (const std::uint32_t p : run.first(sample)) sample_area += double(racers_[p].area);
        out.cell.sample_size = sample;
        out.cell.items = std::uint32_t(run.size());
        for (const std::uint32_t p : run) {
            out.area += double(racers_[p].area);
            out.cell.fixed += !racers_[p].moves();
        }
        visit_children([&](const LeftOfCell& child) {
            out.area += child.area;
            out.cell.items += child.cell.items;
            out.cell.fixed += child.cell.fixed;
            out.cell.is_in_children = out.cell.is_in_children && child.cell.items != 0;
        });
        if (!(whole_area > 0)) return out;
        out.cell.areas_per_side = float(per_side(cell, whole_area));
        out.cell.left = float(std::min(out.area / whole_area, 1.0));  // sums were rounded in different orders
        out.cell.sample = std::min(float(sample_area / whole_area), out.cell.left);
        return out;
    }

  private:
    /// An area in squares of the cell's side.
    double per_side(const Cell& cell, double area) const {
        const double side = double(cell.largest_side()) * double(scale_);
        return side > 0 ? area / (side * side) : 0;
    }

    /// Puts the least `count` first, in order; what follows may be anything. A key and its index are one number that
    /// has the same order, so that racers are looked up once each, and not in every comparison.
    void choose(std::size_t count, std::vector<std::uint32_t>& list) const {
        thread_local std::vector<std::uint64_t> keyed;
        keyed.resize(list.size());
        // Positive, or 0 of either sign.
        const auto key_of = [&](std::uint32_t p) {
            return std::uint64_t(std::bit_cast<std::uint32_t>(racers_[p].key + 0.0f)) << 32 | p;
        };
        const auto write_back = [&](std::size_t n) {
            std::transform(keyed.begin(), keyed.begin() + std::ptrdiff_t(n), list.begin(),
                           [](std::uint64_t k) { return std::uint32_t(k); });
        };
        constexpr std::size_t few = 32;
        if (count <= few) {
            // Most of a list that has more is refused by one comparison.
            std::size_t chosen = 0;
            for (const std::uint32_t p : list) {
                const std::uint64_t key = key_of(p);
                if (chosen == count) {
                    if (count == 0 || key > keyed[count - 1]) continue;
                    --chosen;
                }
                std::size_t at = chosen++;
                for (; at > 0 && keyed[at - 1] > key; --at) keyed[at] = keyed[at - 1];
                keyed[at] = key;
            }
            return write_back(chosen);
        }
        std::transform(list.begin(), list.end(), keyed.begin(), key_of);
        const auto middle = keyed.begin() + std::ptrdiff_t(std::min(count, keyed.size()));
        if (middle != keyed.end()) std::nth_element(keyed.begin(), middle, keyed.end());
        std::sort(keyed.begin(), middle);
        write_back(keyed.size());
    }

    bool some_child_is_short(std::size_t count, std::span<const std::uint32_t> list,
                             std::span<const Child> children) const {
        if (count == 0 || list.empty()) return false;
        const bool needs_more = list.size() < count;
        const std::uint32_t last = list[std::min(count, list.size()) - 1];
        return std::any_of(children.begin(), children.end(), [&](const Child& child) {
            return !child.about.is_all && !child.list.empty() && (needs_more || wins(child.list.back(), last));
        });
    }

    const A* approximation_;
    std::span<const Racer> racers_;
    float scale_;
};

}  // namespace farfield::detail
