// The heart of the house: a tree of cells over primitives it does not know, with something cheaper to draw in each.
//
// Chamberlain, DeRose, Lischinski, Salesin, Snyder: Fast Rendering of Complex Environments Using a Spatial Hierarchy,
// Graphics Interface 1996, and Technical Report UW-CSE-95-05-02 of 1995.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "farfield/fingerprint.hpp"
#include "farfield/hierarchy_builder.hpp"
#include "farfield/hierarchy_parts.hpp"
#include "farfield/policy.hpp"

namespace farfield {

/// Immutable after the build and cheap to copy: copies share the arrays. Any number of viewers on any number of threads
/// may use one. It holds positions of primitives, never primitives: the span it was built from meets it again in
/// the Viewer, unchanged.
template <Partition P, Approximation A, CostModel C>
requires Composable<P, A, C>
class SpatialHierarchy {
  public:
    using partition_type = P;
    using approximation_type = A;
    using cost_model_type = C;
    using node_data = typename P::node_data;
    using cell_data = typename A::cell_data;
    using pool_element = typename A::pool_element;

    /// What partition and approximation agreed upon: unique where both can, for it makes one run of every subtree.
    static constexpr Assignment assignment = (P::facts.offers & A::facts.accepts & unique) != 0    ? unique
                                             : (P::facts.offers & A::facts.accepts & clipped) != 0 ? clipped
                                                                                                   : shared;
    /// What front to back guarantees. Bounding boxes of cells may overlap where planes between them are oblique, so no
    /// stand-in is in order with the polygons in another cell.
    static constexpr Ordering ordering =
        A::facts.stands_in && P::facts.ordering > Ordering::cells ? Ordering::cells : P::facts.ordering;

    /// Over nothing; draws nothing.
    SpatialHierarchy() : SpatialHierarchy(P{}, A{}, C{}, HierarchyParts<P, A>{.nodes = {Node{}}}) {}

    /// Throws std::invalid_argument naming the first primitive whose bounding box is empty or not finite. Same input
    /// and options give the same bytes, whatever the executor and its number of threads. `sampler` makes the colors of
    /// stand-ins; give it the light that the renderer will have.
    template <class Primitive, OrthographicSampler Sampler = GridSampler, class Executor = SerialExecutor>
    requires BuildableFrom<SpatialHierarchy, Primitive>
    static SpatialHierarchy build(std::span<const Primitive> primitives, P partition = {}, A approximation = {},
                                  C cost = {}, const BuildOptions& options = {}, const Sampler& sampler = {},
                                  const Executor& executor = {}) {
        detail::HierarchyBuilder<P, A, C, Primitive, Sampler, Executor> builder(primitives, partition, approximation,
                                                                                cost, sampler, options, executor);
        return SpatialHierarchy(partition, approximation, cost, builder.build());
    }

    /// Likewise, and puts the primitives into the hierarchy's order, so that no list of indices is needed: four bytes a
    /// primitive less, and runs read memory in a row. Only where every primitive is stored once.
    template <class Primitive, OrthographicSampler Sampler = GridSampler, class Executor = SerialExecutor>
    requires BuildableFrom<SpatialHierarchy, Primitive>
    static SpatialHierarchy build_in_place(std::span<Primitive> primitives, P partition = {}, A approximation = {},
                                           C cost = {}, const BuildOptions& options = {}, const Sampler& sampler = {},
                                           const Executor& executor = {}) requires(assignment == unique) {
        detail::HierarchyBuilder<P, A, C, Primitive, Sampler, Executor> builder(primitives, partition, approximation,
                                                                                cost, sampler, options, executor);
        HierarchyParts<P, A> parts = builder.build();
        std::vector<Primitive> ordered;
        ordered.reserve(primitives.size());
        for (const std::uint32_t i : parts.order) ordered.push_back(std::move(primitives[i]));
        std::move(ordered.begin(), ordered.end(), primitives.begin());
        parts.order = {};
        parts.fingerprint = detail::fingerprint_of(std::span<const Primitive>(primitives));
        return SpatialHierarchy(partition, approximation, cost, std::move(parts));
    }

    const P& partition_policy() const { return partition_; }
    const A& approximation_policy() const { return approximation_; }
    const C& cost_policy() const { return cost_; }

    std::span<const Node> nodes() const { return nodes_; }
    std::span<const std::uint32_t> order() const { return order_; }  ///< empty: positions are indices
    std::span<const cell_data> stand_ins() const { return cell_data_; }
    std::span<const pool_element> pool() const { return pool_; }
    /// That data_of() will be asked about a node soon: in large trees it is far from the node itself.
    void prefetch_data_of(std::uint32_t node) const {
        if constexpr (!std::is_empty_v<node_data>) __builtin_prefetch(&node_data_[node]);
    }
    node_data data_of(std::uint32_t node) const {
        if constexpr (std::is_empty_v<node_data>) {
            return {};
        } else {
            return node_data_[node];
        }
    }
    std::span<const node_data> all_node_data() const { return node_data_; }
    /// What positions hold where the partition cuts; empty elsewhere.
    const Fragments& fragments() const { return fragments_; }
    /// Whether items, in the order of front_to_back, hide only what comes after them, from wherever they are seen, up
    /// to rounding. Instances count as solid boxes: ask their hierarchies too.
    bool keeps_strict_order() const { return ordering == Ordering::primitives && report_.cells_out_of_order == 0; }

    /// The root's stand-in or null.
    const cell_data* root_stand_in() const { return root_has_stand_in_ ? cell_data_.data() : nullptr; }
    const Cell& root_cell() const { return root_; }
    const Box& bounds() const { return bounds_; }  ///< tight, local coordinates; empty over nothing
    glm::dvec3 origin() const { return origin_; }  ///< of local coordinates, in the user's; 0 for single precision
    std::uint32_t item_count() const { return item_count_; }
    std::uint64_t primitive_count() const { return primitive_count_; }
    std::uint64_t fingerprint() const { return fingerprint_; }
    bool is_from_file() const { return from_file_; }
    const BuildReport& report() const { return report_; }
    /// Of drawing every primitive.
    const Work& whole_work() const { return work_; }

    /// Of drawing it where it is small: what an instance of it costs.
    Work drawing_work() const {
        Work w = work_;
        if constexpr (A::facts.stands_in) {
            if (root_has_stand_in_) w = approximation_.work(cell_data_[0]);
        }
        w += {.cells = 1};
        return w;
    }

    /// Nodes, stand-ins, item indices and fragments, in memory or in the file that is mapped.
    std::size_t bytes() const {
        return nodes_.size_bytes() + node_data_.size() * stored_size<node_data> +
               cell_data_.size() * stored_size<cell_data> + pool_.size() * stored_size<pool_element> +
               order_.size_bytes() + fragments_.size_bytes();
    }

    /// Calls sink(Polygon) with the faces of the root's stand-in, colors not premultiplied; false if it has none.
    template <class Sink>
    bool root_polygons(Sink&& sink) const {
        if constexpr (A::facts.stands_in) {
            if (root_has_stand_in_) approximation_.polygons(cell_data_[0], pool_, root_, sink);
        }
        return root_has_stand_in_;
    }

    /// For storage/: wraps parts that were built, or that lie in memory which `memory` keeps alive.
    SpatialHierarchy(const P& partition, const A& approximation, const C& cost, HierarchyParts<P, A> parts)
        : partition_(partition), approximation_(approximation), cost_(cost) {
        const auto kept = std::make_shared<const HierarchyParts<P, A>>(std::move(parts));
        take_facts(*kept);
        nodes_ = kept->nodes;
        node_data_ = kept->node_data;
        cell_data_ = kept->cell_data;
        pool_ = kept->pool;
        order_ = kept->order;
        fragments_ = kept->fragments;
        memory_ = kept;
    }
    struct MappedArrays {
        std::span<const Node> nodes;
        std::span<const node_data> data;
        std::span<const cell_data> stand_ins;
        std::span<const pool_element> pool;
        std::span<const std::uint32_t> order;
        Fragments fragments;
        std::shared_ptr<const void> memory;
    };
    /// `facts` carries everything but the arrays.
    SpatialHierarchy(const P& partition, const A& approximation, const C& cost, const HierarchyParts<P, A>& facts,
                     MappedArrays arrays)
        : partition_(partition), approximation_(approximation), cost_(cost) {
        take_facts(facts);
        nodes_ = arrays.nodes;
        node_data_ = arrays.data;
        cell_data_ = arrays.stand_ins;
        pool_ = arrays.pool;
        order_ = arrays.order;
        fragments_ = arrays.fragments;
        memory_ = std::move(arrays.memory);
        from_file_ = true;
    }

  private:
    void take_facts(const HierarchyParts<P, A>& parts) {
        root_ = parts.root;
        bounds_ = parts.bounds;
        origin_ = parts.origin;
        work_ = parts.work;
        item_count_ = std::uint32_t(parts.report.items);
        primitive_count_ = parts.primitive_count;
        fingerprint_ = parts.fingerprint;
        root_has_stand_in_ = parts.root_has_stand_in;
        report_ = parts.report;
    }

    P partition_;
    A approximation_;
    C cost_;
    std::shared_ptr<const void> memory_;
    std::span<const Node> nodes_;
    std::span<const node_data> node_data_;
    std::span<const cell_data> cell_data_;
    std::span<const pool_element> pool_;
    std::span<const std::uint32_t> order_;
    Fragments fragments_;
    Cell root_;
    Box bounds_ = Box::empty();
    glm::dvec3 origin_{0};
    Work work_;
    std::uint32_t item_count_ = 0;
    std::uint64_t primitive_count_ = 0;
    std::uint64_t fingerprint_ = 0;
    bool root_has_stand_in_ = false;
    bool from_file_ = false;
    BuildReport report_;
};

}  // namespace farfield
