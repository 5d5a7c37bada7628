// What Node, Cell and the stand-ins promise, node by node, for every composable triple; brute force is the oracle.
#include "farfield/spatial_hierarchy.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/viewer.hpp"
#include "support/pictures.hpp"
#include "support/scenes.hpp"
#include "support/triangle_in_box.hpp"
#include "support/variants.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

std::uint32_t primitive_at(const AnyHierarchy& h, std::uint32_t position) {
    return h.order().empty() ? position : h.order()[position];
}

Box widened(const Box& b, float by) {
    return {b.lower - glm::vec3(by), b.upper + glm::vec3(by)};
}
bool holds(const Box& outer, const Box& inner) {
    return outer.contains(inner.lower) && outer.contains(inner.upper);
}

}  // namespace

TEST_CASE("a subtree is one range of nodes, of items and of stand-ins") {
    for (const Variant& variant : all_variants()) {
        // Every pair of nodes is looked at, and a piece has a node or two of its own.
        const Triangles triangles = mixed_triangles(variant.is_clipped ? 700 : 5000, 40);
        INFO(variant.name);
        const auto h = variant.build(triangles);
        const auto nodes = all_nodes(*h);
        const auto tree = h->nodes();
        REQUIRE(nodes.size() == tree.size());
        std::vector<int> seen(tree.size());
        std::vector<long> stand_in_of(tree.size(), -1);
        for (const NodeRef& n : nodes) ++seen[n.index], stand_in_of[n.index] = n.stand_in;
        CHECK(std::all_of(seen.begin(), seen.end(), [](int s) { return s == 1; }));
        // Stand-ins in node order, each named once, by rank.
        long next = 0;
        for (const long s : stand_in_of) {
            if (s >= 0) CHECK(s == next++);
        }
        CHECK(std::size_t(next) == h->stand_in_count());
        CHECK(h->report().stand_ins == h->stand_in_count());
        for (const NodeRef& n : nodes) {
            const Node& node = tree[n.index];
            CHECK(node.first_item <= n.own_end);
            CHECK(n.own_end <= n.end_item);
            CHECK((node.stand_in_mask & ~node.child_mask) == 0);
            if (n.index != n.parent) {
                const Node& parent = tree[n.parent];
                CHECK(parent.first_item <= node.first_item);
                CHECK(n.index >= parent.first_child);
            }
            if (node.child_mask == 0) CHECK(node.first_child == 0);
        }
        // Descendants of a node, and no others, lie in [first_child, end_node).
        std::vector<std::uint32_t> parent(tree.size());
        for (const NodeRef& n : nodes) parent[n.index] = n.parent;
        for (const NodeRef& n : nodes) {
            if (tree[n.index].child_mask == 0) continue;
            for (std::uint32_t i = 1; i < tree.size(); ++i) {
                bool below = false;
                for (std::uint32_t at = i; at != 0 && !below; at = parent[at]) below = parent[at] == n.index;
                if (below != (i >= tree[n.index].first_child && i < n.end_node)) {
                    FAIL("node " << i << " and the range below node " << n.index);
                }
            }
        }
    }
}

TEST_CASE("every primitive is in its cells") {
    const Triangles triangles = mixed_triangles(4000, 41);
    for (const Variant& variant : all_variants()) {
        INFO(variant.name);
        const auto h = variant.build(triangles);
        // Steps of single precision at the largest coordinate.
        const float hair = 8 * std::numeric_limits<float>::epsilon() * 2;
        std::vector<std::set<std::uint32_t>> cells_of(triangles.size());
        std::size_t outside = 0, untouched = 0, missing = 0;
        const auto nodes = all_nodes(*h);
        for (const NodeRef& n : nodes) {
            for (std::uint32_t at = h->nodes()[n.index].first_item; at < n.own_end; ++at) {
                cells_of[primitive_at(*h, at)].insert(n.index);
                const Triangle& t = triangles[primitive_at(*h, at)];
                if (variant.is_clipped) {
                    for (const glm::vec3& v : h->fragments()[at].vertices) {
                        outside += !widened(t.bounds(), hair).contains(v);
                    }
                } else if (variant.is_shared) {
                    untouched += !touches_by_clipping(t, widened(n.cell.box(), hair));
                } else {
                    outside += !holds(widened(n.cell.bounds(), hair), t.bounds());
                }
            }
            // What is drawn for the subtree is what culling asks about.
            if (variant.is_clipped) {
                for (std::uint32_t at = h->nodes()[n.index].first_item; at < n.end_item; ++at) {
                    // Not by a hair: cells are laid around what is in them.
                    for (const glm::vec3& v : h->fragments()[at].vertices) outside += !n.cell.bounds().contains(v);
                }
            } else if (!variant.is_shared) {
                for (std::uint32_t at = h->nodes()[n.index].first_item; at < n.end_item; ++at) {
                    outside += !holds(widened(n.cell.bounds(), hair), triangles[primitive_at(*h, at)].bounds());
                }
            }
            // Shared: nothing that touches a leaf is missing from it.
            if (variant.is_shared && h->nodes()[n.index].child_mask == 0) {
                std::set<std::uint32_t> own;
                for (std::uint32_t at = h->nodes()[n.index].first_item; at < n.own_end; ++at) {
                    own.insert(primitive_at(*h, at));
                }
                for (std::uint32_t i = 0; i < triangles.size(); ++i) {
                    missing += !own.count(i) && touches_by_clipping(triangles[i], widened(n.cell.box(), -hair));
                }
                CHECK(own.size() == n.own_end - h->nodes()[n.index].first_item);
            }
        }
        CHECK(outside == 0);
        CHECK(untouched == 0);
        CHECK(missing == 0);
        for (const auto& cells : cells_of) {
            CHECK(!cells.empty());
            if (!variant.is_shared && !variant.is_clipped) CHECK(cells.size() == 1);
        }
    }
}

TEST_CASE("levels to the last stand-in are counted right") {
    const Triangles triangles = mixed_triangles(6000, 42);
    for (const Variant& variant : all_variants()) {
        INFO(variant.name);
        const auto h = variant.build(triangles);
        const auto nodes = all_nodes(*h);
        std::vector<int> deepest(h->nodes().size(), -1);
        std::size_t wrong = 0;
        for (std::size_t i = nodes.size(); i-- > 0;) {
            const NodeRef& n = nodes[i];
            if (deepest[n.index] < 0 && n.stand_in >= 0) deepest[n.index] = 0;
            if (n.index != n.parent && deepest[n.index] >= 0) {
                const int reach = n.stand_in >= 0 ? int(h->nodes()[n.index].levels_replaced) : 0;
                deepest[n.parent] = std::max(deepest[n.parent], std::max(deepest[n.index], reach) + 1);
            }
            const int said = h->nodes()[n.index].stand_in_levels_below;
            wrong += said != (deepest[n.index] < 0 ? int(Node::nothing_below) : deepest[n.index]);
        }
        CHECK(wrong == 0);
    }
}

TEST_CASE("a stand-in is kept only where it is cheaper than what it stands for") {
    const Triangles triangles = mixed_triangles(6000, 43);
    for (const Variant& variant : all_variants()) {
        INFO(variant.name);
        const auto h = variant.build(triangles);
        std::vector<int> cells_with(triangles.size());
        for (std::uint32_t i = 0; i < h->item_count(); ++i) ++cells_with[primitive_at(*h, i)];
        std::size_t dear = 0;
        for (const NodeRef& n : all_nodes(*h)) {
            if (n.stand_in < 0) continue;
            double cost = 0;
            for (std::uint32_t i = h->nodes()[n.index].first_item; i < n.end_item; ++i) {
                cost += variant.is_clipped ? h->cost({.triangles = 1}) * float(h->fragments()[i].vertices.size() - 2)
                                           : h->cost({.triangles = 1}) / float(cells_with[primitive_at(*h, i)]);
            }
            dear += cost * (1 + 1e-5) <= h->cost_of(std::size_t(n.stand_in));
        }
        CHECK(dear == 0);
        CHECK(h->report().stand_ins + h->report().stand_ins_that_would_not_pay ==
              (variant.stands_in ? h->report().nodes : 0));
    }
}

// Asked only of partitions that halve: there a stand-in's size follows from its level.
TEST_CASE("the least error below a cell is a lower bound of every stand-in's error") {
    const Triangles triangles = mixed_triangles(6000, 44);
    Random random(45);
    for (const Variant& variant : all_variants()) {
        if (!variant.stands_in || !variant.has_octants) continue;
        INFO(variant.name);
        const auto h = variant.build(triangles);
        const auto nodes = all_nodes(*h);
        std::vector<std::size_t> place(h->nodes().size());
        for (std::size_t i = 0; i < nodes.size(); ++i) place[nodes[i].index] = i;
        std::size_t wrong = 0, not_a_number = 0;
        for (int i = 0; i < 40; ++i) {
            const glm::vec3 eye = random.in_cube(i % 4 == 0 ? 1.0f : 6.0f);
            const glm::vec3 target = random.in_cube(1);
            View view = i % 2 ? looking(eye, target, 200) : looking_orthographic(eye, target, 2, 200);
            view.distance = i % 3 ? DistanceMeasure::nearest_point : DistanceMeasure::depth;
            const LocalView local = local_view<Triangle>(triangles, view);
            for (const NodeRef& n : nodes) {
                if (n.stand_in < 0) continue;
                const float error = h->error_px(std::size_t(n.stand_in), n.cell, local) *
                                    detail::error_of_replaced_levels(h->nodes()[n.index]);
                not_a_number += std::isnan(error) || error < 0;
                for (NodeRef at = n;; at = nodes[place[at.parent]]) {
                    const float least = h->least_error_px(at.cell, h->nodes()[at.index].stand_in_levels_below, local);
                    not_a_number += std::isnan(least);
                    // A node's own stand-in is asked before the bound on what is below, whatever its reach.
                    const bool is_below = at.index != n.index || h->nodes()[n.index].levels_replaced == 0;
                    wrong += is_below && least > error * 1.00001f;  // single precision may round either way
                    if (at.index == 0) break;
                }
            }
        }
        CHECK(wrong == 0);
        CHECK(not_a_number == 0);
    }
}

TEST_CASE("the error of a cell is at most that of its parent") {
    const Triangles triangles = mixed_triangles(4000, 46);
    for (const Variant& variant : all_variants()) {
        if (!variant.stands_in) continue;
        const auto h = variant.build(triangles);
        const auto nodes = all_nodes(*h);
        const LocalView local = local_view<Triangle>(triangles, looking({2, 1, 0.5}));
        std::size_t wrong = 0;
        std::vector<float> error(h->nodes().size(), -1.0f);
        for (const NodeRef& n : nodes) {
            if (n.stand_in >= 0) error[n.index] = h->error_px(std::size_t(n.stand_in), n.cell, local);
            if (n.stand_in >= 0 && error[n.parent] >= 0) wrong += error[n.index] > error[n.parent] * 1.00001f;
        }
        INFO(variant.name);
        CHECK(wrong == 0);
    }
}

TEST_CASE("the same input gives the same bytes") {
    const Triangles triangles = mixed_triangles(4000, 47), copy = triangles;
    for (const Variant& variant : all_variants()) {
        INFO(variant.name);
        const auto a = variant.build(triangles), b = variant.build(copy);
        CHECK(a->bytes() == b->bytes());
        CHECK(std::ranges::equal(a->fragments().vertices, b->fragments().vertices));
    }
}

TEST_CASE("building in place puts primitives into the order of the hierarchy and changes nothing else") {
    using Cubes = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
    const Triangles triangles = mixed_triangles(4000, 48);
    const Cubes apart = build<Cubes>(triangles);
    Triangles sorted = triangles;
    const Cubes in_place = build_in_place<Cubes>(sorted);
    CHECK(in_place.order().empty());
    REQUIRE(apart.order().size() == triangles.size());
    bool same = true;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        same = same && sorted[i].vertices == triangles[apart.order()[i]].vertices;
    }
    CHECK(same);
    CHECK(std::equal(apart.nodes().begin(), apart.nodes().end(), in_place.nodes().begin(), in_place.nodes().end()));
    CHECK(in_place.bytes() + 4 * triangles.size() == apart.bytes());
    for (const float tolerance : {0.0f, 2.0f}) {
        ZBufferRenderer a, b;
        const View view = looking({9, 2, 4}, {}, 128, tolerance);
        make_viewer(apart, triangles, a).frame(view);
        make_viewer(in_place, sorted, b).frame(view);
        CHECK(a.image() == b.image());
    }
}

TEST_CASE("a hierarchy over nothing draws nothing") {
    using Cubes = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
    const Triangles none;
    for (const Cubes& h : {Cubes(), build<Cubes>(none)}) {
        CHECK(h.bounds().is_empty());
        CHECK(h.item_count() == 0);
        CHECK(h.root_stand_in() == nullptr);
        CHECK(h.nodes().size() == 1);
        ZBufferRenderer renderer;
        const FrameStats stats = make_viewer(h, none, renderer).frame(looking({3, 0, 0}));
        CHECK(stats.primitives == 0);
        CHECK(coverage(renderer.image()) == 0);
    }
}

TEST_CASE("copies of a hierarchy share its arrays and outlive it") {
    using Hierarchy = SpatialHierarchy<Octree, Exact, TriangleCount>;
    const Triangles triangles = random_triangles(1000, 49);
    Hierarchy copy;
    const Node* where = nullptr;
    {
        const Hierarchy h = build<Hierarchy>(triangles);
        copy = h;
        where = h.nodes().data();
    }
    CHECK(copy.nodes().data() == where);
    ZBufferRenderer renderer;
    CHECK(make_viewer(copy, triangles, renderer).frame(looking({3, 0, 0})).primitives > 0);
}
