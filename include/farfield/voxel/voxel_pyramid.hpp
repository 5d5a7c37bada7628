// Tiles convex polyhedra into a grid of voxels by recursive subdivision: "only visit cells in the pyramid that are
// intersected by the polyhedron's faces" (Greene 1996, section 8).
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <stdexcept>
#include <vector>

#include "farfield/coverage/triage_mask.hpp"
#include "farfield/fail.hpp"
#include "farfield/voxel/voxel_masks.hpp"
#include "farfield/voxel/voxel_plane.hpp"

namespace farfield {

/// Some of 4 x 4 x 4 cubes of `side` voxels a side each, a power of 4.
struct VoxelCubes {
    glm::ivec3 first;  ///< first voxel of the first cube
    int side;
    std::uint64_t mask;  ///< bit 16 z + 4 y + x: the cube whose first voxel is first + side * (x, y, z)

    std::int64_t voxels() const { return std::int64_t(std::popcount(mask)) * side * side * side; }
    /// Calls f(first voxel of a cube) in order of bits.
    template <class F>
    void for_each(F&& f) const {
        for (std::uint64_t rest = mask; rest != 0; rest &= rest - 1) f(first + side * place(std::countr_zero(rest)));
    }
    static glm::ivec3 place(int bit) { return {bit & 3, bit >> 2 & 3, bit >> 4}; }
};

/// Stores in 1 bit each which voxels of a grid are occupied, and in 2 bits each which cubes of 4^n voxels are covered
/// or vacant: 1 2/63 bits a voxel where all sides are powers of 4; sides are rounded up to whole cubes of 4 voxels.
///
/// Polyhedra are tiled front to back, or in any order of importance: a voxel that one occupies is never given to
/// another. Clearing takes no time: a cell is ignored as long as the cell above says that it is vacant.
class VoxelPyramid {
  public:
    static constexpr int most_voxels_a_side = 16384;

    /// Starts with nothing occupied. A side may be 0. Throws std::invalid_argument for negative or too large sides.
    explicit VoxelPyramid(glm::ivec3 size_in_voxels) : size_(size_in_voxels) {
        const auto [least, most] = std::minmax({size_.x, size_.y, size_.z});
        if (least < 0 || most > most_voxels_a_side) {
            detail::fail<std::invalid_argument>("farfield::VoxelPyramid: a side is not from 0 to 16384 voxels");
        }
        if (least == 0) return;
        for (int side = 4; levels_.empty() || side < 4 * most; side *= 4) {
            const glm::ivec3 cells = (size_ + (side - 1)) / side;
            const std::size_t count = std::size_t(cells.x) * std::size_t(cells.y) * std::size_t(cells.z);
            levels_.push_back({cells, std::vector<TriageMask>(side == 4 ? 0 : count)});
            if (side == 4) blocks_.resize(count);
        }
    }

    glm::ivec3 size() const { return size_; }
    std::size_t bytes() const {
        std::size_t sum = blocks_.size() * sizeof(std::uint64_t);
        for (const Level& level : levels_) sum += level.masks.size() * sizeof(TriageMask);
        return sum;
    }

    void clear() {
        is_vacant_ = true;
        cells_visited_ = 0;
    }

    /// Occupies the voxels with their centers inside all planes and calls sink(VoxelCubes) for those that were vacant,
    /// each once, in cubes as large as possible, aligned to multiples of their side. No planes take all that is left.
    ///
    /// Visits cells that a plane crosses if no other plane excludes them, and the cells above; cells entirely inside
    /// only if some of them is occupied already. The sink must not use the pyramid; if it throws, call clear().
    template <class Sink>
    void tile(std::span<const VoxelPlane> planes, Sink&& sink) {
        if (levels_.empty()) return;
        scratch_.resize(planes.size() * (levels_.size() + 1));
        for (std::size_t i = 0; i < planes.size(); ++i) scratch_[i] = {&planes[i], planes[i].e, 0};
        const Visit root{int(levels_.size()) - 1, {0, 0, 0}, is_vacant_, scratch_.data(), planes.size()};
        if (visit(root, sink) != Outcome::unchanged) is_vacant_ = false;
    }
    /// Takes planes by VoxelPlane::snapped: inside where dot(n, p) + w > 0.
    template <class Sink>
    void tile(std::span<const glm::vec4> planes, Sink&& sink) {
        snapped_.clear();
        for (const glm::vec4& plane : planes) snapped_.push_back(VoxelPlane::snapped(glm::dvec4(plane)));
        tile(std::span<const VoxelPlane>(snapped_), sink);
    }

    /// Whether a voxel is occupied; those beyond the grid are not.
    bool occupied(glm::ivec3 voxel) const {
        for (int axis = 0; axis < 3; ++axis) {
            if (voxel[axis] < 0 || voxel[axis] >= size_[axis]) return false;
        }
        if (is_vacant_) return false;
        for (int level = int(levels_.size()) - 1; level > 0; --level) {
            const glm::ivec3 subcell = voxel >> 2 * level;
            const TriageMask& mask = levels_[std::size_t(level)].masks[index(level, subcell >> 2)];
            if (mask.covered >> bit(subcell) & 1) return true;
            if (mask.vacant >> bit(subcell) & 1) return false;
        }
        return blocks_[index(0, voxel >> 2)] >> bit(voxel) & 1;
    }

    /// Cells visited since the last clear(); a cell has 4 x 4 x 4 voxels or cells.
    std::uint64_t cells_visited() const { return cells_visited_; }

  private:
    struct Level {
        glm::ivec3 cells;
        std::vector<TriageMask> masks;  ///< none at level 0, which has blocks
    };
    /// A plane that crosses a cell.
    struct Crossing {
        const VoxelPlane* plane;
        std::int64_t value;    ///< at the cell's first voxel
        std::uint64_t active;  ///< subcells it crosses
    };
    struct Visit {
        int level;
        glm::ivec3 cell;
        bool is_vacant;  ///< the stored mask is ignored
        Crossing* crossings;
        std::size_t count;
    };
    /// What a visit did to a cell; full ones are not visited again.
    enum class Outcome { unchanged, changed, filled };
    static Outcome outcome(bool is_full) { return is_full ? Outcome::filled : Outcome::changed; }

    static int bit(glm::ivec3 subcell) { return (subcell.x & 3) | (subcell.y & 3) << 2 | (subcell.z & 3) << 4; }
    std::size_t index(int level, glm::ivec3 cell) const {
        const glm::ivec3& cells = levels_[std::size_t(level)].cells;
        return (std::size_t(cell.z) * std::size_t(cells.y) + std::size_t(cell.y)) * std::size_t(cells.x) +
               std::size_t(cell.x);
    }

    template <class Sink>
    Outcome visit(const Visit& v, Sink& sink) {
        ++cells_visited_;
        return v.level == 0 ? visit_block(v, sink) : visit_cell(v, sink);
    }

    template <class Sink>
    Outcome visit_block(const Visit& v, Sink& sink) {
        std::uint64_t& stored = blocks_[index(0, v.cell)];
        const glm::ivec3 first = v.cell * 4;
        const std::uint64_t before = v.is_vacant ? ~detail::voxel_corner(size_ - first) : stored;
        std::uint64_t write = ~before;
        for (std::size_t i = 0; i < v.count && write != 0; ++i) {
            const VoxelPlane& p = *v.crossings[i].plane;
            write &= ~detail::negative_voxels(v.crossings[i].value, p.a, p.b, p.c);
        }
        if (write == 0) return Outcome::unchanged;
        stored = before | write;
        sink(VoxelCubes{first, 1, write});
        return outcome(stored == all_subcells);
    }

    /// This is listing 1 of the paper, with planes for edges.
    template <class Sink>
    Outcome visit_cell(const Visit& v, Sink& sink) {
        const int side = 1 << 2 * v.level;
        const glm::ivec3 first = v.cell * (4 * side);
        TriageMask& stored = levels_[std::size_t(v.level)].masks[index(v.level, v.cell)];
        // Cubes beyond the grid are covered, and those that reach beyond it are never given away whole.
        const glm::ivec3 left = size_ - first;
        TriageMask mask = stored;
        if (v.is_vacant) {
            mask.vacant = detail::voxel_corner((left + (side - 1)) / side);
            mask.covered = ~mask.vacant;
        }
        TriageMask polyhedron{all_subcells, no_subcells};
        for (std::size_t i = 0; i < v.count; ++i) {
            Crossing& crossing = v.crossings[i];
            const TriageMask half_space = detail::voxel_triage(crossing.value, *crossing.plane, side);
            crossing.active = half_space.active();
            polyhedron.covered &= half_space.covered;
            polyhedron.vacant |= half_space.vacant;
            if ((polyhedron.vacant | mask.covered) == all_subcells) return Outcome::unchanged;
        }
        const std::uint64_t write = mask.vacant & polyhedron.covered & detail::voxel_corner(left / side);
        mask.covered |= write;
        mask.vacant &= ~write;
        bool wrote = write != 0;
        if (wrote) sink(VoxelCubes{first, side, write});

        std::uint64_t active = ~(write | polyhedron.vacant | mask.covered);
        for (; active != 0; active &= active - 1) {
            const int bit = std::countr_zero(active);
            const std::uint64_t subcell = active & ~(active - 1);
            const glm::ivec3 place = VoxelCubes::place(bit), offset = place * side;
            Visit child{v.level - 1, v.cell * 4 + place, (mask.vacant & subcell) != 0, v.crossings + v.count, 0};
            // No branches, because none could be predicted: a plane that does not cross is overwritten by the next.
            for (std::size_t i = 0; i < v.count; ++i) {
                const Crossing& crossing = v.crossings[i];
                const VoxelPlane& p = *crossing.plane;
                const std::int64_t step = p.a * offset.x + p.b * offset.y + p.c * offset.z;
                child.crossings[child.count] = {crossing.plane, crossing.value + step, 0};
                child.count += crossing.active >> bit & 1;
            }
            const Outcome of_child = visit(child, sink);
            if (of_child == Outcome::unchanged) continue;
            wrote = true;
            mask.vacant &= ~subcell;
            if (of_child == Outcome::filled) mask.covered |= subcell;
        }
        if (!wrote) return Outcome::unchanged;
        stored = mask;
        return outcome(mask.covered == all_subcells);
    }

    glm::ivec3 size_;
    std::vector<Level> levels_;  ///< level n has cells of 4^(n + 1) voxels a side; the last one is one cell
    std::vector<std::uint64_t> blocks_;
    bool is_vacant_ = true;
    std::uint64_t cells_visited_ = 0;
    std::vector<Crossing> scratch_;  ///< a list for each level
    std::vector<VoxelPlane> snapped_;
};

}  // namespace farfield
