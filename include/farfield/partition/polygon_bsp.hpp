// Binary space partitioning (Fuchs, Kedem and Naylor 1980), which Greene 1996, section 4 draws from front to back.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>

#include "farfield/partition.hpp"
#include "farfield/partition/child_boxes.hpp"
#include "farfield/partition/plane_choice.hpp"

namespace farfield {

/// A plane cuts every inner cell into three children: behind it, on it and in front of it. A leaf holds one piece, or
/// pieces that lie in one plane, and items that no plane tells from an instance.
struct PolygonBsp {
    /// Most levels below the root. Cells that reach it are not in order; the report counts them.
    std::uint32_t max_depth = 500;
    /// What a cut piece weighs against one more plane: see plane_choice.hpp. Measured with 1, 3 and 10: an office
    /// building gets 26, 24 and 23 % more pieces than polygons, leaves of a tree 209, 211 and 212 %.
    float price_of_cut = 2;

    /// The plane, and the bounds of the children behind and in front.
    struct node_data {
        CuttingPlane plane;
        detail::ChildBoxes boxes;
    };
    static_assert(sizeof(node_data) == 28 || !vectors_are_packed);
    static constexpr PartitionFacts facts{.offers = Assignment::clipped,
                                          .ordering = OrderGuarantee::primitives,
                                          .splits_for_order = true,
                                          .file_tag = 0x42530001u};
    enum Child : unsigned { behind, on, in_front };

    const char* wrong_option() const {
        // A frame descends by recursion: see most_levels_in_files, in storage/file_format.hpp.
        if (max_depth > 1000) return "PolygonBsp: max_depth must be at most 1000";
        return price_of_cut >= 0 && std::isfinite(price_of_cut)
                   ? nullptr
                   : "PolygonBsp: price_of_cut must be 0 or more and finite";
    }

    Cell root(const Box& bounds) const {
        Cell cell;
        for (int axis = 0; axis < 3 && !bounds.is_empty(); ++axis) {
            detail::put_around(bounds.lower[axis], bounds.upper[axis], axis, cell);
        }
        return cell;
    }

    Split choose(const Cell& cell, const ClippedItems& items, node_data& data) const {
        if (cell.partition_state == flat || items.need_no_order(cell)) return Split::no;
        if (cell.depth >= max_depth) return Split::too_deep;
        return detail::choose_plane(cell, items, price_of_cut, data.plane) ? Split::always : Split::inseparable;
    }

    Cuts cuts(const Cell&, const node_data& data) const { return {{data.plane}, 1, 3}; }
    unsigned child_at(const node_data&, const Sides& sides) const { return unsigned(sides[0]); }

    void fit(const Cell& cell, node_data& data, std::span<const Box> children) const {
        const Box parent = cell.bounds();
        data.boxes.fit(parent, 0, children[behind]);
        data.boxes.fit(parent, 1, children[in_front]);
    }

    Cell child(const Cell& parent, const node_data& data, unsigned i) const {
        // Cells are written where they are read, number by number: to copy one whole would wait for all of it.
        Cell cell;
        if (i == on) {
            cell = parent;
        } else {
            const Box box = parent.bounds();
            const std::size_t side = i == behind ? 0 : 1;
            for (int axis = 0; axis < 3; ++axis) {
                detail::put_around(data.boxes.lower_of(box, side, axis), data.boxes.upper_of(box, side, axis), axis,
                                   cell);
            }
        }
        cell.depth = std::uint16_t(parent.depth + 1);
        // Pieces on the plane may, after rounding, lie on that of none of them. They are still not divided further.
        cell.partition_state = i == on ? flat : parent.partition_state;
        return cell;
    }

    /// The viewer's side comes first, then the pieces on the plane. A viewer on the plane sees it on edge.
    void front_to_back(const Cell& cell, const node_data& data, glm::vec4 viewpoint, ChildOrder& order) const {
        const bool is_in_front = LocalPlane(data.plane, cell).height(viewpoint) > 0;
        order = {std::uint8_t(is_in_front ? in_front : behind),
                 on,
                 std::uint8_t(is_in_front ? behind : in_front),
                 3,
                 4,
                 5,
                 6,
                 7};
    }

    /// Any finite plane and any bounds can be walked.
    bool is_sound(const node_data& data) const {
        const glm::vec4 plane(data.plane.normal, data.plane.offset);
        return std::isfinite(plane.x) && std::isfinite(plane.y) && std::isfinite(plane.z) && std::isfinite(plane.w);
    }

  private:
    static constexpr std::uint16_t flat = 1;
};

}  // namespace farfield
