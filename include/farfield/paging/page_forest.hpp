// Hierarchies in memory are cut into pages: which units go into which page, and the bytes of each.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/vec4.hpp>
#include <limits>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "farfield/frame/subtree.hpp"
#include "farfield/paging/page_format.hpp"
#include "farfield/storage/file_format.hpp"

namespace farfield::detail {

/// Contents that lie in pages of others.
struct UnitElsewhere {
    std::uint32_t page = 0, unit = 0;  ///< the page counted as this forest's are
    std::uint64_t items = 0;
    Node node;  ///< as its own tree has it
};

/// A hierarchy whose pages are to be made, and its primitives. Borrowed.
template <class H, class P>
struct PageTree {
    const H* hierarchy = nullptr;
    std::span<const P> primitives{};
    /// By node: the contents of those leaves that have a stand-in are elsewhere; empty: none are.
    std::span<const UnitElsewhere> elsewhere{};
};

/// Hierarchies side by side, or one. Their units share pages, level by level, in each from tree to tree.
template <Pageable H, PageablePrimitive P>
class PageForest {
    using Records = PageRecords<H, P>;

  public:
    using Tree = PageTree<H, P>;

    /// `page_bytes` 0: as `wanted_bytes` is, or more where a node needs it; otherwise it is what they must fit into.
    PageForest(std::vector<Tree> trees, std::uint64_t wanted_bytes, std::uint32_t page_bytes = 0)
        : trees_(std::move(trees)) {
        find_units();
        for (const Unit& u : units_) {
            needed_bytes_ =
                std::max(needed_bytes_, Records::layout_bytes(u.nodes + std::uint64_t(1), u.stand_ins, u.items));
        }
        page_bytes_ = page_bytes;
        if (page_bytes == 0 && needed_bytes_ <= Records::most_bytes) {
            page_bytes_ = std::uint32_t(Records::page_bytes(wanted_bytes, needed_bytes_));
        }
        if (fits()) place_units();
    }

    /// False if a node by itself holds more than a page may; there are no pages then.
    bool fits() const { return needed_bytes_ <= page_bytes_; }
    /// That one node takes by itself, at most.
    std::uint64_t needed_bytes() const { return needed_bytes_; }
    std::uint32_t page_bytes() const { return page_bytes_; }
    std::uint32_t page_count() const { return page_count_; }
    unsigned level_count() const { return units_.empty() ? 0u : units_.back().subtree.cell.depth + 1u; }

    /// Where the contents of a tree's root are. It is as if elsewhere, with pages counted from this forest's first.
    UnitElsewhere root_of(std::size_t tree) const {
        const Unit& u = units_[root_unit_[tree]];
        return {u.page, u.number, u.subtree.end_item, trees_[tree].hierarchy->nodes()[0]};
    }

    /// Calls write(page) for each page, whose numbers are `first_number` and on; all have page_bytes().
    template <class Write>
    void write(std::uint32_t first_number, std::uint64_t fingerprint, Write&& write) {
        std::vector<std::byte> page(page_bytes_);
        for (std::size_t first = 0, number = 0; first < units_.size(); ++number) {
            std::size_t end = first;
            while (end < units_.size() && units_[end].page == number) ++end;
            fill(page, std::span(units_).subspan(first, end - first), first_number + std::uint32_t(number),
                 fingerprint);
            write(std::span<const std::byte>(page));
            first = end;
        }
    }

  private:
    struct Unit {
        Subtree subtree;
        std::uint32_t tree = 0;
        std::uint32_t nodes = 1, stand_ins = 0, items = 0;  ///< that it adds to its page, its root included
        std::uint32_t page = 0, number = 0;                 ///< the page, and which unit of it
    };

    /// Calls f(child) for each child, in the partition's own order.
    template <class F>
    static void for_children(const Tree& tree, const Subtree& parent, F&& f) {
        for_each_child<VisitOrder::any>(*tree.hierarchy, parent, glm::vec4(0, 0, 0, 1), f);
    }

    using Levels = std::vector<std::vector<Unit>>;

    void count(Unit& unit, const Subtree& subtree, Levels& levels) const {
        const Tree& tree = trees_[unit.tree];
        const H& h = *tree.hierarchy;
        unit.items += end_of_own_run(h, subtree) - h.nodes()[subtree.node].first_item;
        for_children(tree, subtree, [&](const Subtree& child) {
            ++unit.nodes;
            if (!child.has_stand_in()) return count(unit, child, levels);
            ++unit.stand_ins;
            if (is_elsewhere(tree, child.node)) return;
            if (levels.size() <= child.cell.depth) levels.resize(child.cell.depth + std::size_t(1));
            levels[child.cell.depth].push_back({child, unit.tree});
        });
    }
    static bool is_elsewhere(const Tree& tree, std::uint32_t node) {
        return !tree.elsewhere.empty() && tree.hierarchy->nodes()[node].child_mask == 0;
    }

    /// Level by level; in each as nodes lie, which is the order that the partition gives to cells.
    void find_units() {
        Levels levels;
        for (std::size_t t = 0; t < trees_.size(); ++t) {
            const Subtree whole = whole_of(*trees_[t].hierarchy);
            if (levels.size() <= whole.cell.depth) levels.resize(whole.cell.depth + std::size_t(1));
            levels[whole.cell.depth].push_back({whole, std::uint32_t(t)});
            unit_of_node_.emplace_back(trees_[t].hierarchy->nodes().size(), no_unit);
        }
        for (std::size_t depth = 0; depth < levels.size(); ++depth) {
            std::sort(levels[depth].begin(), levels[depth].end(), [](const Unit& a, const Unit& b) {
                return a.tree != b.tree ? a.tree < b.tree : a.subtree.node < b.subtree.node;
            });
            for (std::size_t i = 0; i < levels[depth].size(); ++i) {
                Unit unit = levels[depth][i];
                count(unit, unit.subtree, levels);
                unit_of_node_[unit.tree][unit.subtree.node] = std::uint32_t(units_.size());
                units_.push_back(unit);
            }
            levels[depth] = {};
        }
        for (std::size_t t = 0; t < trees_.size(); ++t) root_unit_.push_back(unit_of_node_[t][0]);
    }

    /// A page holds units of one level, or all of several that fit: the first levels of a tree are small.
    void place_units() {
        PageFill fill;
        std::uint32_t page = 0, number = 0;
        for (std::size_t first = 0; first < units_.size();) {
            const std::size_t end = end_of_level(first);
            PageFill level = fill;
            for (std::size_t i = first; i < end; ++i) level.add(units_[i]);
            const bool fits = level.bytes() <= page_bytes_ && number + (end - first) <= most_units_of_page;
            if (!fits && number != 0) {
                ++page;
                number = 0;
                fill = {};
            }
            for (; first < end; ++first) {
                Unit& u = units_[first];
                fill.add(u);
                if (fill.bytes() > page_bytes_ || number == most_units_of_page) {
                    ++page;
                    number = 0;
                    fill = {};
                    fill.add(u);
                }
                u.page = page;
                u.number = number++;
            }
        }
        page_count_ = units_.empty() ? 0 : page + 1;
    }
    struct PageFill {
        std::uint64_t nodes = 1, stand_ins = 0, items = 0;
        void add(const Unit& u) {
            nodes += u.nodes;
            stand_ins += u.stand_ins;
            items += u.items;
        }
        std::uint64_t bytes() const { return Records::layout_bytes(nodes, stand_ins, items); }
    };
    std::size_t end_of_level(std::size_t first) const {
        std::size_t end = first;
        while (end < units_.size() && units_[end].subtree.cell.depth == units_[first].subtree.cell.depth) ++end;
        return end;
    }

    struct PageParts {
        std::vector<Node> nodes;
        std::vector<typename H::node_data> node_data;
        std::vector<typename H::stand_in_data> stand_ins;
        std::vector<P> items;

        void clear() {
            nodes.clear();
            node_data.clear();
            stand_ins.clear();
            items.clear();
        }
    };

    void add_own_run(const Tree& tree, const Subtree& subtree) {
        const H& h = *tree.hierarchy;
        const std::uint32_t end = end_of_own_run(h, subtree);
        for (std::uint32_t at = h.nodes()[subtree.node].first_item; at < end; ++at) {
            parts_.items.push_back(tree.primitives[h.order().empty() ? at : h.order()[at]]);
        }
    }

    /// The contents of a node that has a place already.
    void add_contents(const Unit& unit, const Subtree& subtree, std::uint32_t place) {
        const Tree& tree = trees_[unit.tree];
        const H& h = *tree.hierarchy;
        const Node& node = h.nodes()[subtree.node];
        parts_.nodes[place] = node;
        parts_.nodes[place].first_item = std::uint32_t(parts_.items.size());
        parts_.node_data[place] = h.data_of(subtree.node);
        add_own_run(tree, subtree);
        if (node.child_mask == 0) return;
        const auto first = std::uint32_t(parts_.nodes.size());
        parts_.nodes[place].first_child = first;
        parts_.nodes[place].first_child_data = std::uint32_t(parts_.stand_ins.size());
        parts_.nodes.resize(first + std::size_t(std::popcount(node.child_mask)));
        parts_.node_data.resize(parts_.nodes.size());
        for_children(tree, subtree, [&](const Subtree& child) {
            if (child.has_stand_in()) parts_.stand_ins.push_back(h.stand_ins()[child.stand_in]);
        });
        std::uint32_t at = first;
        for_children(tree, subtree, [&](const Subtree& child) {
            if (!child.has_stand_in()) return add_contents(unit, child, at++);
            Node& portal = parts_.nodes[at];
            portal = portal_of_child(unit, child);
            portal.first_item = std::uint32_t(parts_.items.size());
            parts_.node_data[at++] = h.data_of(child.node);
        });
    }
    Node portal_of_child(const Unit& unit, const Subtree& child) const {
        const Tree& tree = trees_[unit.tree];
        const Node& node = tree.hierarchy->nodes()[child.node];
        if (is_elsewhere(tree, child.node)) {
            const UnitElsewhere& e = tree.elsewhere[child.node];
            return portal_to({e.page - unit.page, e.unit, std::uint32_t(std::min<std::uint64_t>(e.items, 0xffffffffu))},
                             e.node);
        }
        const Unit& u = units_[unit_of_node_[unit.tree][child.node]];
        return portal_to({u.page - unit.page, u.number, child.end_item - node.first_item}, node);
    }

    void fill(std::span<std::byte> page, std::span<const Unit> units, std::uint32_t number, std::uint64_t fingerprint) {
        parts_.clear();
        parts_.nodes.resize(units.size() + 1);
        parts_.node_data.resize(units.size() + 1);
        for (std::size_t i = 0; i < units.size(); ++i) {
            add_contents(units[i], units[i].subtree, std::uint32_t(i));
        }
        parts_.nodes[units.size()].first_item = std::uint32_t(parts_.items.size());
        const PageLayout at = Records::layout(parts_.nodes.size(), parts_.stand_ins.size(), parts_.items.size());
        PageHeader header;
        header.number = number;
        header.level = units.front().subtree.cell.depth;
        header.unit_count = std::uint32_t(units.size());
        header.node_count = std::uint32_t(parts_.nodes.size());
        header.stand_in_count = std::uint32_t(parts_.stand_ins.size());
        header.item_count = std::uint32_t(parts_.items.size());
        header.used_bytes = std::uint32_t(at.end);
        header.fingerprint = fingerprint;
        std::fill(page.begin(), page.end(), std::byte(0));
        const auto put = [&](std::uint64_t to, const auto& records) {
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

    static constexpr std::uint32_t no_unit = std::numeric_limits<std::uint32_t>::max();

    std::vector<Tree> trees_;
    std::vector<Unit> units_;                               ///< page by page
    std::vector<std::uint32_t> root_unit_;                  ///< by tree
    std::vector<std::vector<std::uint32_t>> unit_of_node_;  ///< by tree and node
    std::uint64_t needed_bytes_ = 0;
    std::uint32_t page_bytes_ = 0, page_count_ = 0;
    PageParts parts_;  ///< of the page that is being filled
};

/// The first bytes of a file of pages, up to its first page.
template <Pageable H, PageablePrimitive P>
std::vector<std::byte> page_file_head(const typename H::partition_type& partition,
                                      const typename H::approximation_type& approximation,
                                      const typename H::cost_model_type& cost, const HierarchyFacts& facts,
                                      const UnitElsewhere& root, std::uint32_t page_bytes, std::uint32_t page_count,
                                      unsigned level_count) {
    std::vector<std::byte> options = bytes_of(partition);
    for (const auto& more :
         {bytes_of<stored_approximation_of<typename H::approximation_type>>(approximation), bytes_of(cost)}) {
        options.insert(options.end(), more.begin(), more.end());
    }
    PageFileHeader header;
    header.records = page_records<H, P>();
    header.option_bytes = std::uint32_t(options.size());
    header.page_bytes = page_bytes;
    header.page_count = page_count;
    header.level_count = level_count;
    header.first_page =
        (sizeof header + options.size() + page_file_alignment - 1) / page_file_alignment * page_file_alignment;
    header.file_bytes = header.first_page + std::uint64_t(page_count) * page_bytes;
    header.node_count = facts.report.nodes;
    header.facts = facts;
    header.root =
        portal_to({root.page, root.unit, std::uint32_t(std::min<std::uint64_t>(root.items, 0xffffffffu))}, root.node);
    header.root.first_item = 0;
    header.checksum_of_options = Xxh64::of(options);
    header.checksum = Xxh64::of(std::as_bytes(std::span(&header, 1)).first(offsetof(PageFileHeader, checksum)));
    std::vector<std::byte> bytes(std::size_t(header.first_page));
    std::memcpy(bytes.data(), &header, sizeof header);
    std::copy(options.begin(), options.end(), bytes.begin() + sizeof header);
    return bytes;
}

}  // namespace farfield::detail
