// The heart of the house: a tree of cells over primitives that it does not know, with something cheaper to draw in
// each. What it is made by is build.hpp, what it is drawn by viewer.hpp, how it lasts storage/.
//
// Chamberlain, DeRose, Lischinski, Salesin, Snyder: Fast Rendering of Complex Environments Using a Spatial Hierarchy,
// Graphics Interface 1996, and Technical Report UW-CSE-95-05-02 of 1995.
#pragma once

#include "farfield/settings.hpp"

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>

#include "farfield/composition.hpp"
#include "farfield/hierarchy/hierarchy_data.hpp"
#include "farfield/missing_hooks.hpp"

namespace farfield {

/// Immutable and cheap to copy: copies share the arrays. Any number of viewers on any number of threads may use one. It
/// holds positions of primitives, never primitives: the range it was built from meets it again in the Viewer,
/// unchanged.
template <class Partition_, class A, class C>
class SpatialHierarchy {
    static_assert(detail::check_policies<Partition_, A, C>());

  public:
    using partition_type = Partition_;
    using approximation_type = A;
    using cost_model_type = C;
    using node_data = typename Partition_::node_data;
    using stand_in_data = typename A::stand_in_data;
    using pool_element = pool_element_of<A>;
    using Data = HierarchyData<Partition_, A>;
    using Arrays = HierarchyArrays<Partition_, A>;

    static constexpr Assignment assignment = agreed_assignment<Partition_, A>;
    /// The guarantee of an order front to back. Bounding boxes of cells may overlap where planes between them are
    /// oblique, so no stand-in is in order with the polygons in another cell. A sample that has moved up lies among
    /// what is below it.
    static constexpr OrderGuarantee ordering =
        A::facts.samples_primitives                                                ? OrderGuarantee::none
        : A::facts.stands_in && Partition_::facts.ordering > OrderGuarantee::cells ? OrderGuarantee::cells
                                                                                   : Partition_::facts.ordering;

    /// A hierarchy over nothing, which draws nothing.
    SpatialHierarchy() : SpatialHierarchy(Partition_{}, A{}, C{}, Data{.nodes = {Node{}}}) {}

    /// Wraps what was built.
    SpatialHierarchy(const Partition_& partition, const A& approximation, const C& cost, Data data)
        : partition_(partition), approximation_(approximation), cost_(cost), facts_(data.facts) {
        const auto kept = std::make_shared<const Data>(std::move(data));
        arrays_ = kept->arrays();
        memory_ = kept;
    }
    /// Wraps what lies in a file or a buffer; `memory` keeps the arrays alive.
    SpatialHierarchy(const Partition_& partition, const A& approximation, const C& cost, const HierarchyFacts& facts,
                     const Arrays& arrays, std::shared_ptr<const void> memory)
        : partition_(partition),
          approximation_(approximation),
          cost_(cost),
          facts_(facts),
          arrays_(arrays),
          memory_(std::move(memory)),
          from_file_(true) {}

    const Partition_& partition_policy() const { return partition_; }
    const A& approximation_policy() const { return approximation_; }
    const C& cost_policy() const { return cost_; }

    const HierarchyFacts& facts() const { return facts_; }
    const Arrays& arrays() const { return arrays_; }

    std::span<const Node> nodes() const { return arrays_.nodes; }
    std::span<const std::uint32_t> order() const { return arrays_.order; }  ///< empty: positions are indices
    std::span<const stand_in_data> stand_ins() const { return arrays_.stand_ins; }
    std::span<const pool_element> pool() const { return arrays_.pool; }
    std::span<const node_data> all_node_data() const { return arrays_.node_data; }
    /// The pieces that positions hold where the partition cuts; empty elsewhere.
    const Fragments& fragments() const { return arrays_.fragments; }

    node_data data_of(std::uint32_t node) const {
        if constexpr (std::is_empty_v<node_data>) {
            return {};
        } else {
            return arrays_.node_data[node];
        }
    }
    /// Tells that data_of() will be asked about a node soon: in large trees it is far from the node itself.
    void prefetch_data_of(std::uint32_t node) const {
        if constexpr (!std::is_empty_v<node_data>) __builtin_prefetch(arrays_.node_data.data() + node);
    }

    /// Whether items, in the order of front_to_back, hide only what comes after them, from wherever they are seen, up
    /// to rounding. Instances count as solid boxes: ask their hierarchies too.
    bool keeps_strict_order() const {
        return ordering == OrderGuarantee::primitives && facts_.report.cells_out_of_order == 0;
    }

    /// The root's stand-in or null.
    const stand_in_data* root_stand_in() const {
        return facts_.root_has_stand_in != 0 ? arrays_.stand_ins.data() : nullptr;
    }
    const Cell& root_cell() const { return facts_.root; }
    const Box& bounds() const { return facts_.bounds; }  ///< tight, local coordinates; empty over nothing
    glm::dvec3 origin() const {
        return facts_.origin;
    }  ///< of local coordinates, in the user's; 0 for single precision
    std::uint32_t item_count() const { return std::uint32_t(facts_.report.items); }
    std::uint64_t primitive_count() const { return facts_.primitive_count; }
    std::uint64_t fingerprint() const { return facts_.fingerprint; }
    bool is_from_file() const { return from_file_; }
    const BuildReport& report() const { return facts_.report; }
    /// The work of drawing every primitive.
    const Work& whole_work() const { return facts_.work; }

    /// The work of drawing it where it is small: what an instance of it costs.
    Work drawing_work() const {
        Work w = facts_.work;
        if constexpr (A::facts.stands_in) {
            if (const stand_in_data* root = root_stand_in()) w = detail::work_of_stand_in(approximation_, *root);
        }
        w += {.cells = 1};
        return w;
    }

    /// Nodes, stand-ins, item indices and fragments, in memory or in the file that is mapped.
    std::size_t bytes() const {
        return arrays_.nodes.size_bytes() + arrays_.node_data.size() * stored_size<node_data> +
               arrays_.stand_ins.size() * stored_size<stand_in_data> + arrays_.pool.size() * stored_size<pool_element> +
               arrays_.order.size_bytes() + arrays_.fragments.size_bytes();
    }

    /// Calls sink(Polygon) with the faces of the root's stand-in, colors not premultiplied; false if it has none.
    template <class Sink>
    bool root_polygons(Sink&& sink) const {
        if constexpr (A::facts.stands_in) {
            const stand_in_data* root = root_stand_in();
            if (root != nullptr) detail::stand_in_polygons(approximation_, *root, arrays_.pool, facts_.root, sink);
            return root != nullptr;
        }
        return false;
    }

  private:
    Partition_ partition_;
    A approximation_;
    C cost_;
    HierarchyFacts facts_;
    Arrays arrays_;
    std::shared_ptr<const void> memory_;
    bool from_file_ = false;
};

}  // namespace farfield
