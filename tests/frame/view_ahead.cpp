#include "farfield/frame/view_ahead.hpp"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>

#include "catch.hpp"
#include "farfield/view.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;
using farfield::detail::Motion;

namespace {

double difference(const Camera& a, const Camera& b) {
    return glm::length(a.eye - b.eye) +
           double(glm::length(a.forward - b.forward) + glm::length(a.up - b.up) + glm::length(a.right - b.right));
}

}  // namespace

TEST_CASE("Whoever goes on evenly is where he was expected") {
    const auto at = [](int frame) {
        const double t = 0.01 * frame;
        return looking(glm::dvec3(1 + t, 0.2, 3 - 2 * t), glm::dvec3(0.1 + t, 0.1, 1 - 2 * t));
    };
    Motion motion;
    CHECK_FALSE(motion.ahead(at(0), 6));
    for (int i = 1; i < 20; ++i) {
        const std::optional<View> there = motion.ahead(at(i), 6);
        REQUIRE(there);
        CHECK(difference(there->camera, at(i + 6).camera) < 1e-5);
        CHECK_NOTHROW(there->validate());
    }
}

TEST_CASE("Whoever turns evenly looks nearly where he was expected to") {
    const auto at = [](int frame) {
        const double angle = 0.01 * frame;
        return looking(glm::dvec3(0), glm::dvec3(std::sin(angle), -0.2, -std::cos(angle)));
    };
    Motion motion;
    motion.ahead(at(0), 6);
    for (int i = 1; i < 50; ++i) {
        const std::optional<View> there = motion.ahead(at(i), 6);
        REQUIRE(there);
        CHECK(difference(there->camera, at(i + 6).camera) < 0.01);
        CHECK_NOTHROW(there->validate());
    }
}

TEST_CASE("Nothing is expected of who stands still, has just come, or turns faster than can be known") {
    const View a = looking({1, 2, 3}), b = looking({1, 2, 2.9});
    const View turned = looking({1, 2, 3}, {3, 2, 5});
    Motion motion;
    CHECK_FALSE(motion.ahead(a, 6));
    CHECK_FALSE(motion.ahead(a, 6));
    CHECK(motion.ahead(b, 6));
    CHECK_FALSE(motion.ahead(b, 6));
    CHECK_FALSE(motion.ahead(looking_orthographic({1, 2, 3}), 6));
    CHECK_FALSE(motion.ahead(a, 6));
    CHECK_FALSE(motion.ahead(turned, 6));
    // A step beyond all numbers.
    View far_away = a;
    far_away.camera.eye.x = std::numeric_limits<double>::max();
    Motion other;
    other.ahead(looking({-1, 2, 3}), 6);
    CHECK_FALSE(other.ahead(far_away, 6));
}

TEST_CASE("Pictures in a mirror are expected in a mirror") {
    const auto at = [](int frame) {
        View v = looking(glm::dvec3(1, 0.2, 3 - 0.1 * frame), glm::dvec3(1, 0, -0.1 * frame));
        v.camera.right = -v.camera.right;
        return v;
    };
    Motion motion;
    motion.ahead(at(0), 4);
    const std::optional<View> there = motion.ahead(at(1), 4);
    REQUIRE(there);
    CHECK(there->camera.is_mirrored());
    CHECK(difference(there->camera, at(5).camera) < 1e-5);
}
