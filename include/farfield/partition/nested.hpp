// One partition in the leaves of another: "an octree of BSP trees" (Greene 1996, section 5.1).
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <span>
#include <type_traits>

#include "farfield/partition.hpp"

namespace farfield {

template <class T>
concept OctantsWithoutData = PlacesItems<T> && T::facts.children_are_octants&& std::is_empty_v<typename T::node_data>;

/// Outer's cubes are cut at their median planes while they hold more than `largest_leaf` items of which at most half
/// are cut: items as large as their cube would be cut forever. Inner divides each of the cubes that are left. Polygons
/// in a median plane go to its upper side, which keeps Inner's order strict: a viewer on that side sees them before the
/// lower side, and a viewer on the lower side sees them after it.
template <OctantsWithoutData Outer, CutsItems Inner>
struct Nested {
    Outer outer{};
    Inner inner{};
    /// A cube of at most this many items is left to Inner.
    std::uint32_t largest_leaf = 1024;

    struct node_data {
        typename Inner::node_data inner;
        std::uint32_t is_inner;
    };
    static constexpr PartitionFacts facts{.offers = Assignment::clipped,
                                          .ordering = Inner::facts.ordering,
                                          .splits_for_order = true,
                                          .file_tag = Inner::facts.file_tag ^ (Outer::facts.file_tag << 8 | 0x4e)};

    const char* wrong_option() const {
        if (largest_leaf == 0) return "Nested: largest_leaf must be 1 or more";
        if (const char* why = detail::wrong_option(outer)) return why;
        return detail::wrong_option(inner);
    }

    Cell root(const Box& bounds) const { return bounds.is_empty() ? Cell{} : tight(outer.root(bounds)); }

    Split choose(const Cell& cell, const ClippedItems& items, node_data& data) const {
        data.is_inner = cell.partition_state != 0 || !may_halve(cell, items);
        return data.is_inner ? inner.choose(inner_cell(cell), items, data.inner) : Split::always;
    }

    Cuts cuts(const Cell& cell, const node_data& data) const {
        if (data.is_inner) return inner.cuts(cell, data.inner);
        Cuts median{{}, 3, 8};
        for (unsigned axis = 0; axis < 3; ++axis) median.planes[axis].normal[int(axis)] = 1;
        return median;
    }
    unsigned child_at(const node_data& data, const Sides& sides) const {
        if (data.is_inner) return inner.child_at(data.inner, sides);
        unsigned octant = 0;
        for (unsigned axis = 0; axis < 3; ++axis) octant |= unsigned(sides[axis] != Side::behind) << axis;
        return octant;
    }
    void fit(const Cell& cell, node_data& data, std::span<const Box> children) const {
        if (data.is_inner) inner.fit(cell, data.inner, children);
    }

    Cell child(const Cell& parent, const node_data& data, unsigned i) const {
        if (!data.is_inner) return tight(outer.child(parent, {}, i));
        Cell cell = inner.child(inner_cell(parent), data.inner, i);
        ++cell.partition_state;
        return cell;
    }

    void front_to_back(const Cell& cell, const node_data& data, glm::vec4 viewpoint, ChildOrder& order) const {
        if (data.is_inner) {
            inner.front_to_back(cell, data.inner, viewpoint, order);
        } else {
            outer.front_to_back(cell, {}, viewpoint, order);
        }
    }

    bool is_sound(const node_data& data) const { return data.is_inner <= 1 && inner.is_sound(data.inner); }

  private:
    /// A state of 0 means a cell of Outer or the first one of Inner; others are Inner's own state and 1.
    static Cell inner_cell(Cell cell) {
        if (cell.partition_state != 0) --cell.partition_state;
        return cell;
    }

    /// Nothing sticks out of a cube by more than the steps of single precision, by one of which its center may be off
    /// for every level.
    static Cell tight(Cell cube) {
        cube.bounds_center = cube.center;
        cube.bounds_half = cube.half + (glm::abs(cube.center) + cube.half) * 0x1p-19f;
        return cube;
    }

    bool may_halve(const Cell& cell, const ClippedItems& items) const {
        if (items.size() <= largest_leaf || items.need_no_order(cell)) return false;
        typename Outer::node_data nothing{};
        const Split answer = outer.choose(cell, std::span<const Item>(), nothing);
        if (answer != Split::yes && answer != Split::always) return false;
        const Cuts median = cuts(cell, node_data{{}, 0});
        // Cuts are counted in a sample. Where an instance is in the way Inner may find a way around it.
        const std::size_t polygons = items.size() - items.instances(), sampled = std::min<std::size_t>(polygons, 256);
        std::size_t cut = 0;
        for (const CuttingPlane& plane : median.planes) {
            const LocalPlane local_plane(plane, cell);
            for (std::size_t i = 0; i < items.instances(); ++i) {
                if (items.relation(i, plane, local_plane, cell) == PlaneRelation::crossing) return false;
            }
            for (std::size_t k = 0; k < sampled; ++k) {
                const std::size_t i = items.instances() + k * polygons / sampled;
                cut += items.relation(i, plane, local_plane, cell) == PlaneRelation::crossing;
            }
        }
        return 2 * cut <= sampled;
    }
};

}  // namespace farfield
