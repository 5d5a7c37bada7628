// Cubes halved on all three axes, adaptively or to a uniform depth (Chamberlain et al. 1996, section 4; 1995,
// section 4.1).
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec4.hpp>
#include <span>

#include "farfield/partition.hpp"

namespace farfield {

/// The type says which primitives a cell gets, since that decides what a frame has to do:
///
/// `unique` (default, "loose"): a primitive no larger than the cell goes to the cell of its center and may stick out by
/// half the cell's side; larger ones stay with an ancestor. Cells are culled by bounds twice their size. Every
/// primitive is stored once and a subtree's primitives are one range.
///
/// `shared`: a primitive goes to every cell that it touches (the papers' way), is drawn once a frame by stamps, and its
/// cost is shared among its cells. The price is broken runs and more indices; bench/ has the figures.
template <Assignment assigned>
struct BasicOctree {
    static_assert(assigned == Assignment::unique || assigned == Assignment::shared,
                  "farfield::BasicOctree: an octree does not clip");

    /// Most levels below the root; raising it lets crowded places be split further. Cells whose halves single precision
    /// cannot tell apart are never split.
    std::uint32_t max_depth = 32;
    /// 0: cells are split where the cost model says that it pays. Otherwise every cell that is not empty is split to
    /// this depth (1995).
    std::uint32_t uniform_depth = 0;

    struct node_data {};
    static constexpr PartitionFacts facts{.offers = assigned,
                                          .ordering = OrderGuarantee::cells,
                                          .children_are_octants = true,
                                          .chooses_by_cell = true,
                                          .file_tag = 0x4f430000u + static_cast<std::uint32_t>(assigned)};

    Cell root(const Box& bounds) const {
        if (bounds.is_empty()) return {};
        // A cube, so that all cells are: six faces and one pixel error mean the same in every direction.
        return cell(bounds.center(), glm::vec3(0.5f * bounds.largest_side()), 0);
    }

    Split choose(const Cell& cell, std::span<const Item>, node_data&) const {
        if (uniform_depth != 0) {
            if (cell.depth >= uniform_depth) return Split::no;
        } else if (cell.depth >= max_depth) {
            return Split::too_deep;
        }
        if (!can_halve(cell)) return Split::too_deep;
        return uniform_depth != 0 ? Split::always : Split::yes;
    }

    template <class Touches, class Emit>
    void place(const Cell& cell, const node_data& data, const Item& item, Touches&& touches, Emit&& give) const {
        if constexpr (assigned == Assignment::unique) {
            if (item.bounds.largest_side() > cell.half.x) {
                give.keep();
            } else {
                give(octant(cell, item.bounds.center()));
            }
        } else {
            unsigned touched = 0;
            for (unsigned i = 0; i < 8; ++i) {
                const Box box = child(cell, data, i).box();
                if (box.intersects(item.bounds) && touches(box)) {
                    give(i);
                    ++touched;
                }
            }
            // Rounding on both sides of a face must not lose a primitive.
            if (touched == 0) give(octant(cell, glm::clamp(item.bounds.center(), cell.box().lower, cell.box().upper)));
        }
    }

    Cell child(const Cell& parent, const node_data&, unsigned i) const {
        const glm::vec3 half = parent.half * 0.5f;
        const glm::vec3 side(i & 1 ? half.x : -half.x, i & 2 ? half.y : -half.y, i & 4 ? half.z : -half.z);
        return cell(parent.center + side, half, std::uint16_t(parent.depth + 1));
    }

    /// The octant nearest to the viewer comes first; octants that differ in one more bit lie behind.
    void front_to_back(const Cell& cell, const node_data&, glm::vec4 viewpoint, ChildOrder& order) const {
        const glm::vec3 v = glm::vec3(viewpoint) - cell.center * viewpoint.w;
        const unsigned nearest = unsigned(v.x > 0) | unsigned(v.y > 0) << 1 | unsigned(v.z > 0) << 2;
        for (unsigned i = 0; i < 8; ++i) order[i] = std::uint8_t(i ^ nearest);
    }

  private:
    static Cell cell(glm::vec3 center, glm::vec3 half, std::uint16_t depth) {
        const float looseness = assigned == Assignment::unique ? 2.0f : 1.0f;
        return {center, half, center, half * looseness, depth, 0};
    }
    static unsigned octant(const Cell& cell, glm::vec3 p) {
        return unsigned(p.x >= cell.center.x) | unsigned(p.y >= cell.center.y) << 1 |
               unsigned(p.z >= cell.center.z) << 2;
    }
    static bool can_halve(const Cell& cell) {
        const glm::vec3 h = cell.half * 0.5f;
        for (int axis = 0; axis < 3; ++axis) {
            const float c = cell.center[axis];
            if (!(c - h[axis] < c && c < c + h[axis])) return false;
        }
        return true;
    }
};

using Octree = BasicOctree<Assignment::unique>;
using SharedOctree = BasicOctree<Assignment::shared>;

}  // namespace farfield
