// The layout of a file of pages, which is read a page at a time, from a disk or over a network.
//
// A *unit* is the contents of a node that has a stand-in: its own run of primitives, the records and stand-ins of its
// children, and the same of those descendants that it reaches without passing another stand-in. A page holds
// consecutive units, level by level, in the order of the partition (Morton order for an octree): a frame needs one band
// of levels at each distance, so pages of whole subtrees would be entered for their roots alone, and 19 times as many
// are touched. A node's record and its stand-in thus lie in its parent's page, its children and primitives in its own
// (Klein et al. 2002, section 5.1, read that way round), and whatever page is missing, there is something to draw in
// its place.
//
//     0        PageFileHeader, then the options of partition, approximation and cost model as their numbers
//     4096 n   page 0, with the root's unit, and all others, `page_bytes` each, level by level
//              notes (storage/notes.hpp), if there are any
//
//     a page   PageHeader, 64 bytes
//              nodes: a root of each unit, one more that says where the last one's items end, the blocks of siblings
//              node data, as many, or none if empty
//              stand-ins
//              primitives, as they lie in memory
//
// Each array begins at a multiple of the size of its records, counted from the page's begin, and so does every page in
// the memory of a cache: whatever lies in a page has one index there, as it has in a hierarchy in memory. Indices in a
// page count from its arrays' begins. The node whose contents are a unit of their own is a *portal*: it has no
// children, and yet a first one, the number of pages from its own to theirs, plus 1; and instead of the mask of their
// stand-ins how far its contents stick out of its cell. So pages of a part of a tree are the same wherever they come to
// lie, but for the numbers in their headers.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <span>
#include <type_traits>

#include "farfield/geometry/mixed.hpp"
#include "farfield/hierarchy/hierarchy_data.hpp"
#include "farfield/paging/contents_reach.hpp"
#include "farfield/storage/checksum.hpp"
#include "farfield/storage/file_format.hpp"

namespace farfield {

/// A primitive that may lie in a page as it lies in memory. Whoever keeps one alive by other means, as an instance does
/// its hierarchy, cannot be paged.
template <class P>
concept PageablePrimitive =
    std::is_trivially_copyable_v<P> && Primitive<P> && !PrimitiveWithInstance<P> && alignof(P) <= 64;

/// A hierarchy that can be cut into pages: every node that refines has something to draw instead, no record refers to
/// what lies elsewhere, and each primitive lies in one cell.
template <class H>
concept Pageable = Storable<H> && H::approximation_type::facts.stands_in && !H::approximation_type::facts.has_pool &&
                   !H::approximation_type::facts.caches_images && H::assignment == Assignment::unique;

namespace detail {

inline constexpr std::array<std::uint8_t, 8> page_file_magic{0x89, 'F', 'F', 'P', '\r', '\n', 0x1a, '\n'};
inline constexpr std::uint32_t page_file_version = 1;
inline constexpr std::uint32_t page_magic = 0x50464631u;  // "1FFP"
inline constexpr std::uint64_t page_file_alignment = 4096;

struct PageFileHeader {
    std::array<std::uint8_t, 8> magic = page_file_magic;
    std::uint32_t version = page_file_version;
    std::uint32_t byte_order = file_byte_order;
    /// Tags of partition, approximation and cost model; sizes of a primitive, a stand-in and a record of node data.
    std::array<std::uint32_t, 6> records{};
    std::uint32_t option_bytes = 0;  ///< of all policies together
    std::uint32_t page_bytes = 0;
    std::uint32_t page_count = 0;
    std::uint32_t level_count = 0;  ///< of nodes, the root's included
    std::uint64_t first_page = 0;   ///< where page 0 begins
    std::uint64_t file_bytes = 0;   ///< where the last page ends
    std::uint64_t node_count = 0;   ///< in the tree
    HierarchyFacts facts;
    Node root;                              ///< a portal
    std::uint64_t checksum_of_options = 0;  ///< XXH64
    std::uint64_t checksum = 0;             ///< XXH64 of all bytes of the header before it
};
static_assert(!vectors_are_packed || WithoutPadding<PageFileHeader>);

struct PageHeader {
    std::uint32_t magic = page_magic;
    std::uint32_t number = 0;
    std::uint32_t level = 0;       ///< depth of the first cell whose contents it holds
    std::uint32_t unit_count = 0;  ///< the first of its nodes are their roots
    std::uint32_t node_count = 0, stand_in_count = 0, item_count = 0;
    std::uint32_t used_bytes = 0;
    std::uint64_t fingerprint = 0;  ///< of the primitives of the file that it belongs to
    std::uint64_t checksum = 0;     ///< checksum_of_page()
    std::uint64_t spare[2]{};
};
static_assert(sizeof(PageHeader) == 64 && offsetof(PageHeader, checksum) == 40);

inline std::uint64_t hash_before_checksum(std::span<const std::byte> page) {
    return Xxh64::of(page.first(offsetof(PageHeader, checksum)));
}
/// All but the checksum itself: the header before it, and what follows.
inline std::uint64_t checksum_of_page(std::span<const std::byte> page, std::size_t used_bytes) {
    return mixed(
        hash_before_checksum(page),
        Xxh64::of(page.first(used_bytes).subspan(offsetof(PageHeader, checksum) + sizeof(PageHeader::checksum))));
}

/// Writes the checksum of a page whose header is there but for that.
inline void sign_page(std::span<std::byte> page, std::size_t used_bytes) {
    const std::uint64_t checksum = checksum_of_page(page, used_bytes);
    std::memcpy(page.data() + offsetof(PageHeader, checksum), &checksum, sizeof checksum);
}

/// A page has come to lie elsewhere in its file. What its checksum says of all that follows the header is kept, so that
/// a page which has been damaged remains so, and its bytes are not read again.
inline void renumber_page(std::span<std::byte> page, std::uint32_t number) {
    PageHeader header;
    std::memcpy(&header, page.data(), sizeof header);
    const std::uint64_t rest = unmixed(hash_before_checksum(page), header.checksum);
    header.number = number;
    std::memcpy(page.data(), &header, sizeof header);
    header.checksum = mixed(hash_before_checksum(page), rest);
    std::memcpy(page.data(), &header, sizeof header);
}

/// One node's own contents may need as much; the memory that a cache takes is counted in pages.
inline constexpr std::uint64_t most_page_bytes = 64u << 20;
inline constexpr std::uint32_t most_units_of_page = 65535;

/// Where the contents of a node are.
struct Portal {
    std::uint32_t page = 0;   ///< in memory; in a file, the number of pages from the portal's own
    std::uint32_t unit = 0;   ///< below 65536
    std::uint32_t items = 0;  ///< below it, to a two hundredth part
    ContentsReach reach{};
};
inline bool is_portal(const Node& node) {
    return node.child_mask == 0 && node.first_child != 0;
}
inline Portal portal_of(const Node& node) {
    const float items = std::bit_cast<float>(node.first_child_data & 0xffff0000u);
    return {node.first_child - 1, node.first_child_data & 0xffffu,
            items >= 0 && items < 0x1p32f ? std::uint32_t(items) : 0u,  // a forger may have written anything
            ContentsReach(node.stand_in_mask)};
}
/// What a frame needs to know of a node while its page is missing is kept.
inline Node portal_to(const Portal& to, const Node& node) {
    Node n = node;
    n.first_child = to.page + 1;
    const auto items = std::bit_cast<std::uint32_t>(std::min(float(to.items), 0x1.fcp31f));
    n.first_child_data = (items & 0xffff0000u) | to.unit;
    n.child_mask = 0;
    n.stand_in_mask = to.reach.byte();
    return n;
}

template <class H, class P>
constexpr std::array<std::uint32_t, 6> page_records() {
    return {H::partition_type::facts.file_tag,
            H::approximation_type::facts.file_tag,
            H::cost_model_type::file_tag,
            std::uint32_t(sizeof(P)),
            std::uint32_t(stored_size<typename H::stand_in_data>),
            std::uint32_t(stored_size<typename H::node_data>)};
}
inline constexpr std::array<const char*, 6> page_record_names{
    "partition", "approximation", "cost model", "size of primitives", "size of stand-ins", "size of node data"};

/// Where the arrays of a page begin.
struct PageLayout {
    std::uint64_t nodes = 0, node_data = 0, stand_ins = 0, items = 0, end = 0;
};

template <class H, class P>
struct PageRecords {
    static constexpr std::uint32_t node_data_bytes = std::uint32_t(stored_size<typename H::node_data>);
    static constexpr std::uint32_t stand_in_bytes = std::uint32_t(stored_size<typename H::stand_in_data>);
    /// Pages begin at multiples of it, so that all their records have indices.
    static constexpr std::uint64_t common_multiple =
        std::lcm(std::lcm(std::lcm(std::uint64_t(64), std::uint64_t(node_data_bytes ? node_data_bytes : 1)),
                          std::uint64_t(stand_in_bytes ? stand_in_bytes : 1)),
                 std::uint64_t(sizeof(P)));
    static_assert(common_multiple <= 1u << 22,
                  "farfield: the sizes of records have no common multiple that a page could have");

    static constexpr std::uint64_t least_multiple_of(std::uint64_t unit, std::uint64_t from) {
        return unit == 0 ? from : (from + unit - 1) / unit * unit;
    }
    static constexpr PageLayout layout(std::uint64_t nodes, std::uint64_t stand_ins, std::uint64_t items) {
        PageLayout at;
        at.nodes = sizeof(PageHeader);
        at.node_data = least_multiple_of(node_data_bytes, at.nodes + nodes * sizeof(Node));
        at.stand_ins = least_multiple_of(stand_in_bytes, at.node_data + nodes * node_data_bytes);
        at.items = least_multiple_of(sizeof(P), at.stand_ins + stand_ins * stand_in_bytes);
        at.end = at.items + items * sizeof(P);
        return at;
    }
    static constexpr std::uint64_t layout_bytes(std::uint64_t nodes, std::uint64_t stand_ins, std::uint64_t items) {
        return layout(nodes, stand_ins, items).end;
    }
    /// That a page may have.
    static constexpr std::uint64_t most_bytes = most_page_bytes / common_multiple * common_multiple;
    /// Whatever lies in memory before this has an index of 32 bits.
    static constexpr std::uint64_t most_bytes_in_memory =
        0xffffffffu * std::min({std::uint64_t(sizeof(Node)), std::uint64_t(sizeof(P)),
                                std::uint64_t(stand_in_bytes ? stand_in_bytes : sizeof(Node))});
    /// The size of pages nearest to what is wanted, and no smaller than what one unit needs, which is at most
    /// most_bytes.
    static constexpr std::uint64_t page_bytes(std::uint64_t wanted, std::uint64_t needed) {
        const std::uint64_t below = std::min(wanted, most_bytes) / common_multiple * common_multiple;
        return below >= needed && below != 0 ? below
                                             : least_multiple_of(common_multiple, std::max(needed, common_multiple));
    }
};

}  // namespace detail
}  // namespace farfield
