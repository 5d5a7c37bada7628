// The arrays a hierarchy is made of, and what a build says about itself.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <type_traits>
#include <vector>

#include "farfield/cell.hpp"
#include "farfield/fragments.hpp"
#include "farfield/geometry/box.hpp"
#include "farfield/work.hpp"

namespace farfield {

/// 16 bytes, as they lie in files. Siblings lie next to each other; blocks of siblings follow depth first. So the
/// proper descendants of a node are one range of nodes and of stand-ins, and its subtree's items, own run first, are
/// one range of positions. Where a run or subtree ends follows from what comes next and is not stored.
struct Node {
    static constexpr std::uint8_t nothing_below = 255;

    std::uint32_t first_child = 0;       ///< 0: none
    std::uint32_t first_item = 0;        ///< own run first, then each child's subtree
    std::uint32_t first_child_data = 0;  ///< of the first child that has a stand-in; others follow by rank
    std::uint8_t child_mask = 0;         ///< which of the partition's children exist; absent ones were empty
    std::uint8_t stand_in_mask = 0;      ///< which of them have a stand-in
    std::uint8_t levels_to_last_stand_in = nothing_below;  ///< below this node, itself 0, the reach of others counted
    /// How many levels of stand-ins below it its own one reproduces: it may be drawn in their place, and where it may
    /// not they are missing. 0 for most.
    std::uint8_t stand_in_reach = 0;

    friend bool operator==(const Node&, const Node&) = default;
};
static_assert(sizeof(Node) == 16);

namespace detail {
/// Of a stand-in that is drawn in place of those `stand_in_reach` levels below it.
inline float error_of_reach(const Node& node) {
    return std::bit_cast<float>((127u - std::min<unsigned>(node.stand_in_reach, 126u)) << 23);
}
}  // namespace detail

/// What was built, what was refused and what stopped early.
struct BuildReport {
    std::uint64_t primitives = 0;
    std::uint64_t items = 0;  ///< primitives counted once for every cell that has them; of what is cut, fragments
    std::uint32_t nodes = 0;  ///< cells that are not empty
    std::uint32_t leaves = 0;
    std::uint32_t levels = 0;
    std::uint32_t empty_cells_pruned = 0;
    std::uint32_t splits_that_would_not_pay = 0;
    std::uint32_t cells_at_depth_limit = 0;  ///< wanted a split, but max_depth or float precision was reached
    std::uint32_t cells_that_cannot_be_told_apart = 0;  ///< wanted a split, but all their items share one center
    std::uint32_t cells_over_memory_budget = 0;         ///< wanted a split, but the memory budget was spent
    std::uint32_t stand_ins = 0;
    std::uint32_t stand_ins_that_would_not_pay = 0;
    std::uint32_t polygons_joined = 0;        ///< with the one before, before anything was cut
    std::uint32_t polygons_without_area = 0;  ///< left out before anything was cut, as they draw nothing
    /// Kept several items that no order suits from everywhere: instances that no plane tells from the rest, or what
    /// came to a limit. Of partitions that cut.
    std::uint32_t cells_out_of_order = 0;
    std::uint32_t spare = 0;
};

struct BuildOptions {
    /// Bytes of nodes, stand-ins and item indices after which no cell is split any more; 0: no limit. Checked between
    /// levels: the result may exceed it by one level.
    std::uint64_t memory_budget_bytes = 0;
};

/// An array of empty records takes no memory.
template <class T>
inline constexpr std::size_t stored_size = std::is_empty_v<T> ? 0 : sizeof(T);

/// Arrays of Fragments; empty where nothing is cut.
struct FragmentArrays {
    std::vector<std::uint32_t> first_vertex{};  ///< item_count + 1
    std::vector<glm::vec3> vertices{};
    std::vector<Rgba8> colors{};

    operator Fragments() const { return {first_vertex, vertices, colors}; }
};

/// What a builder makes and a SpatialHierarchy keeps; everything is in the hierarchy's own coordinates.
template <class Partition, class Approximation>
struct HierarchyParts {
    std::vector<Node> nodes{};                                   ///< root first; at least one
    std::vector<typename Partition::node_data> node_data{};      ///< parallel to nodes; empty where records are
    std::vector<typename Approximation::cell_data> cell_data{};  ///< of nodes with a stand-in, in node order
    std::vector<typename Approximation::pool_element> pool{};
    std::vector<std::uint32_t> order{};  ///< position -> primitive
    FragmentArrays fragments{};
    bool root_has_stand_in = false;
    Box bounds = Box::empty();  ///< tight
    Cell root{};
    glm::dvec3 origin{0};  ///< the user's coordinates minus this are the hierarchy's
    Work work{};           ///< of drawing everything, without stand-ins
    std::uint64_t primitive_count = 0;
    std::uint64_t fingerprint = 0;  ///< of the primitives' bounds in the user's order
    BuildReport report{};
};

}  // namespace farfield
