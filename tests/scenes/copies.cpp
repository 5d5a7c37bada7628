#include "scenes/generate/copies.hpp"

#include <glm/geometric.hpp>
#include <stdexcept>

#include "catch.hpp"
#include "farfield/geometry/similarity.hpp"

using namespace farfield;
using namespace farfield::scenes;

namespace {

Scene slab(glm::vec3 up) {
    Scene scene{"slab", {{{{{{{0, 0, 0}, {4, 0, 0}, {0, 1, 2}}}, {}}}, {}}}};
    scene.up = up;
    return scene;
}

}  // namespace

TEST_CASE("copies stand in rows across what is up, none in another, and hold no triangle twice", "[scenes]") {
    for (const glm::vec3 up : {glm::vec3(0, 1, 0), glm::vec3(0, 0, 1), glm::vec3(-1, 0, 0)}) {
        const Scene one = slab(up), many = copies(one, 30);
        CHECK(triangle_count(many) == 30);
        REQUIRE(many.groups.size() == 2);
        CHECK(many.groups[0].triangles.size() == 1);
        const glm::vec3 middle = bounds(one).center();
        const auto& placements = many.groups[1].placements;
        REQUIRE(placements.size() == 30);
        for (std::size_t i = 0; i < placements.size(); ++i) {
            CHECK_NOTHROW(Similarity(glm::dmat4(placements[i].to_parent)));
            const glm::vec3 at(placements[i].to_parent * glm::vec4(middle, 1));
            CHECK(glm::dot(at - middle, up) == Approx(0).margin(1e-4));
            CHECK(glm::vec3(placements[i].to_parent * glm::vec4(up, 0)).x == Approx(up.x).margin(1e-5));
            for (std::size_t k = 0; k < i; ++k) {
                const glm::vec3 other(placements[k].to_parent * glm::vec4(middle, 1));
                CHECK(glm::length(at - other) > glm::dot(glm::abs(glm::cross(up, {1, 1, 1})), glm::vec3(1)) / 2);
            }
        }
        CHECK(placements[0].to_parent != placements[1].to_parent);
    }
}

TEST_CASE("one copy is the scene once, and there are none of nothing", "[scenes]") {
    CHECK(triangle_count(copies(slab({0, 1, 0}), 1)) == 1);
    CHECK_THROWS_AS(copies(slab({0, 1, 0}), 0), std::invalid_argument);
    CHECK_THROWS_AS(copies(Scene{"empty", {{}}}, 3), std::invalid_argument);
}
