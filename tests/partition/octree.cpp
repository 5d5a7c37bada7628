#include "farfield/partition/octree.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/spatial_hierarchy.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::test;

TEMPLATE_TEST_CASE("the root is a cube around everything", "[partition]", Octree, SharedOctree) {
    Random random(12);
    for (int i = 0; i < 500; ++i) {
        Box b = Box::empty();
        const glm::vec3 at = random.in_cube(i % 2 ? 1000.0f : 1.0f);
        b.add(at);
        b.add(at + random.in_cube(1));
        const Cell root = TestType{}.root(b);
        CHECK((root.half.x == root.half.y && root.half.y == root.half.z));
        CHECK(root.half.x == 0.5f * b.largest_side());
        CHECK(root.depth == 0);
        const float step = 1000 * std::numeric_limits<float>::epsilon();
        const Box box{root.box().lower - step, root.box().upper + step};
        CHECK((box.contains(b.lower) && box.contains(b.upper)));
        CHECK((root.bounds().contains(root.box().lower) && root.bounds().contains(root.box().upper)));
    }
    CHECK(TestType{}.root(Box::empty()).half == glm::vec3(0));
}

TEMPLATE_TEST_CASE("children tile their parent", "[partition]", Octree, SharedOctree) {
    Random random(13);
    for (int i = 0; i < 200; ++i) {
        const glm::vec3 corner = random.in_cube(4);
        Cell cell = TestType{}.root({corner, corner + glm::vec3(random.between(0.1f, 3))});
        for (int level = 0; level < 8; ++level) {
            Box whole = Box::empty();
            for (unsigned c = 0; c < 8; ++c) {
                const Cell child = TestType{}.child(cell, {}, c);
                CHECK(child.half == cell.half * 0.5f);
                CHECK(child.depth == cell.depth + 1);
                for (int axis = 0; axis < 3; ++axis)
                    CHECK((child.center[axis] > cell.center[axis]) == ((c >> axis & 1) != 0));
                whole.add(child.box());
            }
            CHECK(glm::length(whole.lower - cell.box().lower) < 1e-5f);
            CHECK(glm::length(whole.upper - cell.box().upper) < 1e-5f);
            cell = TestType{}.child(cell, {}, random.below(8));
        }
    }
}

TEMPLATE_TEST_CASE("front to back is the order in which rays meet the cells", "[partition]", Octree, SharedOctree) {
    Random random(14);
    int met = 0, wrong = 0;
    for (int i = 0; i < 4000; ++i) {
        Cell cell = TestType{}.root({{-1, -1, -1}, {1, 1, 1}});
        const bool direction = i % 3 == 0;
        glm::vec3 eye = random.in_cube(i % 2 ? 1.0f : 4.0f), towards = random.direction();
        // On the planes between the children, and looking along them.
        if (i % 5 == 0) eye[int(random.below(3))] = 0;
        if (i % 7 == 0) eye = glm::vec3(0);
        if (i % 11 == 0) {
            towards[int(random.below(3))] = 0;
            towards = glm::normalize(towards);
        }
        ChildOrder order{};
        TestType{}.front_to_back(cell, {}, direction ? glm::vec4(-towards, 0) : glm::vec4(eye, 1), order);
        std::array<int, 8> position{};
        ChildOrder sorted = order;
        std::sort(sorted.begin(), sorted.end());
        CHECK(sorted == ChildOrder{0, 1, 2, 3, 4, 5, 6, 7});
        for (int k = 0; k < 8; ++k) position[order[std::size_t(k)]] = k;
        for (int ray = 0; ray < 8; ++ray) {
            // From a point of the cell back to the eye, or along the common direction.
            const glm::vec3 through = random.in_cube(1);
            const glm::vec3 along = direction ? towards : through - eye;
            const glm::vec3 from = direction ? through - towards * 5.0f : eye;
            int last = -1;
            for (int s = 0; s < 300; ++s) {
                const glm::vec3 p = from + along * (direction ? float(s) / 30 : 3 * float(s) / 299);
                const glm::vec3 m = glm::abs(p);
                if (std::max({m.x, m.y, m.z}) >= 0.999f || std::min({m.x, m.y, m.z}) <= 0.001f) continue;
                const int at = position[unsigned(p.x > 0) | unsigned(p.y > 0) << 1 | unsigned(p.z > 0) << 2];
                wrong += at < last;
                met += at > last;
                last = at;
            }
        }
    }
    CHECK(wrong == 0);
    CHECK(met > 10000);
}

TEST_CASE("a loose cell's primitives stick out by half its side at most", "[partition]") {
    struct Emit {
        int& child;
        void operator()(unsigned c) const { child = int(c); }
        void keep() const { child = -1; }
    };
    Random random(15);
    int went_down = 0;
    for (int i = 0; i < 20000; ++i) {
        const Cell cell = Octree{}.root({{-1, -1, -1}, {1, 1, 1}});
        Item item;
        const glm::vec3 center = random.in_cube(1),
                        half = glm::vec3(random.unit(), random.unit(), random.unit()) * random.between(0, 0.8f);
        item.bounds = {center - half, center + half};
        int child = 99;
        Octree{}.place(cell, {}, item, archetype::Touches{}, Emit{child});
        CHECK((child == -1) == (item.bounds.largest_side() > cell.half.x));
        if (child < 0) continue;
        ++went_down;
        const Cell into = Octree{}.child(cell, {}, unsigned(child));
        const Box room{into.bounds().lower - 1e-6f, into.bounds().upper + 1e-6f};
        CHECK((room.contains(item.bounds.lower) && room.contains(item.bounds.upper)));
        const Box own{into.box().lower - 1e-6f, into.box().upper + 1e-6f};
        CHECK(own.contains(item.bounds.center()));
    }
    CHECK(went_down > 5000);
}

TEST_CASE("an item as large as a child's cell goes down, and a larger one stays", "[partition]") {
    struct Emit {
        int& child;
        void operator()(unsigned c) const { child = int(c); }
        void keep() const { child = -1; }
    };
    const Cell cell = Octree{}.root({{-1, -1, -1}, {1, 1, 1}});
    REQUIRE(cell.half == glm::vec3(1));
    for (int axis = 0; axis < 3; ++axis) {
        Item item;
        item.bounds = {glm::vec3(0.25f), glm::vec3(0.5f)};
        item.bounds.lower[axis] = 0;
        for (const float side : {0.5f, std::nextafter(1.0f, 0.0f), 1.0f, std::nextafter(1.0f, 2.0f), 1.5f}) {
            item.bounds.upper[axis] = side;
            REQUIRE(item.bounds.largest_side() == side);
            int child = 99;
            Octree{}.place(cell, {}, item, archetype::Touches{}, Emit{child});
            CHECK(child == (side <= 1 ? 7 : -1));
        }
    }
}

TEST_CASE("a shared item that touches no child, by rounding, is not lost", "[partition]") {
    struct Emit {
        std::vector<unsigned>& children;
        void operator()(unsigned c) const { children.push_back(c); }
        void keep() const { children.push_back(99); }
    };
    struct TouchesNothing {
        bool operator()(const Box&) const { return false; }
    };
    Random random(17);
    const Cell cell = SharedOctree{}.root({{-1, -1, -1}, {1, 1, 1}});
    for (int i = 0; i < 1000; ++i) {
        const glm::vec3 center = random.in_cube(i % 2 ? 1.0f : 3.0f);
        Item item;
        item.bounds = {center - 0.01f, center + 0.01f};
        std::vector<unsigned> children;
        SharedOctree{}.place(cell, {}, item, TouchesNothing{}, Emit{children});
        REQUIRE(children.size() == 1);
        // Of all children the nearest.
        float least = std::numeric_limits<float>::infinity();
        unsigned nearest = 0;
        const glm::vec3 middle = item.bounds.center();
        for (unsigned c = 0; c < 8; ++c) {
            const Box box = SharedOctree{}.child(cell, {}, c).box();
            const float off = glm::length(middle - glm::clamp(middle, box.lower, box.upper));
            if (off < least) least = off, nearest = c;
        }
        CHECK(children[0] == nearest);
    }
}

TEST_CASE("a uniform depth is kept to, and an adaptive tree ends at its limit", "[partition]") {
    const Triangles triangles = random_triangles(3000, 16, 0.01f);
    for (const std::uint32_t depth : {1u, 2u, 4u}) {
        const auto h = build<SpatialHierarchy<Octree, ColorCube, TriangleCount>>(
            triangles, {.partition = {.uniform_depth = depth}});
        CHECK(h.report().levels == depth + 1);
        // Every cell above that is not empty is split.
        std::size_t inner = 0;
        for (const Node& n : h.nodes()) inner += n.child_mask != 0;
        CHECK(inner + h.report().leaves == h.nodes().size());
        CHECK(h.report().leaves <= std::size_t(1) << 3 * depth);
    }
    Triangles dense = triangles;
    for (int i = 0; i < 3000; ++i) dense.push_back(moved({triangles[std::size_t(i)]}, 1e-3f)[0]);
    const auto shallow =
        build<SpatialHierarchy<Octree, ColorCube, TriangleCount>>(dense, {.partition = {.max_depth = 3}});
    CHECK(shallow.report().levels <= 4);
    CHECK(shallow.report().cells_at_depth_limit > 0);
    CHECK(build<SpatialHierarchy<Octree, ColorCube, TriangleCount>>(dense).report().levels > 4);
}

TEST_CASE("cells that single precision cannot tell apart are not split", "[partition]") {
    Cell cell;
    cell.center = glm::vec3(1e6f);
    cell.half = glm::vec3(0.0625f);
    Octree::node_data data;
    CHECK(Octree{}.choose(cell, {}, data) == Split::too_deep);
    cell.half = glm::vec3(1);
    CHECK(Octree{}.choose(cell, {}, data) == Split::yes);
    cell.depth = 32;
    CHECK(Octree{}.choose(cell, {}, data) == Split::too_deep);
    CHECK(Octree{.uniform_depth = 40}.choose(cell, {}, data) == Split::always);
    CHECK(Octree{.uniform_depth = 32}.choose(cell, {}, data) == Split::no);
}
