#include "scenes/scene.hpp"

#include <glm/gtc/matrix_transform.hpp>
#include <stdexcept>

#include "catch.hpp"

using namespace farfield;
using namespace farfield::scenes;

namespace {

VertexColoredTriangle unit_triangle() {
    return {{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}, {}};
}

/// A triangle, two of it in a row, and a thousand of those: one more, own, in the root.
Scene nested() {
    Scene scene{"nested", std::vector<Group>(3)};
    scene.groups[0].triangles = {unit_triangle()};
    scene.groups[1].placements = {{0, glm::mat4(1.0f)}, {0, glm::translate(glm::mat4(1.0f), {2, 0, 0})}};
    for (int i = 0; i < 1000; ++i) {
        scene.groups[2].placements.push_back({1, glm::translate(glm::mat4(1.0f), {0, 0, static_cast<float>(i)})});
    }
    scene.groups[2].triangles = {unit_triangle()};
    return scene;
}

}  // namespace

TEST_CASE("instances are counted and bounded", "[scenes]") {
    const Scene scene = nested();
    CHECK(triangle_count(scene) == 2001);
    CHECK(bounds(scene) == Box{{0, 0, 0}, {3, 1, 999}});
    CHECK(bytes(scene) == 2 * sizeof(VertexColoredTriangle) + 1002 * sizeof(Placement));
}

TEST_CASE("expanding gives the same triangles in the order of placements", "[scenes]") {
    const Scene scene = expanded(nested());
    REQUIRE(scene.groups.size() == 1);
    CHECK(scene.groups[0].placements.empty());
    CHECK(scene.name == "nested");
    CHECK(triangle_count(scene) == 2001);
    CHECK(bounds(scene) == bounds(nested()));
    CHECK(scene.groups[0].triangles[0].vertices[0] == glm::vec3(0, 0, 0));
    CHECK(scene.groups[0].triangles[2].vertices[0] == glm::vec3(2, 0, 0));
    CHECK(scene.groups[0].triangles[3].vertices[0] == glm::vec3(0, 0, 1));
}

TEST_CASE("expanding beyond the limit says so before it allocates", "[scenes]") {
    CHECK(triangle_count(expanded(nested(), 2001)) == 2001);
    CHECK_THROWS_AS(expanded(nested(), 2000), std::length_error);

    Scene endless{"endless", std::vector<Group>(1)};
    endless.groups[0].triangles = {unit_triangle()};
    for (std::size_t level = 0; level < 80; ++level) {
        endless.groups.push_back({{}, {{level, glm::mat4(1.0f)}, {level, glm::mat4(1.0f)}}});
    }
    CHECK(triangle_count(endless) == ~std::uint64_t{0});
    CHECK_THROWS_AS(expanded(endless), std::length_error);
}

TEST_CASE("a placement may only name an earlier group", "[scenes]") {
    Scene scene = nested();
    scene.groups[1].placements[0].group = 1;
    CHECK_THROWS_AS(triangle_count(scene), std::invalid_argument);
    CHECK_THROWS_AS(bounds(scene), std::invalid_argument);
    CHECK_THROWS_AS(bytes(scene), std::invalid_argument);
    CHECK_THROWS_AS(expanded(scene), std::invalid_argument);
    CHECK_THROWS_AS(triangle_count(Scene{}), std::invalid_argument);
}

TEST_CASE("a scene of nothing has no bounds", "[scenes]") {
    const Scene nothing{"nothing", std::vector<Group>(1)};
    CHECK(triangle_count(nothing) == 0);
    CHECK(bounds(nothing).is_empty());
    CHECK(expanded(nothing).groups[0].triangles.empty());
}
