#include "farfield/geometry/polygon.hpp"

#include <array>
#include <cstddef>
#include <vector>

#include "catch.hpp"
#include "farfield/geometry/clip_polygon.hpp"

using namespace farfield;

TEST_CASE("a polygon is a fan of triangles around its first corner") {
    for (const std::size_t corners : {0u, 1u, 2u}) {
        for_each_triangle(corners,
                          [](std::size_t, std::size_t, std::size_t) { FAIL("no triangle has these corners"); });
    }
    std::vector<std::array<std::size_t, 3>> fan;
    for_each_triangle(5, [&](std::size_t a, std::size_t b, std::size_t c) { fan.push_back({a, b, c}); });
    CHECK(fan == std::vector<std::array<std::size_t, 3>>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}});
}

TEST_CASE("twice a polygon's area points along its normal") {
    const std::vector<glm::vec3> square{{1, 1, 5}, {3, 1, 5}, {3, 4, 5}, {1, 4, 5}};
    const auto at = [&](std::size_t i) { return square[i]; };
    CHECK(doubled_area<float>(4, at) == glm::vec3(0, 0, 12));
    CHECK(doubled_area<double>(4, at) == glm::dvec3(0, 0, 12));
    CHECK(doubled_area<double>(3, at) == glm::dvec3(0, 0, 6));
    CHECK(doubled_area<double>(2, at) == glm::dvec3(0));
    CHECK(doubled_area(std::vector<Corner>{}) == glm::dvec3(0));
    const glm::vec3 step(0.1f, 0.3f, -0.7f);
    CHECK(doubled_area<double>(5, [&](std::size_t i) { return step * float(1u << i); }) == glm::dvec3(0));
}

TEST_CASE("a mapped polygon of many vertices comes in parts that cover it once") {
    for (const std::size_t count : {3u, 63u, 64u, 65u, 126u, 127u, 200u}) {
        std::vector<glm::vec3> vertices;
        std::vector<Rgba8> colors;
        for (std::size_t i = 0; i < count; ++i) {
            // On a parabola: convex, and sums of areas are exact.
            vertices.emplace_back(float(i), float(i * i), 0);
            colors.push_back({std::uint8_t(i), 0, 0, 255});
        }
        const auto at = [](const auto& polygon) { return [&](std::size_t i) { return polygon.vertices[i]; }; };
        const Polygon whole{vertices, colors, true};
        glm::dvec3 sum(0);
        map_polygon<double>(
            whole, [](glm::vec3 p) { return glm::dvec3(p); },
            [&](const PolygonD& part) {
                REQUIRE(part.vertices.size() >= 3);
                REQUIRE(part.colors.size() == part.vertices.size());
                CHECK(part.is_lit);
                for (std::size_t i = 0; i < part.vertices.size(); ++i) CHECK(part.colors[i].r == part.vertices[i].x);
                sum += doubled_area<double>(part.vertices.size(), at(part));
            });
        CHECK(sum == doubled_area<double>(count, at(whole)));
    }
}
