#include "farfield/frame/subtree.hpp"

#include <algorithm>
#include <functional>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/partition/polygon_bsp.hpp"
#include "farfield/view/local_view.hpp"
#include "support/scenes.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

using Cubes = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
using SharedCubes = SpatialHierarchy<SharedOctree, ColorCube, TriangleCount>;
using Bsp = SpatialHierarchy<PolygonBsp, Exact, TriangleCount>;

const glm::vec4 viewpoint(3, 1, 2, 1);

template <VisitOrder order, class H>
std::vector<Subtree> children_of(const H& h, const Subtree& parent) {
    std::vector<Subtree> out;
    for_each_child<order>(h, parent, viewpoint, [&](const Subtree& child) { out.push_back(child); });
    return out;
}

}  // namespace

TEMPLATE_TEST_CASE("a walk over subtrees meets every node, position and stand-in once, in their order", "", Cubes,
                   SharedCubes, Bsp) {
    for (const std::size_t count : {0u, 1u, 10u, 2000u}) {
        const TestType h = build<TestType>(mixed_triangles(count, 700));
        std::vector<int> nodes(h.nodes().size());
        std::size_t stand_ins = 0, wrong_ends = 0, wrong_cells = 0, met = 0;
        const std::function<void(const Subtree&)> visit = [&](const Subtree& s) {
            ++nodes[s.node];
            const std::size_t met_before = ++met;
            stand_ins += s.has_stand_in();
            std::uint32_t at = s.end_item;
            const auto children = children_of<VisitOrder::any>(h, s);
            if (!children.empty()) at = h.nodes()[children[0].node].first_item;
            // Own run, then the children's subtrees without gaps.
            wrong_ends += at < h.nodes()[s.node].first_item || at > s.end_item;
            for (const Subtree& child : children) {
                wrong_ends += h.nodes()[child.node].first_item != at;
                at = child.end_item;
                wrong_cells += child.cell.depth != s.cell.depth + 1;
                visit(child);
            }
            wrong_ends += at != s.end_item;
            if (!children.empty())
                wrong_ends +=
                    met - met_before != detail::end_of_nodes_below(h.nodes(), s.node) - h.nodes()[s.node].first_child;
        };
        const Subtree whole = whole_of(h);
        CHECK(whole.node == 0);
        CHECK(whole.end_item == h.item_count());
        CHECK(whole.has_stand_in() == (h.root_stand_in() != nullptr));
        CHECK(whole.crossed_planes == all_planes);
        visit(whole);
        CHECK(std::all_of(nodes.begin(), nodes.end(), [](int n) { return n == 1; }));
        CHECK(stand_ins == h.stand_ins().size());
        CHECK(wrong_ends == 0);
        CHECK(wrong_cells == 0);
    }
}

TEST_CASE("a child has the stand-in that its rank says") {
    // Each stand-in's cell is that of the node that it is met at: nodes with one are numbered as they are.
    const Cubes h = build<Cubes>(mixed_triangles(3000, 701));
    std::vector<std::uint32_t> node_of(h.stand_ins().size(), 0xffffffffu);
    const std::function<void(const Subtree&)> visit = [&](const Subtree& s) {
        if (s.has_stand_in()) node_of[s.stand_in] = s.node;
        for (const Subtree& child : children_of<VisitOrder::any>(h, s)) visit(child);
    };
    visit(whole_of(h));
    CHECK(h.stand_ins().size() > 50);
    CHECK(std::is_sorted(node_of.begin(), node_of.end()));
    CHECK(std::adjacent_find(node_of.begin(), node_of.end()) == node_of.end());
}

TEMPLATE_TEST_CASE("children come in the order of the partition, or in its reverse", "", Cubes, SharedCubes, Bsp) {
    const TestType h = build<TestType>(mixed_triangles(2000, 702));
    std::size_t compared = 0;
    const std::function<void(const Subtree&)> visit = [&](const Subtree& s) {
        const auto number = [](const Subtree& child) { return child.node; };
        std::vector<std::uint32_t> any, front, back, expected;
        for (const auto& c : children_of<VisitOrder::any>(h, s)) any.push_back(number(c));
        for (const auto& c : children_of<VisitOrder::front_to_back>(h, s)) front.push_back(number(c));
        for (const auto& c : children_of<VisitOrder::back_to_front>(h, s)) back.push_back(number(c));
        CHECK(std::is_sorted(any.begin(), any.end()));
        ChildOrder order{};
        h.partition_policy().front_to_back(s.cell, h.data_of(s.node), viewpoint, order);
        const Node& node = h.nodes()[s.node];
        for (const unsigned child : order) {
            if ((node.child_mask >> child & 1) == 0) continue;
            const auto rank = unsigned(std::popcount(unsigned(node.child_mask) & ((1u << child) - 1)));
            expected.push_back(node.first_child + rank);
        }
        CHECK(front == expected);
        std::reverse(expected.begin(), expected.end());
        CHECK(back == expected);
        compared += expected.size() > 1;
        for (const Subtree& child : children_of<VisitOrder::any>(h, s)) visit(child);
    };
    visit(whole_of(h));
    CHECK(compared > 20);
}

TEST_CASE("planes that a cell does not cross are not asked below it, and the answer is the same") {
    const Cubes h = build<Cubes>(mixed_triangles(3000, 703));
    std::size_t outside = 0, inside = 0, different = 0, widened = 0;
    for (const View& view :
         {looking({2, 1, 1}), looking({0.1, 0.2, 0.3}, {1, 1, 0}), looking_orthographic({3, 1, 2}, {0.5, 0, 0}, 1)}) {
        const LocalView local(view, glm::dvec3(0), 4);
        const std::function<void(Subtree)> visit = [&](Subtree s) {
            const PlaneMask crossed =
                crossed_planes(local.planes, s.cell.bounds_center, s.cell.bounds_half, all_planes);
            const bool is_out = is_outside(local.planes, s);
            different += is_out != (crossed == outside_a_plane);
            different += !is_out && s.crossed_planes != crossed;
            outside += is_out;
            inside += s.crossed_planes == 0;
            if (is_out) return;
            for (const Subtree& child : children_of<VisitOrder::any>(h, s)) {
                widened += child.crossed_planes != s.crossed_planes;
                visit(child);
            }
        };
        visit(whole_of(h));
    }
    CHECK(different == 0);
    CHECK(widened == 0);
    CHECK(outside > 20);
    CHECK(inside > 20);
}
