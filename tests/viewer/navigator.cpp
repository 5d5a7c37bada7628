#include "navigator.hpp"

#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <random>

#include "catch.hpp"

using farfield::BoxD;
using farfield::Camera;
using viewer::Navigator;

namespace {

/// In heights of the picture from its middle, y up.
glm::dvec2 seen_at(const Camera& c, glm::dvec3 p) {
    const glm::dvec3 d = p - c.eye;
    const double depth = glm::dot(d, glm::dvec3(c.forward)), height = 2 * double(c.half_height) * depth;
    return {glm::dot(d, glm::dvec3(c.right)) / height, glm::dot(d, glm::dvec3(c.up)) / height};
}

const BoxD box{{-1, 0, -2}, {3, 2, 2}};

}  // namespace

TEST_CASE("a framed scene is in view with all its corners, whatever is up, however far from zero and small") {
    for (const glm::dvec3 up : {glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1), glm::dvec3(-1, 0, 0), glm::dvec3(0, -1, 0)}) {
        for (const double scale : {1e-6, 1.0, 1e9}) {
            for (const double place : {0.0, 1e5}) {
                const glm::dvec3 moved = glm::dvec3(place, -place, place) * scale;
                const BoxD b{box.lower * scale + moved, box.upper * scale + moved};
                const Navigator navigator(b, up);
                const Camera camera = navigator.camera();
                CHECK_NOTHROW(camera.validate());
                CHECK(glm::dot(glm::dvec3(camera.up), up) > 0.5);
                for (int i = 0; i < 8; ++i) {
                    const glm::dvec3 corner(i & 1 ? b.lower.x : b.upper.x, i & 2 ? b.lower.y : b.upper.y,
                                            i & 4 ? b.lower.z : b.upper.z);
                    const glm::dvec2 at = seen_at(camera, corner);
                    CHECK(glm::dot(corner - camera.eye, glm::dvec3(camera.forward)) > 0);
                    CHECK(std::abs(at.x) <= 0.5);
                    CHECK(std::abs(at.y) <= 0.5);
                }
            }
        }
    }
}

TEST_CASE("a scene that is a point is looked at from somewhere") {
    for (const glm::dvec3 point : {glm::dvec3(0), glm::dvec3(1e9, 0, 0)}) {
        const Navigator navigator({point, point}, {0, 1, 0});
        CHECK_NOTHROW(navigator.camera().validate());
        CHECK(glm::length(navigator.eye() - point) > 0);
    }
}

TEST_CASE("orbiting keeps the target in the middle and the distance, and never passes the zenith") {
    Navigator navigator(box, {0, 1, 0});
    const double distance = navigator.distance();
    const glm::dvec3 before = navigator.eye();
    std::mt19937 random(1);
    std::uniform_real_distribution<double> by(-0.7, 0.7);
    for (int i = 0; i < 200; ++i) {
        navigator.orbit({by(random), by(random)});
        CHECK(glm::length(navigator.eye() - box.center()) == Approx(distance));
        const Camera camera = navigator.camera();
        CHECK_NOTHROW(camera.validate());
        CHECK(camera.up.y > 0);
        CHECK(glm::length(seen_at(camera, box.center())) < 1e-5);
    }
    navigator.reset();
    CHECK(glm::length(navigator.eye() - before) < 1e-12);
    // Down drags the scene down: the eye rises.
    navigator.orbit({0, -0.1});
    CHECK(navigator.eye().y > before.y);
}

TEST_CASE("a drag to the right turns the scene to the right") {
    Navigator navigator(box, {0, 1, 0});
    const Camera before = navigator.camera();
    const glm::dvec3 in_front = navigator.target() - glm::dvec3(before.forward);
    navigator.orbit({0.05, 0});
    CHECK(seen_at(navigator.camera(), in_front).x > seen_at(before, in_front).x);
}

TEST_CASE("zooming keeps what the cursor is on where it is on the screen") {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> place(-0.5, 0.5);
    for (int i = 0; i < 100; ++i) {
        Navigator navigator(box, {0, 1, 0});
        navigator.orbit({place(random), place(random)});
        const glm::dvec2 at(place(random), place(random));
        const double depth = navigator.distance() * (1 + place(random));
        const Camera before = navigator.camera();
        const double height = 2 * double(before.half_height) * depth;
        const glm::dvec3 point = before.eye + glm::dvec3(before.forward) * depth +
                                 (glm::dvec3(before.right) * at.x + glm::dvec3(before.up) * at.y) * height;
        navigator.zoom(i % 2 == 0 ? 3 : -3, at, depth);
        const Camera after = navigator.camera();
        CHECK(glm::length(seen_at(after, point) - at) < 1e-4);
        CHECK(glm::dot(after.forward, before.forward) == Approx(1));
        const double now = glm::length(point - after.eye), then = glm::length(point - before.eye);
        CHECK((i % 2 == 0) == (now < then));
    }
}

TEST_CASE("however long one zooms there is a camera") {
    Navigator navigator(box, {0, 1, 0});
    for (int i = 0; i < 500; ++i) navigator.zoom(3, {0.1, 0.2});
    CHECK_NOTHROW(navigator.camera().validate());
    for (int i = 0; i < 500; ++i) navigator.zoom(-3, {0.1, 0.2});
    CHECK_NOTHROW(navigator.camera().validate());
    navigator.frame();
    CHECK(glm::length(seen_at(navigator.camera(), box.center())) < 1e-6);
}

TEST_CASE("panning moves the target along with the mouse") {
    Navigator navigator(box, {0, 1, 0});
    const glm::dvec3 target = navigator.target();
    navigator.pan({0.2, -0.1});
    const glm::dvec2 at = seen_at(navigator.camera(), target);
    CHECK(at.x == Approx(0.2));
    CHECK(at.y == Approx(0.1));
}

TEST_CASE("looking about keeps the eye, walking goes where one looks") {
    Navigator navigator(box, {0, 1, 0});
    const glm::dvec3 eye = navigator.eye();
    navigator.look({0.3, 0.1});
    CHECK(glm::length(navigator.eye() - eye) < 1e-12);
    const glm::dvec3 forward = navigator.forward();
    navigator.walk({0, 0, 0.5});
    const glm::dvec3 way = navigator.eye() - eye;
    CHECK(glm::dot(glm::normalize(way), forward) == Approx(1));
    navigator.walk({0, 1, 0});
    CHECK(navigator.eye().y > eye.y + way.y);
}

TEST_CASE("what follows a camera has the same one, and starts there again") {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> by(-0.6, 0.6);
    for (const glm::dvec3 up : {glm::dvec3(0, 1, 0), glm::dvec3(0, 0, -1)}) {
        Navigator one(box, up), other(box, up);
        for (int i = 0; i < 50; ++i) {
            one.look({by(random), by(random)});
            one.walk({by(random), by(random), by(random)});
            const Camera camera = one.camera();
            other.follow(camera);
            CHECK(glm::length(other.camera().eye - camera.eye) < 1e-5);
            CHECK(glm::dot(other.camera().forward, camera.forward) > 1 - 1e-6f);
            CHECK(glm::dot(other.camera().up, camera.up) > 1 - 1e-6f);
        }
        other.start_at(one.camera());
        other.orbit({0.3, 0.2});
        other.reset();
        CHECK(glm::length(other.camera().eye - one.camera().eye) < 1e-5);
    }
}
