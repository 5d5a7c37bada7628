#include "farfield/primitive/triangle.hpp"

#include <cmath>
#include <limits>

#include "catch.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::test;

TEST_CASE("a triangle's box is the smallest that holds its corners", "[geometry]") {
    Random random(2);
    for (int i = 0; i < 1000; ++i) {
        Triangle t;
        Box b = Box::empty();
        for (glm::vec3& v : t.vertices) b.add(v = random.in_cube(10));
        CHECK(t.bounds() == b);
        CHECK(VertexColoredTriangle{t.vertices, {}}.bounds() == b);
    }
}

TEST_CASE("a corner that is no number shows in the box, whichever it is", "[geometry]") {
    for (std::size_t corner = 0; corner < 3; ++corner) {
        for (int axis = 0; axis < 3; ++axis) {
            Triangle t{{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}, {}};
            t.vertices[corner][axis] = std::numeric_limits<float>::quiet_NaN();
            INFO("corner " << corner << ", axis " << axis);
            CHECK_FALSE(t.bounds().is_finite());
        }
    }
}

TEST_CASE("area is that of one side", "[geometry]") {
    CHECK(Triangle{{{{0, 0, 0}, {2, 0, 0}, {0, 3, 0}}}, {}}.area() == 3);
    CHECK(VertexColoredTriangle{{{{0, 0, 0}, {0, 2, 0}, {0, 0, 3}}}, {}}.area() == 3);
    CHECK(Triangle{}.area() == 0);
}

TEST_CASE("colors are means in [0, 1]", "[geometry]") {
    CHECK(glm::length(Triangle{{}, {255, 0, 51, 102}}.color() - glm::vec4(1, 0, 0.2f, 0.4f)) < 1e-6f);
    const VertexColoredTriangle t{{}, {{{255, 0, 0, 255}, {0, 255, 0, 255}, {0, 0, 255, 255}}}};
    CHECK(std::abs(t.color().r - 1.0f / 3) < 1e-6f);
    CHECK(std::abs(t.color().a - 1) < 1e-6f);
}
