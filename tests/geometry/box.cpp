#include "farfield/geometry/box.hpp"

#include <limits>

#include "catch.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::test;

TEMPLATE_TEST_CASE("an empty box adds nothing and holds nothing", "[geometry]", float, double) {
    using B = BasicBox<TestType>;
    using V = glm::vec<3, TestType>;
    const B empty = B::empty();
    CHECK(empty.is_empty());
    CHECK_FALSE(empty.is_finite());
    CHECK_FALSE(empty.contains(V(0)));
    B box{V(1, 2, 3), V(4, 5, 6)};
    const B before = box;
    box.add(empty);
    CHECK(box == before);
    B other = empty;
    other.add(before);
    CHECK(other == before);
    CHECK_FALSE(empty.intersects(before));
    B point = empty;
    point.add(V(7, 8, 9));
    CHECK(point == B{V(7, 8, 9), V(7, 8, 9)});
    CHECK_FALSE(point.is_empty());
    CHECK(point.is_finite());
    CHECK(point.size() == V(0));
}

TEST_CASE("boxes are closed", "[geometry]") {
    const Box a{{0, 0, 0}, {1, 1, 1}};
    CHECK(a.contains({0, 0, 0}));
    CHECK(a.contains({1, 1, 1}));
    CHECK_FALSE(a.contains({1, 1, std::nextafter(1.0f, 2.0f)}));
    CHECK(a.intersects({{1, 1, 1}, {2, 2, 2}}));
    CHECK_FALSE(a.intersects({{std::nextafter(1.0f, 2.0f), 0, 0}, {2, 2, 2}}));
    CHECK(a.intersects(a));
}

TEST_CASE("boxes intersect where they have a point in common", "[geometry]") {
    Random random(1);
    int both = 0;
    for (int i = 0; i < 2000; ++i) {
        const auto any = [&] {
            Box b = Box::empty();
            // On a small grid, so that touching is common.
            for (int k = 0; k < 2; ++k) b.add({float(random.below(5)), float(random.below(5)), float(random.below(5))});
            return b;
        };
        const Box a = any(), b = any();
        bool common = false;
        for (int x = 0; x < 125 && !common; ++x) {
            const glm::vec3 p(float(x % 5), float(x / 5 % 5), float(x / 25));
            common = a.contains(p) && b.contains(p);
        }
        both += common;
        CHECK(a.intersects(b) == common);
        CHECK(b.intersects(a) == common);
    }
    CHECK(both > 100);
}

TEST_CASE("boxes near the largest number have a center", "[geometry]") {
    const float most = std::numeric_limits<float>::max();
    const Box all{glm::vec3(-most), glm::vec3(most)}, far{glm::vec3(most), glm::vec3(most)};
    CHECK(all.center() == glm::vec3(0));
    CHECK(far.center() == glm::vec3(most));
    CHECK(Box{{1, 2, 3}, {2, 5, 4}}.largest_side() == 3);
}

TEST_CASE("a box with NaN or infinity anywhere is not finite", "[geometry]") {
    const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
        for (const float bad : {nan, infinity, -infinity}) {
            Box low{{0, 0, 0}, {1, 1, 1}}, high = low;
            low.lower[axis] = bad;
            high.upper[axis] = bad;
            CHECK_FALSE(low.is_finite());
            CHECK_FALSE(high.is_finite());
        }
    }
}
