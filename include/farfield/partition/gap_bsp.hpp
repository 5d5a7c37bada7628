// Planes in the gaps between things (Shade et al. 1996, section 4).
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <span>
#include <vector>

#include "farfield/partition.hpp"
#include "farfield/partition/child_boxes.hpp"
#include "farfield/partition/extent.hpp"
#include "farfield/partition/gap_planes.hpp"
#include "farfield/partition/gap_search.hpp"
#include "farfield/partition/plane_sides.hpp"

namespace farfield {

/// Cells are halved by planes across a few directions, each in the best gap between what the cell holds. Planes cross
/// as few things as they can, leave as much to draw on either side, and cut along the longest extent, which keeps cells
/// compact.
///
/// The type says what becomes of things that no gap goes around:
///
/// `unique` (default): they go to the side of their center, whose bounds grow by them; those longer than half of the
/// cell stay with it. Every primitive is stored once, and nothing is inflated.
///
/// `shared`: they are in the cells on both sides, and so is what lies near: regions are inflated by a fraction, so that
/// images of neighbors overlap where they meet on a surface. Directions must lie along the axes.
///
/// `clipped`: polygons are cut; planes that would cut an instance are not taken.
template <Assignment assigned>
struct BasicGapBsp {
    static constexpr std::size_t most_directions = 8;
    static constexpr bool is_clipped = assigned == Assignment::clipped, is_shared = assigned == Assignment::shared;

    /// Planes are across these, of any length but zero, which stands for none. Two horizontal ones suit landscapes
    /// whose y points up, as in the paper. The three axes are tried too where no plane across these crosses less than
    /// half of what a cell holds, and where a cell is more than twice as long along an axis as along any of these.
    std::array<glm::vec3, most_directions> directions{glm::vec3(1, 0, 0), glm::vec3(0, 0, 1)};
    /// Most levels below the root; the report counts cells that reach it.
    std::uint32_t max_depth = 32;
    /// What one thing that a plane crosses weighs against a plane that crosses nothing; see GapSearch.
    float price_of_split = 4;
    /// Of a shared cell: how much larger than itself the region is whose contents it holds. The paper's are 0.1 to 0.2;
    /// without images there is nothing that would gain from it.
    float inflation = 0;

    /// The plane, and the bounds of the children behind it and in front.
    struct node_data {
        CuttingPlane plane;
        detail::ChildBoxes boxes;
    };
    static_assert(sizeof(node_data) == 28 || !vectors_are_packed);
    static constexpr PartitionFacts facts{.offers = assigned,
                                          .ordering = OrderGuarantee::cells,
                                          .file_tag = 0x47420000u + static_cast<std::uint32_t>(assigned)};
    enum Child : unsigned { behind, in_front };

    /// `count` directions that evenly divide half a turn about `up`, which is an axis.
    static BasicGapBsp around(glm::vec3 up, unsigned count = 2) {
        BasicGapBsp partition;
        partition.directions = {};
        const glm::vec3 first = std::abs(up.x) > 0.5f ? glm::vec3(0, 1, 0) : glm::vec3(1, 0, 0);
        const glm::vec3 second = glm::cross(up, first);
        for (unsigned i = 0; i < std::min<std::size_t>(count, most_directions); ++i) {
            // A quarter turn must not be off by what single precision makes of pi.
            const double turn = double(i) / count, angle = 3.14159265358979323846 * turn;
            partition.directions[i] =
                turn == 0.5 ? second : first * float(std::cos(angle)) + second * float(std::sin(angle));
        }
        return partition;
    }
    /// Planes across all three axes.
    static BasicGapBsp along_axes() {
        BasicGapBsp partition;
        partition.directions = {glm::vec3(1, 0, 0), glm::vec3(0, 1, 0), glm::vec3(0, 0, 1)};
        return partition;
    }

    const char* wrong_option() const {
        // A frame descends by recursion: see most_levels_in_files, in storage/file_format.hpp.
        if (max_depth > 1000) return "GapBsp: max_depth must be at most 1000";
        if (!(price_of_split >= 0 && std::isfinite(price_of_split)))
            return "GapBsp: price_of_split must be 0 or more and finite";
        if (!(inflation == 0 || (inflation >= 0.001f && inflation <= 1)))
            return "GapBsp: inflation must be 0 or from 0.001 to 1";
        if (!is_shared && inflation != 0)
            return "GapBsp: regions are inflated only where primitives are shared (SharedGapBsp)";
        bool some = false;
        for (const glm::vec3& d : directions) {
            if (!std::isfinite(d.x) || !std::isfinite(d.y) || !std::isfinite(d.z))
                return "GapBsp: a direction is not finite";
            if (is_shared && d != glm::vec3(0) && detail::axis_of(detail::unit_direction(d)) < 0)
                return "GapBsp: where primitives are shared, directions must lie along the axes";
            some = some || d != glm::vec3(0);
        }
        return some ? nullptr : "GapBsp: there must be at least one direction";
    }

    Cell root(const Box& bounds) const {
        Cell cell;
        for (int axis = 0; axis < 3 && !bounds.is_empty(); ++axis) {
            detail::put_around(bounds.lower[axis], bounds.upper[axis], axis, cell);
        }
        return inflated(cell);
    }

    Split choose(const Cell& cell, std::span<const Item> items, node_data& data) const requires(!is_clipped) {
        if (items.size() < 2) return Split::no;
        if (cell.depth >= max_depth) return Split::too_deep;
        const Box region = cell.box();
        const auto extents = [&](glm::vec3 normal, std::vector<detail::Extent>& out) {
            const detail::HeightsInCell heights(normal, cell);
            const detail::Extent whole = heights.of(region);
            for (const Item& item : items) {
                detail::Extent e = heights.of(item.bounds);
                if constexpr (is_shared) {
                    // Of what sticks out only the part inside counts, and what lies outside does not at all.
                    if (e.upper <= whole.lower || e.lower >= whole.upper) continue;
                    e.lower = std::max(e.lower, whole.lower);
                    e.upper = std::min(e.upper, whole.upper);
                }
                e.weight = item.cost;
                out.push_back(e);
            }
        };
        const auto any = [](const CuttingPlane&) { return true; };
        if (!find_plane(cell, items.size(), extents, any, data.plane)) return Split::inseparable;
        std::array<Box, 2> boxes{Box::empty(), Box::empty()};
        [[maybe_unused]] const detail::SidesInCell sides(cell, data.plane);
        for (const Item& item : items) {
            if constexpr (is_shared) {
                for (const unsigned side : {behind, in_front}) {
                    const Box half = detail::half_of(region, cell, data.plane, side == behind);
                    if (!half.intersects(item.bounds)) continue;
                    boxes[side].add({glm::max(half.lower, item.bounds.lower), glm::min(half.upper, item.bounds.upper)});
                }
            } else if (const int side = sides.side_of(item.bounds); side >= 0) {
                boxes[std::size_t(side)].add(item.bounds);
            }
        }
        fit(cell, data, boxes);
        return Split::yes;
    }

    template <class Touches, class Emit>
    void place(const Cell& cell, const node_data& data, const Item& item, Touches&& touches, Emit&& give) const
        requires(!is_clipped) {
        if constexpr (is_shared) {
            bool is_placed = false;
            for (const unsigned side : {behind, in_front}) {
                const Box box = child(cell, data, side).bounds();
                if (!box.intersects(item.bounds) || !touches(box)) continue;
                give(side);
                is_placed = true;
            }
            if (is_placed) return;
            // It lies near this cell but near none of the children. What may lie in the cell itself must not be lost
            // by rounding.
            Cell nearer = cell;
            nearer.half *= 1 + 0.5f * inflation;
            if (inflation > 0 && !nearer.box().intersects(item.bounds)) {
                give.drop();
            } else {
                const detail::Extent e = detail::HeightsInCell(data.plane.normal, cell).of(item.bounds);
                give(e.lower + e.upper < 2 * data.plane.offset ? behind : in_front);
            }
        } else if (const int side = detail::SidesInCell(cell, data.plane).side_of(item.bounds); side >= 0) {
            give(unsigned(side));
        } else {
            give.keep();
        }
    }

    Split choose(const Cell& cell, const ClippedItems& items, node_data& data) const requires(is_clipped) {
        if (items.size() < 2) return Split::no;
        if (cell.depth >= max_depth) return Split::too_deep;
        const auto extents = [&](glm::vec3 normal, std::vector<detail::Extent>& out) {
            const detail::HeightsInCell heights(normal, cell);
            for (std::size_t i = 0; i < items.size(); ++i) {
                detail::Extent e = heights.of(items[i].bounds);
                e.blocks = items[i].corners == 0;
                e.weight = e.blocks ? items[i].cost : items[i].cost * float(items[i].corners - 2);
                out.push_back(e);
            }
        };
        const auto divides = [&](const CuttingPlane& plane) { return divides_items(cell, items, plane); };
        return find_plane(cell, items.size(), extents, divides, data.plane) ? Split::yes : Split::inseparable;
    }
    Cuts cuts(const Cell&, const node_data& data) const { return {{data.plane}, 1, 2}; }
    /// What lies on the plane goes in front.
    unsigned child_at(const node_data&, const Sides& sides) const {
        return sides[0] == Side::behind ? behind : in_front;
    }

    void fit(const Cell& cell, node_data& data, std::span<const Box> children) const {
        const Box parent = is_shared ? cell.box() : cell.bounds();
        for (const unsigned side : {behind, in_front}) data.boxes.fit(parent, side, children[side]);
    }

    Cell child(const Cell& parent, const node_data& data, unsigned i) const {
        Cell cell;
        const Box box = is_shared ? parent.box() : parent.bounds();
        Box own;
        for (int axis = 0; axis < 3; ++axis) {
            own.lower[axis] = data.boxes.lower_of(box, i, axis);
            own.upper[axis] = data.boxes.upper_of(box, i, axis);
        }
        if constexpr (is_shared) own = detail::half_of(own, parent, data.plane, i == behind);
        for (int axis = 0; axis < 3; ++axis) detail::put_around(own.lower[axis], own.upper[axis], axis, cell);
        cell.depth = std::uint16_t(parent.depth + 1);
        return inflated(cell);
    }

    /// The viewer's side comes first.
    void front_to_back(const Cell& cell, const node_data& data, glm::vec4 viewpoint, ChildOrder& order) const {
        const bool is_in_front = LocalPlane(data.plane, cell).height(viewpoint) > 0;
        order = {std::uint8_t(is_in_front ? in_front : behind),
                 std::uint8_t(is_in_front ? behind : in_front),
                 2,
                 3,
                 4,
                 5,
                 6,
                 7};
    }

    /// Any finite plane and any bounds can be walked.
    bool is_sound(const node_data& data) const {
        const glm::vec3 n = data.plane.normal;
        return std::isfinite(n.x) && std::isfinite(n.y) && std::isfinite(n.z) && std::isfinite(data.plane.offset);
    }

  private:
    Cell inflated(Cell cell) const {
        if constexpr (is_shared) cell.bounds_half = cell.half * (1 + inflation);
        return cell;
    }

    static bool divides_items(const Cell& cell, const ClippedItems& items, const CuttingPlane& plane) {
        const LocalPlane local(plane, cell);
        bool some_behind = false, some_in_front = false;
        for (std::size_t i = 0; i < items.size(); ++i) {
            const PlaneRelation relation = items.relation(i, plane, local, cell);
            if (i < items.instances() && relation == PlaneRelation::crossing) return false;
            if (i >= items.instances() && some_behind && some_in_front) return true;
            some_behind = some_behind || relation == PlaneRelation::behind;
            some_in_front = some_in_front || relation == PlaneRelation::in_front || relation == PlaneRelation::on;
        }
        return some_behind && some_in_front;
    }

    template <class Extents, class IsGood>
    bool find_plane(const Cell& cell, std::size_t count, Extents&& extents, IsGood&& is_good,
                    CuttingPlane& plane) const {
        // What is stored once may cross any number of planes; copies and pieces must not multiply.
        detail::GapSearch search(price_of_split, assigned == Assignment::unique ? 1.0f : 0.25f);
        return detail::best_gap_plane(cell, directions, search, count, extents, is_good, plane);
    }
};

using GapBsp = BasicGapBsp<Assignment::unique>;
using SharedGapBsp = BasicGapBsp<Assignment::shared>;
using ClippedGapBsp = BasicGapBsp<Assignment::clipped>;

}  // namespace farfield
