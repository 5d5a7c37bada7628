#include "farfield/geometry/light.hpp"

#include <cmath>

#include "catch.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::test;

TEST_CASE("brightness is ambient plus diffuse times the cosine, on the side of the light", "[geometry]") {
    const DirectionalLight light{{0, 0, 5}, 0.2f, 0.7f};
    CHECK(std::abs(light.brightness({0, 0, 3}) - 0.9f) < 1e-6f);
    CHECK(std::abs(light.brightness({0, 0, -3}) - 0.2f) < 1e-6f);
    CHECK(std::abs(light.brightness({1, 0, 0}) - 0.2f) < 1e-6f);
    CHECK(std::abs(light.brightness({1, 0, 1}) - (0.2f + 0.7f * std::sqrt(0.5f))) < 1e-6f);
    CHECK(light.brightness({0, 0, 0}) == 0.2f);
}

TEST_CASE("brightness does not depend on lengths and stays in [0, 1]", "[geometry]") {
    Random random(3);
    for (int i = 0; i < 1000; ++i) {
        DirectionalLight light;
        light.towards = random.direction() * random.between(0.01f, 100);
        const glm::vec3 n = random.direction();
        const float b = light.brightness(n);
        CHECK((b >= light.ambient && b <= 1.00001f));
        CHECK(std::abs(light.brightness(n * 1000.0f) - b) < 1e-5f);
        CHECK(std::abs(light.brightness(n * 1e-5f) - b) < 1e-5f);
    }
}

TEST_CASE("scaled colors round to nearest, do not overflow and keep alpha", "[geometry]") {
    CHECK(scaled({100, 200, 255, 77}, 0.5f) == Rgba8{50, 100, 128, 77});
    CHECK(scaled({100, 200, 255, 77}, 1) == Rgba8{100, 200, 255, 77});
    CHECK(scaled({100, 200, 255, 77}, 2) == Rgba8{200, 255, 255, 77});
}

TEST_CASE("colors that hold the light already, and those without one, stay as they are", "[geometry]") {
    const DirectionalLight light{{0, 0, 5}, 0.2f, 0.7f};
    Polygon polygon{};
    CHECK(brightness_of({}, polygon, {0, 0, 1}) == 1);
    CHECK(brightness_of(light, polygon, {0, 0, -1}) == light.brightness({0, 0, -1}));
    polygon.is_lit = true;
    CHECK(brightness_of(light, polygon, {0, 0, -1}) == 1);
}
