#include "farfield/partition/plane_choice.hpp"

#include <cmath>
#include <vector>

#include "catch.hpp"
#include "support/clipped_contents.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

struct Scene : ClippedContents {
    struct Sides {
        std::size_t behind = 0, on = 0, in_front = 0, cut = 0;
    };
    /// False: no plane was found.
    bool choose(Sides& sides, float price_of_cut = 16) const {
        const ClippedItems all(items, corners, planes);
        const Cell cell = unit_cell();
        CuttingPlane plane;
        if (!detail::choose_plane(cell, all, price_of_cut, plane)) return false;
        CHECK(std::abs(glm::length(plane.normal) - 1) < 1e-5f);
        const LocalPlane in_cell(plane, cell);
        sides = {};
        for (std::size_t i = 0; i < items.size(); ++i) {
            const PlaneRelation relation = all.relation(i, plane, in_cell, cell);
            sides.behind += relation == PlaneRelation::behind;
            sides.on += relation == PlaneRelation::on;
            sides.in_front += relation == PlaneRelation::in_front;
            sides.cut += relation == PlaneRelation::crossing;
            if (items[i].corners == 0) CHECK(relation != PlaneRelation::crossing);
        }
        return true;
    }
};

/// An upright triangle.
std::vector<glm::vec3> leaf(float x, float width = 0.05f) {
    return {{x, -0.5f, 0}, {x + width, -0.5f, 0.1f}, {x, 0.5f, 0}};
}

}  // namespace

TEST_CASE("where a plane cuts nothing and leaves as many on either side, that is it") {
    Scene scene;
    for (int i = 0; i < 20; ++i) scene.add(leaf(-0.95f + 0.095f * float(i)));
    Scene::Sides sides;
    REQUIRE(scene.choose(sides));
    CHECK(sides.cut == 0);
    CHECK(std::abs(int(sides.behind) - int(sides.in_front)) <= 1);
}

TEST_CASE("a convex body is not peeled polygon by polygon, where faces of boxes divide it") {
    Scene scene;
    for (int i = 0; i < 16; ++i) {
        const float a = 6.2831853f * float(i) / 16, b = 6.2831853f * float(i + 1) / 16;
        scene.add({{0.9f * std::cos(a), 0.9f * std::sin(a), -0.5f},
                   {0.9f * std::cos(b), 0.9f * std::sin(b), -0.5f},
                   {0.9f * std::cos(a), 0.9f * std::sin(a), 0.5f}});
    }
    Scene::Sides sides;
    REQUIRE(scene.choose(sides));
    CHECK(sides.cut <= 2);
    CHECK(std::min(sides.behind, sides.in_front) >= 4);
}

TEST_CASE("what a cut costs decides between cutting and evenness") {
    // One long one across the middle of many.
    Scene scene;
    for (int i = 0; i < 12; ++i) scene.add(leaf(-0.9f + 0.15f * float(i)));
    scene.add({{-1, 0.9f, 0}, {1, 0.9f, 0}, {-1, 0.95f, 0.1f}});
    Scene::Sides cheap, dear;
    REQUIRE(scene.choose(cheap, 0));
    REQUIRE(scene.choose(dear, 1000));
    CHECK(dear.cut == 0);
    CHECK(std::abs(int(cheap.behind) - int(cheap.in_front)) <= 1);
}

TEST_CASE("instances are never cut, and what no plane tells from them is left together") {
    Scene apart;
    for (int i = 0; i < 6; ++i) {
        const float x = -0.9f + 0.3f * float(i);
        apart.add_instance({{x, -1, -1}, {x + 0.25f, 1, 1}});
    }
    apart.add({{-1, -1, -1}, {1, 1, 1}, {-1, 1, 0.3f}});
    Scene::Sides sides;
    REQUIRE(apart.choose(sides));
    CHECK(std::min(sides.behind, sides.in_front) >= 1);
    Scene together;
    together.add_instance({{-1, -1, -1}, {0.25f, 1, 1}});
    together.add_instance({{-0.25f, -1, -1}, {1, 1, 1}});
    CHECK_FALSE(together.choose(sides));
}

TEST_CASE("each side gets fewer than there were, or no plane is chosen") {
    Random random(830);
    std::size_t none = 0;
    for (int round = 0; round < 500; ++round) {
        Scene scene;
        const auto instances = round % 4 == 0 ? random.below(5) : 0;
        for (std::uint32_t i = 0; i < instances; ++i) {
            const glm::vec3 at = random.in_cube(0.8f);
            scene.add_instance({at - 0.2f, at + 0.2f});
        }
        const auto count = 2 + random.below(round % 50 == 0 ? 300 : 20);
        for (std::uint32_t i = 0; i < count; ++i) {
            const glm::vec3 at = random.in_cube(0.7f);
            scene.add({at, at + random.in_cube(0.3f), at + random.in_cube(0.3f)});
        }
        Scene::Sides sides;
        if (!scene.choose(sides)) {
            ++none;
            continue;
        }
        CHECK(sides.behind + sides.cut < scene.items.size());
        CHECK(sides.in_front + sides.cut < scene.items.size());
    }
    CHECK(none < 50);
}
