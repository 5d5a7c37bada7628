#include "farfield/view.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "catch.hpp"
#include "farfield/view/local_view.hpp"
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

namespace {
std::string refusal(const View& view) {
    try {
        view.validate();
        return "taken";
    } catch (const std::invalid_argument& e) {
        return e.what();
    }
}
}  // namespace

TEST_CASE("a field that makes no picture is refused by its name") {
    const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
    View good;
    good.camera = Camera::perspective({0, 0, 1}, {}, {0, 1, 0}, 1);
    CHECK(refusal(View{}) == "taken");
    CHECK(refusal(good) == "taken");
    const auto refused = [&](auto&& change) {
        View v = good;
        change(v);
        return refusal(v);
    };
    const std::string camera = "farfield::Camera: ", view = "farfield::View: ";
    for (const double bad : {double(nan), double(infinity), -double(infinity)}) {
        CHECK(refused([&](View& v) { v.camera.eye.y = bad; }) == camera + "eye must be finite");
        CHECK(refused([&](View& v) { v.camera.off_center.x = bad; }) ==
              camera + "off_center must be finite and within 2^30");
    }
    for (const float bad : {nan, infinity, 2.0f, 0.5f}) {
        CHECK(refused([&](View& v) { v.camera.right *= bad; }) == camera + "right must have length 1");
        CHECK(refused([&](View& v) { v.camera.up *= bad; }) == camera + "up must have length 1");
        CHECK(refused([&](View& v) { v.camera.forward *= bad; }) == camera + "forward must have length 1");
    }
    CHECK(refused([&](View& v) { v.camera.up = v.camera.right; }) ==
          camera + "right, up and forward must be at right angles");
    CHECK(refused([&](View& v) { v.camera.projection = Projection(7); }) ==
          camera + "projection must be perspective or orthographic");
    for (const float bad : {nan, infinity, 0.0f, -1.0f}) {
        CHECK(refused([&](View& v) { v.camera.half_height = bad; }) ==
              camera + "half_height must be above 0 and finite");
        if (bad != 0) {
            CHECK(refused([&](View& v) { v.camera.half_width = bad; }) ==
                  camera + "half_width must be above 0 and finite, or 0");
            CHECK(refused([&](View& v) { v.camera.near_depth = bad; }) ==
                  camera + "near_depth must be 0 or more and finite");
            CHECK(refused([&](View& v) { v.tolerance_px = bad; }) ==
                  view + "tolerance_px must be 0 or more and finite");
        }
        if (bad != infinity) {
            CHECK(refused([&](View& v) { v.camera.far_depth = bad; }) == camera + "far_depth must be above near_depth");
        }
    }
    for (const int bad : {0, -5}) {
        CHECK(refused([&](View& v) { v.width = bad; }) == view + "width must be 1 or more");
        CHECK(refused([&](View& v) { v.height = bad; }) == view + "height must be 1 or more");
    }
    for (const double bad : {-0.1, std::numeric_limits<double>::quiet_NaN()}) {
        CHECK(refused([&](View& v) { v.wanted.rmse = bad; }) == view + "a wanted error must be 0 or more");
    }
    CHECK(refused([](View& v) { v.wanted.samples = 0; }) == view + "wanted samples must be 1 or more");
    CHECK(refused([&](View& v) { v.distance = DistanceMeasure(9); }) ==
          view + "distance must be nearest_point or depth");
    CHECK(refused([](View& v) {
              v.camera.right = {0.6f, 0, 0.8f};  // a mirror's, unlike the one below
              v.camera.forward = {-0.8f, 0, 0.6f};
          }) == "taken");
    CHECK_THROWS_WITH(Camera::perspective({0, 0, 1}, {}, {0, 1, 0}, 60),
                      "farfield::Camera: the field of view must lie between 0 and pi radians; 60 degrees are 1.05");
}

TEST_CASE("a tile is a part of the picture") {
    View whole;
    whole.camera = Camera::perspective({0, 0, 1}, {}, {0, 1, 0}, 1);
    whole.width = 600;
    whole.height = 400;
    const View left = whole.tile(0, 0, 300, 400), upper = whole.tile(0, 0, 600, 100);
    // The camera stays the whole's, to the last bit; where the tile lies in it is told in pixels.
    CHECK(left.camera.off_center == whole.camera.off_center);
    CHECK(upper.camera.half_height == whole.camera.half_height);
    CHECK((left.width == 300 && left.part.left == 0 && left.part.whole_width == 600));
    CHECK((upper.height == 100 && upper.whole_height() == 400));
    const View again = left.tile(150, 200, 150, 200), same = whole.tile(150, 200, 150, 200);
    CHECK((again.part.left == same.part.left && again.part.top == same.part.top));
    CHECK((again.whole_width() == 600 && again.whole_height() == 400));
    // A renderer learns from its LocalView how the tile lies beside the axis.
    CHECK(LocalView(left, {}, 4).off_center == glm::dvec2(-1, 0));
    CHECK(LocalView(upper, {}, 4).off_center == glm::dvec2(0, 3));
    CHECK(LocalView(upper, {}, 4).focal_px == LocalView(whole, {}, 4).focal_px);
    CHECK_THROWS_AS(whole.tile(0, 0, 0, 10), std::invalid_argument);
}
