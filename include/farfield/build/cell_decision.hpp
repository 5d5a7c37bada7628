// Whether a cell is split, and which of its children gets what: one question of a build, asked of every cell by itself.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <type_traits>
#include <utility>

#include "farfield/build/build_node.hpp"
#include "farfield/composition.hpp"
#include "farfield/geometry/triangle_box.hpp"
#include "farfield/partition.hpp"
#include "farfield/primitive.hpp"
#include "farfield/primitive_source.hpp"

namespace farfield::detail {

/// What becomes of a cell, given all that lies in it.
struct CellDecision {
    std::array<std::size_t, 8> count{};  ///< items that each child gets
    std::size_t kept = 0;                ///< items of its own run
    float cost = 0;                      ///< of its own run
    std::uint8_t child_mask = 0;         ///< 0: a leaf
    bool would_not_pay = false, too_deep = false, one_place = false, no_memory = false;
};

/// Among the targets: a cell that is split does not hold the item, which other cells have.
inline constexpr std::uint16_t in_other_cells = 1u << 8;

/// Says whether a primitive meets a box, for place().
template <Primitive P>
auto touches_of(const P& asked, [[maybe_unused]] glm::dvec3 origin) {
    // One that a source makes is gone when the question is asked.
    using Kept = std::conditional_t<is_indexed<P>, P, std::reference_wrapper<const P>>;
    return [kept = Kept(asked), origin]([[maybe_unused]] const Box& box) {
        const P& primitive = kept;
        static_cast<void>(primitive), static_cast<void>(origin);  // primitives without polygons
        if constexpr (PrimitiveWithInstance<P>) {
            // An instance may hold more polygons than all the rest of the scene: its bounds have to do.
            if (primitive_traits<P>::visit_instance(primitive, [](const auto&) {})) return true;
        }
        if constexpr (PrimitiveWithPolygons<P>) {
            bool touched = false;
            local_polygons(primitive, origin, [&](const Polygon& polygon) {
                for (std::size_t i = 2; i < polygon.vertices.size() && !touched; ++i) {
                    touched = triangle_touches(box, polygon.vertices[0], polygon.vertices[i - 1], polygon.vertices[i]);
                }
            });
            return touched;
        } else {
            return true;
        }
    };
}

template <class Partition_, class A, class C>
bool split_pays(const A& approximation, const C& cost, float rest_cost, float children) {
    return Partition_::facts.splits_for_order || rest_cost > least_cost_to_split(approximation, cost, children);
}

/// A single child with all the items is progress only if a later split can tell them apart; children that each get
/// nearly all of them (duplicates by the thousand, as large as the cell) are none.
template <bool are_shared>
bool cannot_be_told_apart(std::span<const Item> items, const CellDecision& d, std::uint8_t child_mask) {
    if (std::has_single_bit(child_mask)) {
        const glm::vec3 first = items[0].bounds.center();
        return std::all_of(items.begin(), items.end(), [&](const Item& i) { return i.bounds.center() == first; });
    }
    std::size_t handed_down = 0;
    for (const std::size_t n : d.count) handed_down += n;
    return are_shared && 4 * handed_down > 3 * items.size() * std::size_t(std::popcount(child_mask));
}

/// `targets` says of each item which children get it, by bits, 0 for the cell's own run; of a leaf, nothing that holds.
/// touches(source) is touches_of() of that primitive.
template <class Partition_, class A, class C, class Touches>
CellDecision decide_about_cell(const Partition_& partition, const A& approximation, const C& cost, const Cell& cell,
                               typename Partition_::node_data& data, std::span<const Item> items,
                               std::span<std::uint16_t> targets, Touches&& touches, bool over_budget) {
    constexpr bool are_shared = agreed_assignment<Partition_, A> == Assignment::shared;
    CellDecision d;
    const Split answer = items.empty() ? Split::no : partition.choose(cell, items, data);
    bool splits = answer == Split::yes || answer == Split::always;
    std::uint8_t child_mask = 0;
    float rest_cost = 0, kept_cost = 0;
    std::size_t kept = 0;
    if (splits) {
        struct Emit {
            std::uint16_t& target;
            void operator()(unsigned child) const { target = std::uint16_t(target | 1u << child); }
            void keep() const {}
            void drop() const requires(are_shared) { target = in_other_cells; }
        };
        for (std::size_t i = 0; i < items.size(); ++i) {
            std::uint16_t mask = 0;
            partition.place(cell, std::as_const(data), items[i], touches(items[i].source), Emit{mask});
            targets[i] = mask;
            if (mask == in_other_cells) continue;
            if (mask == 0) {
                ++kept;
                kept_cost += items[i].cost;
                continue;
            }
            rest_cost += items[i].cost;
            if constexpr (are_shared) {
                for (unsigned m = mask; m != 0; m &= m - 1) ++d.count[unsigned(std::countr_zero(m))];
            } else {
                ++d.count[unsigned(std::countr_zero(mask))];
            }
        }
        for (unsigned c = 0; c < 8; ++c) {
            if (d.count[c] != 0) child_mask = std::uint8_t(child_mask | 1u << c);
        }
    }
    if (splits && answer != Split::always) {
        d.would_not_pay = !split_pays<Partition_>(approximation, cost, rest_cost, float(std::popcount(child_mask)));
        d.no_memory = !d.would_not_pay && over_budget;
        splits = !d.would_not_pay && !d.no_memory;
    }
    if (splits && answer != Split::always && cannot_be_told_apart<are_shared>(items, d, child_mask)) {
        d.one_place = true;
        splits = false;
    }
    if (splits && child_mask != 0) {
        d.child_mask = child_mask;
        d.kept = kept;
        d.cost = kept_cost;
    } else {
        d.kept = items.size();
        for (const Item& item : items) d.cost += item.cost;
    }
    if (answer == Split::too_deep) d.too_deep = split_pays<Partition_>(approximation, cost, d.cost, 1);
    if (answer == Split::inseparable) d.one_place = split_pays<Partition_>(approximation, cost, d.cost, 2);
    return d;
}

}  // namespace farfield::detail
