// Cuts a hierarchy in memory into pages: a file that paging/paged_hierarchy.hpp opens.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "farfield/fail.hpp"
#include "farfield/frame/subtree.hpp"
#include "farfield/paging/page_format.hpp"
#include "farfield/storage/checksum.hpp"
#include "farfield/storage/save.hpp"

namespace farfield {

struct PageOptions {
    /// Bytes of a page, more or less: less by up to the common multiple of the sizes of its records, more if what one
    /// node holds by itself needs it.
    std::uint32_t page_bytes = 65536;
};

namespace detail {

/// A unit of a hierarchy in memory, and where it goes.
struct PageUnit {
    Subtree subtree;
    std::uint32_t nodes = 0, stand_ins = 0, items = 0;  ///< that it adds to its page, its root included
    std::uint32_t page = 0, number = 0;                 ///< the page, and which unit of it
};

template <Pageable H, PageablePrimitive P>
class PageWriter {
    using Records = PageRecords<H, P>;

  public:
    PageWriter(const H& hierarchy, std::span<const P> primitives, const PageOptions& options)
        : h_(hierarchy), primitives_(primitives), unit_of_node_(hierarchy.nodes().size(), no_unit) {
        if (primitives.size() != h_.primitive_count()) {
            fail<std::invalid_argument>("farfield::save_pages: the hierarchy was built from " +
                                        std::to_string(h_.primitive_count()) + " primitives and is given " +
                                        std::to_string(primitives.size()));
        }
        find_units();
        place_units(options);
    }

    /// Calls write(bytes) with all parts of the file, in order.
    template <class Write>
    void write(Write&& write) {
        write_header(write);
        std::vector<std::byte> page(page_bytes_);
        for (std::size_t first = 0, number = 0; first < units_.size(); ++number) {
            std::size_t end = first;
            while (end < units_.size() && units_[end].page == number) ++end;
            fill(page, std::span(units_).subspan(first, end - first), std::uint32_t(number));
            write(std::span<const std::byte>(page));
            first = end;
        }
    }

  private:
    static constexpr std::uint32_t no_unit = std::numeric_limits<std::uint32_t>::max();

    /// Calls f(child) for each child, in the partition's own order.
    template <class F>
    void for_children(const Subtree& parent, F&& f) const {
        for_each_child<VisitOrder::any>(h_, parent, glm::vec4(0, 0, 0, 1), f);
    }

    void count(PageUnit& unit, const Subtree& subtree, std::vector<std::vector<Subtree>>& levels) const {
        unit.items += end_of_own_run(h_, subtree) - h_.nodes()[subtree.node].first_item;
        for_children(subtree, [&](const Subtree& child) {
            ++unit.nodes;
            if (!child.has_stand_in()) return count(unit, child, levels);
            ++unit.stand_ins;
            if (levels.size() <= child.cell.depth) levels.resize(child.cell.depth + std::size_t(1));
            levels[child.cell.depth].push_back(child);
        });
    }

    /// Level by level; in each as their items lie, which is the order that the partition gives to cells.
    void find_units() {
        std::vector<std::vector<Subtree>> levels{{whole_of(h_)}};
        for (std::size_t depth = 0; depth < levels.size(); ++depth) {
            std::sort(levels[depth].begin(), levels[depth].end(),
                      [](const Subtree& a, const Subtree& b) { return a.node < b.node; });
            for (std::size_t i = 0; i < levels[depth].size(); ++i) {
                PageUnit unit{levels[depth][i], 1};
                count(unit, unit.subtree, levels);
                unit_of_node_[unit.subtree.node] = std::uint32_t(units_.size());
                units_.push_back(unit);
            }
        }
    }

    void place_units(const PageOptions& options) {
        std::uint64_t needed = 0;
        for (const PageUnit& u : units_) {
            const std::uint64_t bytes = Records::layout(u.nodes + std::uint64_t(1), u.stand_ins, u.items).end;
            needed = std::max(needed, bytes);
            if (bytes > most_page_bytes) {
                fail<std::invalid_argument>("farfield::save_pages: the cell of " + std::to_string(u.items) +
                                            " primitives at level " + std::to_string(u.subtree.cell.depth) +
                                            " has no parts and is more than a page can hold");
            }
        }
        page_bytes_ = std::uint32_t(Records::page_bytes(std::max(options.page_bytes, 1u), needed));
        std::uint64_t nodes = 0, stand_ins = 0, items = 0;
        std::uint32_t page = 0, number = 0;
        unsigned level = 0;
        for (PageUnit& u : units_) {
            nodes += u.nodes;
            stand_ins += u.stand_ins;
            items += u.items;
            const bool fits = Records::layout(nodes + 1, stand_ins, items).end <= page_bytes_ &&
                              number < most_units_of_page && u.subtree.cell.depth == level;
            if (!fits) {
                if (number != 0) ++page;
                number = 0;
                level = u.subtree.cell.depth;
                nodes = u.nodes;
                stand_ins = u.stand_ins;
                items = u.items;
            }
            u.page = page;
            u.number = number++;
        }
        page_count_ = page + 1;
    }

    Node portal_of_unit(std::uint32_t unit) const {
        const PageUnit& u = units_[unit];
        const Node& node = h_.nodes()[u.subtree.node];
        return portal_to({u.page, u.number, u.subtree.end_item - node.first_item}, node);
    }

    template <class Write>
    void write_header(Write&& write) const {
        std::vector<std::byte> rest = bytes_of(h_.partition_policy());
        const auto append = [&](std::span<const std::byte> bytes) { rest.insert(rest.end(), bytes.begin(), bytes.end()); };
        append(bytes_of<stored_approximation_of<typename H::approximation_type>>(h_.approximation_policy()));
        append(bytes_of(h_.cost_policy()));
        PageFileHeader header;
        header.option_bytes = std::uint32_t(rest.size());
        header.records = page_records<H, P>();
        header.page_bytes = page_bytes_;
        header.page_count = page_count_;
        header.level_count = units_.back().subtree.cell.depth + 1u;
        header.first_page = (sizeof header + rest.size() + page_file_alignment - 1) / page_file_alignment * page_file_alignment;
        header.file_bytes = header.first_page + std::uint64_t(page_count_) * page_bytes_;
        header.node_count = h_.nodes().size();
        header.facts = h_.facts();
        header.root = portal_of_unit(0);
        header.root.first_item = 0;
        header.checksum_of_options = Xxh64::of(rest);
        header.checksum =
            Xxh64::of(std::as_bytes(std::span(&header, 1)).first(offsetof(PageFileHeader, checksum)));
        std::vector<std::byte> bytes(std::size_t(header.first_page));
        std::memcpy(bytes.data(), &header, sizeof header);
        std::copy(rest.begin(), rest.end(), bytes.begin() + sizeof header);
        write(std::span<const std::byte>(bytes));
    }

    struct PageParts {
        std::vector<Node> nodes;
        std::vector<typename H::node_data> node_data;
        std::vector<typename H::stand_in_data> stand_ins;
        std::vector<P> items;
    };

    void add_own_run(const Subtree& subtree) {
        const std::uint32_t end = end_of_own_run(h_, subtree);
        for (std::uint32_t at = h_.nodes()[subtree.node].first_item; at < end; ++at) {
            parts_.items.push_back(primitives_[h_.order().empty() ? at : h_.order()[at]]);
        }
    }

    /// The contents of a node that has a place already.
    void add_contents(const Subtree& subtree, std::uint32_t place) {
        const Node& node = h_.nodes()[subtree.node];
        parts_.nodes[place] = node;
        parts_.nodes[place].first_item = std::uint32_t(parts_.items.size());
        parts_.node_data[place] = h_.data_of(subtree.node);
        add_own_run(subtree);
        if (node.child_mask == 0) return;
        const auto first = std::uint32_t(parts_.nodes.size());
        parts_.nodes[place].first_child = first;
        parts_.nodes[place].first_child_data = std::uint32_t(parts_.stand_ins.size());
        parts_.nodes.resize(first + std::size_t(std::popcount(node.child_mask)));
        parts_.node_data.resize(parts_.nodes.size());
        std::uint32_t at = first;
        for_children(subtree, [&](const Subtree& child) {
            if (child.has_stand_in()) parts_.stand_ins.push_back(h_.stand_ins()[child.stand_in]);
        });
        for_children(subtree, [&](const Subtree& child) {
            if (!child.has_stand_in()) return add_contents(child, at++);
            Node& portal = parts_.nodes[at];
            portal = portal_of_unit(unit_of_node_[child.node]);
            portal.first_item = std::uint32_t(parts_.items.size());
            parts_.node_data[at++] = h_.data_of(child.node);
        });
    }

    void fill(std::span<std::byte> page, std::span<const PageUnit> units, std::uint32_t number) {
        parts_ = {};
        parts_.nodes.resize(units.size() + 1);
        parts_.node_data.resize(units.size() + 1);
        for (std::size_t i = 0; i < units.size(); ++i) add_contents(units[i].subtree, std::uint32_t(i));
        parts_.nodes[units.size()].first_item = std::uint32_t(parts_.items.size());
        const PageLayout at = Records::layout(parts_.nodes.size(), parts_.stand_ins.size(), parts_.items.size());
        PageHeader header;
        header.number = number;
        header.level = units.front().subtree.cell.depth;
        header.unit_count = std::uint32_t(units.size());
        header.node_count = std::uint32_t(parts_.nodes.size());
        header.stand_in_count = std::uint32_t(parts_.stand_ins.size());
        header.item_count = std::uint32_t(parts_.items.size());
        header.used_bytes = at.end;
        header.fingerprint = h_.fingerprint();
        std::fill(page.begin(), page.end(), std::byte(0));
        const auto put = [&](std::uint32_t to, const auto& records) {
            using T = typename std::remove_reference_t<decltype(records)>::value_type;
            if (!std::is_empty_v<T> && !records.empty()) {
                std::memcpy(page.data() + to, records.data(), records.size() * sizeof(T));
            }
        };
        put(at.nodes, parts_.nodes);
        put(at.node_data, parts_.node_data);
        put(at.stand_ins, parts_.stand_ins);
        put(at.items, parts_.items);
        std::memcpy(page.data(), &header, sizeof header);
        header.checksum = checksum_of_page(page, header.used_bytes);
        std::memcpy(page.data(), &header, sizeof header);
    }

    const H& h_;
    std::span<const P> primitives_;
    std::vector<PageUnit> units_;
    std::vector<std::uint32_t> unit_of_node_;
    std::uint32_t page_bytes_ = 0, page_count_ = 0;
    PageParts parts_;
};

}  // namespace detail

/// Writes beside `path` and renames, as save() does. Equal hierarchies give equal files. Throws std::invalid_argument
/// for other primitives than the hierarchy was built from, or if one node alone holds more than 64 MiB;
/// std::runtime_error that names the file if it cannot be written.
template <Pageable H, PageablePrimitive P>
void save_pages(const H& hierarchy, std::span<const P> primitives, const std::filesystem::path& path,
                const PageOptions& options = {}) {
    detail::PageWriter<H, P> writer(hierarchy, primitives, options);
    detail::ReplacingFile file(path);
    writer.write([&](std::span<const std::byte> bytes) { file.write(bytes); });
    file.replace_target();
}
template <Pageable H, PageablePrimitive P>
void save_pages(const H& hierarchy, const std::vector<P>& primitives, const std::filesystem::path& path,
                const PageOptions& options = {}) {
    save_pages(hierarchy, std::span<const P>(primitives), path, options);
}

/// The bytes of the same file, in memory.
template <Pageable H, PageablePrimitive P>
std::vector<std::byte> paged(const H& hierarchy, std::span<const P> primitives, const PageOptions& options = {}) {
    std::vector<std::byte> bytes;
    detail::PageWriter<H, P>(hierarchy, primitives, options).write([&](std::span<const std::byte> part) {
        bytes.insert(bytes.end(), part.begin(), part.end());
    });
    return bytes;
}

}  // namespace farfield
