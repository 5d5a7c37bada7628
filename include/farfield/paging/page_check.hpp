// A page has been read: may frames walk it? A checksum finds accidents; whatever a forger could do beyond them is found
// by looking at every index. Then its indices become those of the cache's memory.
#pragma once

#include "farfield/settings.hpp"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

#include "farfield/paging/page_format.hpp"

namespace farfield::detail {

/// What a page must agree with.
struct PageExpected {
    std::uint32_t number = 0;
    std::uint32_t page_count = 0;
    std::uint64_t fingerprint = 0;
};

/// Whether each of a node's children has a stand-in, without those that do not exist.
inline std::uint32_t stand_ins_by_rank(const Node& node) {
    std::uint32_t bits = 0, rank = 0;
    for (unsigned child = 0; child < 8; ++child) {
        if ((node.child_mask >> child & 1) != 0) bits |= std::uint32_t(node.stand_in_mask >> child & 1) << rank++;
    }
    return bits;
}

/// The nodes of a page are a forest, numbered in one way only: walking unit by unit, depth first, meets blocks of
/// siblings, stand-ins and items in turn, so there is neither a circle nor a node with two parents. Portals lead to
/// later units, so there is none through these either.
inline const char* unsound_page_nodes(std::span<const Node> nodes, const PageHeader& header,
                                      const PageExpected& expected) {
    struct Siblings {
        std::uint32_t next, end;
        std::uint32_t stand_ins;  ///< one bit for each, the next one's first
    };
    std::vector<Siblings> path;
    std::uint32_t next_node = header.unit_count + 1, next_stand_in = 0, item = 0;
    const std::uint32_t node_count = header.node_count;
    for (std::uint32_t unit = 0; unit < header.unit_count; ++unit) {
        if (nodes[unit].first_item != item) return "a unit's items are out of order";
        const std::uint32_t end_item = nodes[unit + 1].first_item;
        if (end_item > header.item_count) return "a unit's items do not exist";
        path.assign(1, {unit, unit + 1, 0});
        while (!path.empty()) {
            if (path.back().next == path.back().end) {
                path.pop_back();
                continue;
            }
            const Node& n = nodes[path.back().next++];
            const bool has_stand_in = (path.back().stand_ins & 1) != 0;
            path.back().stand_ins >>= 1;
            if (n.first_item < item || n.first_item > end_item) return "a node's items are out of order";
            item = n.first_item;
            if (n.levels_replaced > 1) return "a stand-in replaces more than one level";
            if (!is_portal(n) && (n.stand_in_mask & ~n.child_mask) != 0) {
                return "a stand-in belongs to a child that does not exist";
            }
            if (path.size() == 1 && is_portal(n)) return "a unit lies in another page";
            // Whoever meets a portal looks at its stand-in.
            if (path.size() != 1 && is_portal(n) != has_stand_in) return "nodes with stand-ins are not those elsewhere";
            if (is_portal(n)) {
                if (n.first_child > expected.page_count - header.number) {
                    return "a node lies in a page that does not exist";
                }
                if (n.first_child == 1 && portal_of(n).unit <= unit) return "a node lies in what lies in it";
                continue;
            }
            const auto children = std::uint32_t(std::popcount(n.child_mask));
            if (children == 0) continue;
            if (n.first_child != next_node || children > node_count - next_node) return "nodes are out of order";
            next_node += children;
            const auto stand_ins = std::uint32_t(std::popcount(n.stand_in_mask));
            if (n.first_child_data != next_stand_in || stand_ins > header.stand_in_count - next_stand_in) {
                return "stand-ins are out of order";
            }
            next_stand_in += stand_ins;
            if (path.size() == most_levels_in_files) return "it has more than 1024 levels";
            path.push_back({n.first_child, n.first_child + children, stand_ins_by_rank(n)});
        }
        item = end_item;
    }
    if (next_node != node_count || next_stand_in != header.stand_in_count || item != header.item_count) {
        return "it holds what belongs to no unit";
    }
    return nullptr;
}

/// The reason not to use a page, or null. `page` has the size that the file says, and is aligned to 64 bytes.
template <class H, class P>
const char* unsound_page(std::span<const std::byte> page, const PageExpected& expected,
                         const typename H::partition_type& partition,
                         const typename H::approximation_type& approximation) {
    using Records = PageRecords<H, P>;
    PageHeader header;
    std::memcpy(&header, page.data(), sizeof header);
    if (header.magic != page_magic || header.used_bytes < sizeof header || header.used_bytes > page.size()) {
        return "it is no page";
    }
    if (header.checksum != checksum_of_page(page, header.used_bytes)) return "its checksum is wrong";
    if (header.number != expected.number || header.number >= expected.page_count) return "it is another page";
    if (header.fingerprint != expected.fingerprint) return "it belongs to another file";
    if (header.unit_count == 0 || header.unit_count > most_units_of_page || header.unit_count >= header.node_count ||
        header.level >= most_levels_in_files) {
        return "it holds no unit";
    }
    const std::uint64_t most = page.size();
    if (header.node_count > most || header.stand_in_count > most || header.item_count > most)
        return "it holds too much";
    const PageLayout at = Records::layout(header.node_count, header.stand_in_count, header.item_count);
    if (at.end != header.used_bytes) return "its arrays do not fill it";
    const std::span<const Node> nodes(reinterpret_cast<const Node*>(page.data() + at.nodes), header.node_count);
    if (const char* why = unsound_page_nodes(nodes, header, expected)) return why;
    if constexpr (Records::node_data_bytes != 0) {
        using Data = typename H::node_data;
        const Data* const data = reinterpret_cast<const Data*>(page.data() + at.node_data);
        for (std::uint32_t i = 0; i < header.node_count; ++i) {
            if (nodes[i].child_mask != 0 && !partition.is_sound(data[i])) return "the partition refuses a node's data";
        }
    }
    if constexpr (ChecksStandIns<typename H::approximation_type>) {
        using Data = typename H::stand_in_data;
        const Data* const data = reinterpret_cast<const Data*>(page.data() + at.stand_ins);
        for (std::uint32_t i = 0; i < header.stand_in_count; ++i) {
            if (!approximation.is_sound(data[i])) return "the approximation refuses a stand-in";
        }
    }
    return nullptr;
}

/// Turns the indices of a sound page into those of memory in which it begins at `begin`, a multiple of the common size
/// of its records.
template <class H, class P>
void place_page(std::span<std::byte> page, std::uint64_t begin) {
    using Records = PageRecords<H, P>;
    PageHeader header;
    std::memcpy(&header, page.data(), sizeof header);
    const PageLayout at = Records::layout(header.node_count, header.stand_in_count, header.item_count);
    const auto first_node = std::uint32_t((begin + at.nodes) / sizeof(Node));
    const auto first_stand_in = std::uint32_t((begin + at.stand_ins) / Records::stand_in_bytes);
    const auto first_item = std::uint32_t((begin + at.items) / sizeof(P));
    Node* const nodes = reinterpret_cast<Node*>(page.data() + at.nodes);
    for (std::uint32_t i = 0; i < header.node_count; ++i) {
        nodes[i].first_item += first_item;
        if (is_portal(nodes[i])) nodes[i].first_child += header.number;
        if (nodes[i].child_mask == 0) continue;
        nodes[i].first_child += first_node;
        nodes[i].first_child_data += first_stand_in;
    }
}

}  // namespace farfield::detail
