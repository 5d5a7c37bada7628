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
#include "farfield/geometry/box.hpp"
#include "farfield/paging/contents_reach.hpp"
#include "farfield/paging/page_format.hpp"
#include "farfield/primitive.hpp"
#include "farfield/storage/file_format.hpp"

namespace farfield::detail {

/// Contents that lie in pages of others.
struct UnitElsewhere {
    std::uint32_t page = 0, unit = 0;  ///< the page counted as this forest's are
    std::uint64_t items = 0;
    Node node;  ///< as its own tree has it
    Box contents = Box::empty();
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
        if (!fits()) return;
        place_units();
        for (const Tree& tree : trees_) {
            reach_of_node_.emplace_back(tree.hierarchy->nodes().size());
            contents_.push_back(find_reach(tree, whole_of(*tree.hierarchy), reach_of_node_.back()));
        }
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
        return {u.page, u.number, u.subtree.end_item, trees_[tree].hierarchy->nodes()[0], contents_[tree]};
    }

    /// Calls write(page) for each page, whose numbers are their places; all have page_bytes().
    template <class Write>
    void write(std::uint64_t fingerprint, Write&& write) const {
        std::vector<std::byte> page(page_bytes_);
        for (std::uint32_t p = 0; p < page_count_; ++p) {
            fill(p, page, p, fingerprint);
            write(std::span<const std::byte>(page));
        }
    }
    /// Fills in all bytes of one page, and gives it a number.
    void fill(std::uint32_t page, std::span<std::byte> bytes, std::uint32_t number, std::uint64_t fingerprint) const {
        const auto units = std::span(units_).subspan(first_unit_[page], first_unit_[page + 1] - first_unit_[page]);
        Filling to(bytes, units);
        for (std::size_t i = 0; i < units.size(); ++i) {
            add_contents(to, units[i], units[i].subtree, std::uint32_t(i));
        }
        to.nodes[units.size()] = Node{.first_item = to.items_used};
        PageHeader header;
        header.number = number;
        header.level = units.front().subtree.cell.depth;
        header.unit_count = std::uint32_t(units.size());
        header.node_count = to.nodes_used;
        header.stand_in_count = to.stand_ins_used;
        header.item_count = to.items_used;
        header.used_bytes = to.used_bytes;
        header.fingerprint = fingerprint;
        std::memcpy(bytes.data(), &header, sizeof header);
        sign_page(bytes, header.used_bytes);
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

    /// Fills in how far contents reach, of a subtree's nodes, and returns a box that holds them all.
    static Box find_reach(const Tree& tree, const Subtree& subtree, std::vector<ContentsReach>& reach) {
        const H& h = *tree.hierarchy;
        Box box = is_elsewhere(tree, subtree.node) ? tree.elsewhere[subtree.node].contents : Box::empty();
        const std::uint32_t end = end_of_own_run(h, subtree);
        for (std::uint32_t at = h.nodes()[subtree.node].first_item; at < end; ++at) {
            box.add(local_bounds(item_at(tree, at), h.origin()));
        }
        for_children(tree, subtree, [&](const Subtree& child) { box.add(find_reach(tree, child, reach)); });
        reach[subtree.node] = ContentsReach(box, subtree.cell);
        return box;
    }
    static const P& item_at(const Tree& tree, std::uint32_t position) {
        const auto& order = tree.hierarchy->order();
        return tree.primitives[order.empty() ? position : order[position]];
    }

    /// Page after page, level after level: where a level ends in a page, the next one begins. A page by itself for the
    /// end of each level would be three parts of a hundred of a file.
    void place_units() {
        PageFill fill;
        for (std::size_t i = 0; i < units_.size(); ++i) {
            Unit& u = units_[i];
            PageFill with = fill;
            with.add(u);
            if (i == 0 || with.bytes() > page_bytes_ || i - first_unit_.back() == most_units_of_page) {
                first_unit_.push_back(i);
                with = {};
                with.add(u);
            }
            fill = with;
            u.page = std::uint32_t(first_unit_.size() - 1);
            u.number = std::uint32_t(i - first_unit_.back());
        }
        page_count_ = std::uint32_t(first_unit_.size());
        first_unit_.push_back(units_.size());
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
    /// The arrays of a page, in its bytes, and how much of them is filled in.
    struct Filling {
        using NodeData = typename H::node_data;
        using StandIn = typename H::stand_in_data;
        Node* nodes;
        std::byte *node_data, *stand_ins, *items;  ///< which pages in a build are not aligned for
        std::uint32_t nodes_used, stand_ins_used = 0, items_used = 0, used_bytes;

        Filling(std::span<std::byte> bytes, std::span<const Unit> units) : nodes_used(std::uint32_t(units.size()) + 1) {
            PageFill fill;
            for (const Unit& u : units) fill.add(u);
            const PageLayout at = Records::layout(fill.nodes, fill.stand_ins, fill.items);
            nodes = reinterpret_cast<Node*>(bytes.data() + at.nodes);
            node_data = bytes.data() + at.node_data;
            stand_ins = bytes.data() + at.stand_ins;
            items = bytes.data() + at.items;
            used_bytes = std::uint32_t(at.end);
            const auto clear = [&](std::uint64_t begin, std::uint64_t end) {
                std::fill_n(bytes.begin() + std::ptrdiff_t(begin), end - begin, std::byte(0));
            };
            clear(at.nodes + fill.nodes * sizeof(Node), at.node_data);
            clear(at.node_data + fill.nodes * Records::node_data_bytes, at.stand_ins);
            clear(at.stand_ins + fill.stand_ins * Records::stand_in_bytes, at.items);
            clear(at.end, bytes.size());
        }
        void put(std::uint32_t node, const Node& record, [[maybe_unused]] const NodeData& data) {
            nodes[node] = record;
            nodes[node].first_item = items_used;
            if constexpr (!std::is_empty_v<NodeData>)
                std::memcpy(node_data + std::size_t(node) * sizeof data, &data, sizeof data);
        }
        void add(const StandIn& data) {
            std::memcpy(stand_ins + std::size_t(stand_ins_used++) * sizeof data, &data, sizeof data);
        }
        void add(const P& item) { std::memcpy(items + std::size_t(items_used++) * sizeof item, &item, sizeof item); }
    };

    void add_own_run(Filling& to, const Tree& tree, const Subtree& subtree) const {
        const H& h = *tree.hierarchy;
        const std::uint32_t end = end_of_own_run(h, subtree);
        for (std::uint32_t at = h.nodes()[subtree.node].first_item; at < end; ++at) {
            to.add(item_at(tree, at));
        }
    }

    /// The contents of a node that has a place already.
    void add_contents(Filling& to, const Unit& unit, const Subtree& subtree, std::uint32_t place) const {
        const Tree& tree = trees_[unit.tree];
        const H& h = *tree.hierarchy;
        const Node& node = h.nodes()[subtree.node];
        to.put(place, node, h.data_of(subtree.node));
        add_own_run(to, tree, subtree);
        if (node.child_mask == 0) return;
        const std::uint32_t first = to.nodes_used;
        to.nodes[place].first_child = first;
        to.nodes[place].first_child_data = to.stand_ins_used;
        to.nodes_used += std::uint32_t(std::popcount(node.child_mask));
        for_children(tree, subtree, [&](const Subtree& child) {
            if (child.has_stand_in()) to.add(h.stand_ins()[child.stand_in]);
        });
        std::uint32_t at = first;
        for_children(tree, subtree, [&](const Subtree& child) {
            if (!child.has_stand_in()) return add_contents(to, unit, child, at++);
            to.put(at++, portal_of_child(unit, child), h.data_of(child.node));
        });
    }
    Node portal_of_child(const Unit& unit, const Subtree& child) const {
        const Tree& tree = trees_[unit.tree];
        const Node& node = tree.hierarchy->nodes()[child.node];
        if (is_elsewhere(tree, child.node)) {
            const UnitElsewhere& e = tree.elsewhere[child.node];
            return portal_to({e.page - unit.page, e.unit, std::uint32_t(std::min<std::uint64_t>(e.items, 0xffffffffu)),
                              reach_of_node_[unit.tree][child.node]},
                             e.node);
        }
        const Unit& u = units_[unit_of_node_[unit.tree][child.node]];
        return portal_to(
            {u.page - unit.page, u.number, child.end_item - node.first_item, reach_of_node_[unit.tree][child.node]},
            node);
    }

    static constexpr std::uint32_t no_unit = std::numeric_limits<std::uint32_t>::max();

    std::vector<Tree> trees_;
    std::vector<Unit> units_;                                ///< page by page
    std::vector<std::size_t> first_unit_;                    ///< by page, and where the last one ends
    std::vector<std::uint32_t> root_unit_;                   ///< by tree
    std::vector<std::vector<std::uint32_t>> unit_of_node_;   ///< by tree and node
    std::vector<std::vector<ContentsReach>> reach_of_node_;  ///< likewise
    std::vector<Box> contents_;                              ///< by tree
    std::uint64_t needed_bytes_ = 0;
    std::uint32_t page_bytes_ = 0, page_count_ = 0;
};

}  // namespace farfield::detail
