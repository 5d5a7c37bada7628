#include "farfield/geometry/length.hpp"

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "catch.hpp"
#include "support/random.hpp"

using namespace farfield;

TEST_CASE("Lengths, directions and normals are those of any other power of two") {
    test::Random random(5);
    for (int i = 0; i < 200; ++i) {
        const glm::vec3 u = random.in_cube(1), v = random.in_cube(1);
        CHECK(length_of(u) == std::sqrt(glm::dot(u, u)));
        CHECK(direction_of(u) == glm::normalize(u));
        CHECK(normal_to(u, v) == glm::cross(u, v));
        for (const int exponent : {-110, -70, -60, 61, 63, 70, 120}) {
            const float s = std::ldexp(1.0f, exponent);
            CHECK(length_of(u * s) == length_of(u) * s);
            CHECK(direction_of(u * s) == direction_of(u));
            CHECK(direction_of(normal_to(u * s, v * s)) == direction_of(normal_to(u, v)));
        }
    }
}

TEST_CASE("Vectors of nothing, and as long as can be, have a length") {
    CHECK(length_of(glm::vec3(0)) == 0);
    CHECK(length_of(glm::dvec3(0, -3e200, 4e200)) == Approx(5e200));
    const float least = std::numeric_limits<float>::denorm_min();
    CHECK(length_of(glm::vec3(0, least, 0)) == least);
    CHECK(length_of(glm::vec3(1.9e38f)) == Approx(3.29089653e38f));
    CHECK(normal_to(glm::vec3(1, 2, 3), glm::vec3(2, 4, 6)) == glm::vec3(0));
    CHECK(exponent_of(std::numeric_limits<float>::infinity()) == 0);
    CHECK(scaled_to_one(glm::vec3(0)) == glm::vec3(0));
}
