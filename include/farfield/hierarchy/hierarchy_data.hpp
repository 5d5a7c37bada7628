// A hierarchy is made of facts, which are one record, and arrays. All of it is built, stored and opened alike.
#pragma once

#include "farfield/settings.hpp"

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <type_traits>
#include <vector>

#include "farfield/approximation.hpp"
#include "farfield/cost_model.hpp"
#include "farfield/geometry/box.hpp"
#include "farfield/geometry/cell.hpp"
#include "farfield/geometry/fragments.hpp"
#include "farfield/geometry/light.hpp"
#include "farfield/hierarchy/build_report.hpp"
#include "farfield/hierarchy/node.hpp"

namespace farfield {

/// What light the colors of stand-ins have been given, once and for all. `unknown`: the sampler does not tell.
enum class BakedLight : std::uint32_t { unknown, none, directional };

/// All that is no array, as it lies in files: no padding. Everything is in the hierarchy's own coordinates.
struct HierarchyFacts {
    glm::dvec3 origin{0};  ///< the user's coordinates minus this are the hierarchy's
    std::uint64_t primitive_count = 0;
    std::uint64_t fingerprint = 0;  ///< of the primitives' bounds in the order that positions refer to
    BuildReport report;
    Box bounds = Box::empty();  ///< tight
    Cell root;
    Work work;  ///< of drawing everything, without stand-ins
    std::uint32_t root_has_stand_in = 0;
    BakedLight baked_light = BakedLight::unknown;
    DirectionalLight light{};  ///< where it is directional, in the hierarchy's own axes
    std::uint32_t spare = 0;
};

/// Borrowed arrays. Arrays of empty records are empty.
template <class Partition_, class A>
struct HierarchyArrays {
    std::span<const Node> nodes{};                                ///< root first; at least one
    std::span<const typename Partition_::node_data> node_data{};  ///< parallel to nodes
    std::span<const typename A::stand_in_data> stand_ins{};       ///< of nodes that have one, in node order
    std::span<const pool_element_of<A>> pool{};
    std::span<const std::uint32_t> order{};  ///< position -> primitive; empty: positions are indices
    Fragments fragments{};                   ///< what positions hold where the partition cuts
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

/// A builder's result: HierarchyArrays with memory of their own.
template <class Partition_, class A>
struct HierarchyData {
    HierarchyFacts facts{};
    std::vector<Node> nodes{};
    std::vector<typename Partition_::node_data> node_data{};
    std::vector<typename A::stand_in_data> stand_ins{};
    std::vector<pool_element_of<A>> pool{};
    std::vector<std::uint32_t> order{};
    FragmentArrays fragments{};

    HierarchyArrays<Partition_, A> arrays() const { return {nodes, node_data, stand_ins, pool, order, fragments}; }
};

}  // namespace farfield
