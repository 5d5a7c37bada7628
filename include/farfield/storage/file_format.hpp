// The layout of a hierarchy's file, and the questions that policies must answer to be stored.
//
// This is version 5, whose fingerprints are sums over primitives. Numbers are in the byte order of the machine that
// wrote them, which `byte_order` tells; a machine of the other order refuses the file.
//
//     0    FileHeader, 664 bytes
//     704  sections, each at the next multiple of 64 bytes; bytes between them are 0; only notes (storage/notes.hpp)
//          follow the last, or nothing
//
//     section                 records                               bytes a record
//     partition_options       1, or 0 if the policy is empty        its numbers (storage/fields.hpp), no padding
//     approximation_options   the same
//     cost_options            the same
//     nodes                   at least 1, the root first            16
//     node_data               as many as nodes, or 0 if empty       sizeof Partition::node_data
//     stand_ins               of nodes that have one, in order      sizeof Approximation::stand_in_data
//     pool                    any number                            sizeof Approximation::pool_element
//     order                   as many as items, or 0 if positions   4
//                             are indices (build_in_place)
//     first_vertices          items + 1 where polygons are cut,     4
//                             else 0, and so for the next two
//     vertices                any number                            12
//     colors                  as many                               4
//
// Records lie in the file as they do in memory: a mapped file is a hierarchy, nothing is parsed or copied. Primitives
// are not in it.
#pragma once

#include "farfield/settings.hpp"

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <type_traits>

#include "farfield/spatial_hierarchy.hpp"
#include "farfield/storage/fields.hpp"

namespace farfield {

/// Says whether place, child and front_to_back may be called with a node's data, so that a file made by a stranger
/// cannot make them read elsewhere.
template <class Partition_>
concept ChecksNodeData = requires(const Partition_& p, const typename Partition_::node_data& data) {
    { p.is_sound(data) } -> std::same_as<bool>;
};
/// Says whether all that a stand-in refers to lies within the pool.
template <class A>
concept ChecksPool = requires(const A& a, const typename A::stand_in_data& data,
                              std::span<const typename A::pool_element> pool) {
    { a.is_sound(data, pool) } -> std::same_as<bool>;
};
/// Says whether a stand-in's data may be drawn: for approximations without a pool some of whose values mean nothing.
template <class A>
concept ChecksStandIns = requires(const A& a, const typename A::stand_in_data& data) {
    { a.is_sound(data) } -> std::same_as<bool>;
};
namespace detail {
template <class Partition_>
concept ChecksNodeDataIfAny = std::is_empty_v<typename Partition_::node_data> || ChecksNodeData<Partition_>;
template <class A>
concept ChecksPoolIfAny = !A::facts.has_pool || ChecksPool<A>;
}  // namespace detail

namespace detail {
/// What files hold of an approximation's options: all, but where it names another that it is stored as.
template <class A>
struct StoredApproximation {
    using type = A;
};
template <class A>
requires requires {
    typename A::stored_approximation;
}
struct StoredApproximation<A> {
    using type = typename A::stored_approximation;
};
template <class A>
using stored_approximation_of = typename StoredApproximation<A>::type;
}  // namespace detail

/// Options are numbers alone; records have no padding either, for they are written as they lie in memory.
template <class Partition_>
concept StorablePartition =
    Partition<Partition_> && std::default_initializable<Partition_> && Partition_::facts.file_tag != 0 &&
    detail::MadeOfNumbers<Partition_>&& detail::WithoutPadding<typename Partition_::node_data>&&
        detail::ChecksNodeDataIfAny<Partition_>;

template <class A>
concept StorableApproximation =
    Approximation<A> && std::default_initializable<A> && A::facts.file_tag != 0 &&
    detail::MadeOfNumbers<detail::stored_approximation_of<A>>&& detail::WithoutPadding<typename A::stand_in_data>&&
        detail::WithoutPadding<pool_element_of<A>>&& detail::ChecksPoolIfAny<A>;

template <class C>
concept StorableCostModel =
    CostModel<C> && std::default_initializable<C> && C::file_tag != 0 && detail::MadeOfNumbers<C>;

/// A SpatialHierarchy that save() and open() take. GLM_FORCE_DEFAULT_ALIGNED_GENTYPES leaves none.
template <class H>
concept Storable = vectors_are_packed && StorablePartition<typename H::partition_type> &&
    StorableApproximation<typename H::approximation_type> && StorableCostModel<typename H::cost_model_type>;

/// Deeper hierarchies are neither saved nor opened: a frame descends by recursion, and a file must not decide how much
/// of the stack that takes. Octrees end before 300, where single precision does.
inline constexpr std::size_t most_levels_in_files = 1024;

namespace detail {

/// The first byte is not text, and programs that damage line ends damage these (after PNG's signature).
inline constexpr std::array<std::uint8_t, 8> file_magic{0x89, 'F', 'F', 'H', '\r', '\n', 0x1a, '\n'};
inline constexpr std::uint32_t file_version = 5;
inline constexpr std::uint32_t file_byte_order = 0x01020304u;
inline constexpr std::uint64_t section_alignment = 64;

enum class Section : std::uint8_t {
    partition_options,
    approximation_options,
    cost_options,
    nodes,
    node_data,
    stand_ins,
    pool,
    order,
    first_vertices,
    vertices,
    colors
};
inline constexpr std::size_t section_count = 11;
inline constexpr std::array<const char*, section_count> section_names{"partition options",
                                                                      "approximation options",
                                                                      "cost model options",
                                                                      "nodes",
                                                                      "node data",
                                                                      "stand-ins",
                                                                      "pool",
                                                                      "order",
                                                                      "first vertices",
                                                                      "vertices",
                                                                      "colors"};

struct SectionEntry {
    std::uint64_t offset = 0;  ///< from the start of the file
    std::uint64_t count = 0;
    std::uint64_t record_bytes = 0;
    std::uint64_t checksum = 0;  ///< XXH64 of its bytes

    std::uint64_t bytes() const { return count * record_bytes; }
};

struct FileHeader {
    std::array<std::uint8_t, 8> magic = file_magic;
    std::uint32_t version = file_version;
    std::uint32_t byte_order = file_byte_order;
    std::uint32_t header_bytes = 664;
    std::uint32_t partition_tag = 0;
    std::uint32_t approximation_tag = 0;
    std::uint32_t cost_tag = 0;
    std::uint64_t file_bytes = 0;  ///< where the last section ends
    std::array<SectionEntry, section_count> sections{};
    HierarchyFacts facts;
    std::uint64_t checksum = 0;  ///< XXH64 of all bytes of the header before it
};

// A change of any of these is a new file_version.
static_assert(!vectors_are_packed ||
              (sizeof(Node) == 16 && sizeof(Cell) == 52 && sizeof(Work) == 28 && sizeof(BuildReport) == 88 &&
               sizeof(DirectionalLight) == 20 && sizeof(FileHeader) == 664 && offsetof(FileHeader, checksum) == 656 &&
               WithoutPadding<SectionEntry> && WithoutPadding<HierarchyFacts> && WithoutPadding<FileHeader>));

constexpr std::uint64_t next_section(std::uint64_t offset) {
    return (offset + section_alignment - 1) / section_alignment * section_alignment;
}

/// Bytes of a record of H in each section, which files must agree with.
template <class H>
constexpr std::array<std::uint64_t, section_count> record_bytes() {
    return {bytes_of_numbers<typename H::partition_type>(),
            bytes_of_numbers<stored_approximation_of<typename H::approximation_type>>(),
            bytes_of_numbers<typename H::cost_model_type>(),
            sizeof(Node),
            stored_size<typename H::node_data>,
            stored_size<typename H::stand_in_data>,
            stored_size<typename H::pool_element>,
            sizeof(std::uint32_t),
            sizeof(std::uint32_t),
            sizeof(glm::vec3),
            sizeof(Rgba8)};
}

}  // namespace detail
}  // namespace farfield
