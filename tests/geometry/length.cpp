// Lengths and normals in units of any size.
#include "farfield/geometry/length.hpp"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "catch.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::test;

TEST_CASE("lengths, directions and normals are the same in units of any power of two", "[geometry]") {
    Random random(940);
    for (int i = 0; i < 300; ++i) {
        const glm::vec3 u = random.in_cube(1), v = random.in_cube(1);
        CHECK(length_of(u) == glm::length(u));
        CHECK(direction_of(u) == glm::normalize(u));
        CHECK(normal_to(u, v) == glm::cross(u, v));
        for (const int exponent : {-100, -70, -40, 40, 70, 100}) {
            const float unit = std::ldexp(1.0f, exponent);
            CHECK(length_of(u * unit) == length_of(u) * unit);
            CHECK(direction_of(u * unit) == direction_of(u));
            CHECK(direction_of(normal_to(u * unit, v * unit)) == direction_of(normal_to(u, v)));
        }
    }
    CHECK(length_of(glm::vec3(0)) == 0);
    CHECK(normal_to(glm::vec3(1e30f, 0, 0), glm::vec3(2e30f, 0, 0)) == glm::vec3(0));
    CHECK(length_of(glm::dvec3(3e200, 4e200, 0)) == Approx(5e200));
    CHECK(length_of(glm::vec3(0x1p-149f, 0, 0)) == 0x1p-149f);
}
