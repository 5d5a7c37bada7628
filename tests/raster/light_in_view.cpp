#include "farfield/raster/light_in_view.hpp"

#include "catch.hpp"
#include "support/random.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

TEST_CASE("where there is no light there is none in any view", "[raster]") {
    LightInView light(std::nullopt);
    const LocalView view(looking({1, 2, 3}), glm::dvec3(0), 4);
    light.begin_frame(view);
    light.set_view(view);
    CHECK(light.light() == nullptr);
}

TEST_CASE("in a turned instance the light is turned back, and comes from where it came", "[raster]") {
    const DirectionalLight given{.towards = {0.3f, -0.8f, 0.5f}, .ambient = 0.2f, .diffuse = 0.7f};
    LightInView light(given);
    const LocalView outer(looking({1, 2, 3}), glm::dvec3(0), 4);
    light.begin_frame(outer);
    light.set_view(outer);
    REQUIRE(light.light() != nullptr);
    CHECK(glm::length(light.light()->towards - given.towards) < 1e-6f);
    CHECK(light.light()->ambient == 0.2f);
    CHECK(light.light()->diffuse == 0.7f);
    Random random(792);
    for (int i = 0; i < 100; ++i) {
        // Two of three axes of a turn, and the third.
        const glm::vec3 x = random.direction(), y = glm::normalize(glm::cross(x, random.direction())),
                        z = glm::cross(x, y);
        const float scale = random.between(0.1f, 5);
        const Similarity placed(glm::mat3(x, y, z), scale, glm::dvec3(random.in_cube(3)));
        const LocalView inner = outer.inside(placed, glm::dvec3(0), glm::dvec3(0));
        light.set_view(inner);
        CHECK(glm::length(placed.rotation() * light.light()->towards - given.towards) < 1e-5f);
        // Out of the instance it is the same again.
        light.set_view(outer);
        CHECK(glm::length(light.light()->towards - given.towards) < 1e-6f);
    }
}
