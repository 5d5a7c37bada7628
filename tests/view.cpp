#include "farfield/view.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>

#include "catch.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::test;

TEST_CASE("a camera's axes are orthonormal and right-handed") {
    Random random(140);
    for (int i = 0; i < 500; ++i) {
        const glm::dvec3 eye = glm::dvec3(random.in_cube(1)) * (i % 2 ? 1.0 : 1e7);
        const Camera c = Camera::perspective(eye, eye + glm::dvec3(random.direction()), random.direction(), 1);
        CHECK(std::abs(glm::length(c.right) - 1) < 1e-6f);
        CHECK(std::abs(glm::length(c.up) - 1) < 1e-6f);
        CHECK(std::abs(glm::dot(c.right, c.up)) < 1e-6f);
        CHECK(glm::length(glm::cross(c.right, c.up) + c.forward) < 1e-5f);
        CHECK(glm::length(glm::cross(c.forward, c.up) - c.right) < 1e-5f);
    }
}

TEST_CASE("numbers that make no camera are refused") {
    const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
    const float fnan = std::numeric_limits<float>::quiet_NaN(), finfinity = std::numeric_limits<float>::infinity();
    const glm::dvec3 eye(0, 0, 1), target(0);
    const glm::vec3 up(0, 1, 0);
    CHECK_NOTHROW(Camera::perspective(eye, target, up, 1));
    for (const float fov : {0.0f, -1.0f, 3.15f, 100.0f, fnan, finfinity}) {
        CHECK_THROWS_AS(Camera::perspective(eye, target, up, fov), std::invalid_argument);
    }
    for (const float height : {0.0f, -1.0f, fnan, finfinity}) {
        INFO("height " << height);
        CHECK_THROWS_AS(Camera::orthographic(eye, target, up, height), std::invalid_argument);
    }
    for (const float near : {-1.0f, fnan, finfinity}) {
        INFO("near depth " << near);
        CHECK_THROWS_AS(Camera::perspective(eye, target, up, 1, near), std::invalid_argument);
    }
    CHECK_THROWS_AS(Camera::perspective(eye, eye, up, 1), std::invalid_argument);
    CHECK_THROWS_AS(Camera::perspective(eye, target, {0, 0, 1}, 1), std::invalid_argument);
    CHECK_THROWS_AS(Camera::perspective(eye, target, {0, 0, -7}, 1), std::invalid_argument);
    CHECK_THROWS_AS(Camera::perspective(eye, target, {0, 0, 0}, 1), std::invalid_argument);
    CHECK_THROWS_AS(Camera::perspective(eye, target, {0, fnan, 0}, 1), std::invalid_argument);
    CHECK_THROWS_AS(Camera::perspective({0, 0, nan}, target, up, 1), std::invalid_argument);
    CHECK_THROWS_AS(Camera::perspective({0, 0, infinity}, target, up, 1), std::invalid_argument);
    CHECK_THROWS_AS(Camera::perspective(eye, {nan, 0, 0}, up, 1), std::invalid_argument);
}
