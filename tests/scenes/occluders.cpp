#include "scenes/generate/occluders.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <limits>
#include <stdexcept>

#include "catch.hpp"
#include "support/pictures.hpp"

using namespace farfield;
using namespace farfield::scenes;

TEST_CASE("occluders leave the gap asked for and hide all else", "[scenes]") {
    const float gap = 0.25f;
    const std::vector<Triangle> scene = occluders_with_gap({.gap = gap, .side_quads = 5, .behind = 3000});
    REQUIRE(scene.size() == 2 * 2 * 25 + 3000);
    float nearest = std::numeric_limits<float>::infinity();
    for (const Triangle& t : scene) {
        CHECK(t.rgba.a == 255);
        for (const glm::vec3& v : t.vertices) {
            if (is_bright(t.rgba)) {
                CHECK(v.z <= -1);
                CHECK(std::abs(v.x) <= 4);
            } else {
                CHECK(v.z == 0);
                nearest = std::min(nearest, std::abs(v.x));
            }
        }
    }
    CHECK(nearest == gap / 2);
    const View view = test::looking_orthographic({0, 0, 8}, {}, 3.5f, 70);
    const Image image = test::plain_picture<Triangle>(scene, view, {.samples = 4});
    for (std::size_t i = 0; i < 3 * 2 * 25; ++i) {  // occluders and the sheet
        const auto& [a, b, c] = scene[i].vertices;
        CHECK(glm::cross(b - a, c - a).z > 0);
    }
    int bright = 0;
    for (const Rgba8 c : image.pixels()) {
        CHECK(c.a == 255);
        bright += is_bright(c);
    }
    // 0.25 of 3.5 across: five columns, or four and two halves.
    CHECK(bright >= 4 * 70);
    CHECK(bright <= 6 * 70);
}

TEST_CASE("occluders are the same bytes again, and refuse what makes no scene", "[scenes]") {
    const std::vector<Triangle> a = occluders_with_gap(), b = occluders_with_gap();
    CHECK((a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0));
    for (const float gap : {0.0f, 1.0f, -1.0f, std::numeric_limits<float>::quiet_NaN()}) {
        CHECK_THROWS_AS(occluders_with_gap({.gap = gap}), std::invalid_argument);
    }
    CHECK_THROWS_AS(occluders_with_gap({.side_quads = 0}), std::invalid_argument);
    CHECK_THROWS_AS(occluders_with_gap({.behind = 0}), std::invalid_argument);
}
