#include "farfield/geometry/triangle_box.hpp"

#include "catch.hpp"
#include "support/random.hpp"
#include "support/triangle_in_box.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

Box grown(const Box& b, float by) {
    return {b.lower - glm::vec3(by), b.upper + glm::vec3(by)};
}

}  // namespace

TEST_CASE("a triangle touches a box where clipping leaves something of it", "[geometry]") {
    Random random(5);
    int touching = 0, unclear = 0;
    for (int i = 0; i < 40000; ++i) {
        Triangle t;
        const float size = i % 4 == 0 ? 3.0f : i % 4 == 1 ? 0.3f : 1.0f;
        const glm::vec3 center = random.in_cube(1.5f);
        for (glm::vec3& v : t.vertices) v = center + random.in_cube(size);
        if (i % 8 == 7) t.vertices[2] = t.vertices[1] + random.in_cube(1e-3f);  // needles
        Box b = Box::empty();
        b.add(random.in_cube(1));
        b.add(random.in_cube(1));
        const bool surely = touches_by_clipping(t, grown(b, -1e-5f)), perhaps = touches_by_clipping(t, grown(b, 1e-5f));
        const bool said = triangle_touches(b, t.vertices[0], t.vertices[1], t.vertices[2]);
        touching += said;
        if (surely) CHECK(said);
        if (!perhaps) CHECK_FALSE(said);
        unclear += perhaps && !surely;
    }
    CHECK(touching > 2000);
    CHECK(unclear < 400);
}

TEST_CASE("touching counts, and triangles without area are segments and points", "[geometry]") {
    const Box b{{-1, -1, -1}, {1, 1, 1}};
    CHECK(triangle_touches(b, {1, 0, 0}, {2, 0, 0}, {2, 1, 0}));
    CHECK(triangle_touches(b, {1, 1, 1}, {2, 2, 2}, {2, 2, 3}));
    CHECK(triangle_touches(b, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}));
    CHECK_FALSE(triangle_touches(b, {2, 0, 0}, {2, 0, 0}, {2, 0, 0}));
    CHECK(triangle_touches(b, {-9, 0, 0}, {9, 0, 0}, {9, 0, 0}));
    CHECK_FALSE(triangle_touches(b, {-3, 0, 0}, {0, 3, 0}, {0, 3, 0}));
    CHECK(triangle_touches({{0, 0, 0}, {0, 0, 0}}, {-1, -1, 0}, {1, -1, 0}, {0, 2, 0}));
    CHECK(triangle_touches(b, {-50, -50, 0}, {50, -50, 0}, {0, 50, 0}));
}
