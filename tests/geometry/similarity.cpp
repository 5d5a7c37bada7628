#include "farfield/geometry/similarity.hpp"

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>
#include <stdexcept>

#include "catch.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

glm::mat4 any_similarity(Random& random, float scale) {
    glm::mat4 m = glm::translate(glm::mat4(1), random.in_cube(100));
    m = glm::rotate(m, random.between(-7, 7), random.direction());
    return glm::scale(m, glm::vec3(scale));
}

}  // namespace

TEST_CASE("rotation, uniform scale and translation are taken, with the rounding of many products", "[geometry]") {
    Random random(6);
    for (int i = 0; i < 300; ++i) {
        const float scale = std::pow(10.0f, random.between(-6, 6));
        const glm::mat4 m = any_similarity(random, scale);
        Similarity s;
        REQUIRE_NOTHROW(s = Similarity(m));
        CHECK(std::abs(s.scale() / scale - 1) < 1e-5f);
        const glm::vec3 p = random.in_cube(1);
        const glm::vec3 expected = glm::vec3(m * glm::vec4(p, 1));
        CHECK(glm::length(glm::vec3(s.apply(glm::dvec3(p))) - expected) < 1e-5f * (200 + scale));
    }
    glm::mat4 product(1);
    for (int i = 0; i < 16; ++i) product = product * any_similarity(random, random.between(0.8f, 1.25f));
    CHECK_NOTHROW(Similarity(product));
}

TEST_CASE("what is no similarity is refused", "[geometry]") {
    const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
    const auto refused = [](const glm::mat4& m) { CHECK_THROWS_AS(Similarity(m), std::invalid_argument); };
    refused(glm::scale(glm::mat4(1), {1, 1, 1.001f}));
    refused(glm::scale(glm::mat4(1), {2, 1, 1}));
    refused(glm::scale(glm::mat4(1), {-1, 1, 1}));
    refused(glm::scale(glm::mat4(1), {-1, -1, -1}));
    refused(glm::scale(glm::mat4(1), {1, 1, 0}));
    refused(glm::mat4(0));
    glm::mat4 shear(1);
    shear[1][0] = 0.001f;
    refused(shear);
    glm::mat4 projection(1);
    projection[2][3] = -1;
    refused(projection);
    glm::mat4 twice(1);
    twice[3][3] = 2;
    refused(twice);
    for (int column = 0; column < 4; ++column) {
        for (int row = 0; row < 4; ++row) {
            for (const float bad : {nan, infinity, -infinity}) {
                glm::mat4 m(1);
                m[column][row] = bad;
                refused(m);
            }
        }
    }
    CHECK_NOTHROW(Similarity(glm::scale(glm::mat4(1), {-1, -1, 1})));  // a half turn
}

TEST_CASE("a scale that single precision cannot hold is refused", "[geometry]") {
    for (const double scale : {1e-60, 1e60}) {
        const glm::dmat4 m = glm::scale(glm::dmat4(1), glm::dvec3(scale));
        CHECK_THROWS_AS(Similarity(m), std::invalid_argument);
    }
}

TEST_CASE("the image of a box holds the image of its contents and is tight", "[geometry]") {
    Random random(7);
    for (int i = 0; i < 300; ++i) {
        const Similarity s(any_similarity(random, random.between(0.1f, 10)));
        BoxD box = BoxD::empty();
        box.add(glm::dvec3(random.in_cube(5)));
        box.add(glm::dvec3(random.in_cube(5)));
        const BoxD image = s.apply(box);
        BoxD corners = BoxD::empty();
        for (int c = 0; c < 8; ++c) {
            corners.add(s.apply(glm::dvec3(c & 1 ? box.upper.x : box.lower.x, c & 2 ? box.upper.y : box.lower.y,
                                           c & 4 ? box.upper.z : box.lower.z)));
        }
        const double hair = 1e-11;
        for (int axis = 0; axis < 3; ++axis) {
            CHECK(image.lower[axis] <= corners.lower[axis] + hair);
            CHECK(image.upper[axis] >= corners.upper[axis] - hair);
            CHECK(std::abs(image.lower[axis] - corners.lower[axis]) < 1e-9);
            CHECK(std::abs(image.upper[axis] - corners.upper[axis]) < 1e-9);
        }
    }
    CHECK(Similarity().apply(BoxD::empty()).is_empty());
}
