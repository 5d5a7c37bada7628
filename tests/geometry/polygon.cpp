#include "farfield/geometry/polygon.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <vector>

#include "catch.hpp"
#include "farfield/geometry/clip_polygon.hpp"

using namespace farfield;

namespace {

std::vector<glm::vec3> rim(std::size_t corners) {
    std::vector<glm::vec3> out;
    for (std::size_t i = 0; i < corners; ++i) {
        const float at = 6.2831853f * float(i) / float(corners);
        out.push_back({std::cos(at), std::sin(at), 1});
    }
    return out;
}
template <class T>
double area_of(const BasicPolygon<T>& p) {
    glm::dvec3 sum(0);
    for (std::size_t i = 2; i < p.vertices.size(); ++i) {
        sum += glm::cross(glm::dvec3(p.vertices[i - 1] - p.vertices[0]), glm::dvec3(p.vertices[i] - p.vertices[0]));
    }
    return 0.5 * sum.z;
}
const auto as_it_is = [](auto v) { return v; };

}  // namespace

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

TEST_CASE("a mapped polygon has its corners mapped and its colors as they were", "[geometry]") {
    const std::vector<glm::vec3> vertices = rim(5);
    const std::vector<Rgba8> colors{{1, 0, 0, 255}, {2, 0, 0, 255}, {3, 0, 0, 255}, {4, 0, 0, 255}, {5, 0, 0, 255}};
    int calls = 0;
    map_polygon<double>(
        Polygon{vertices, colors, true}, [](glm::vec3 v) { return glm::dvec3(v) * 2.0; },
        [&](const PolygonD& p) {
            ++calls;
            REQUIRE(p.vertices.size() == 5);
            REQUIRE(p.colors.size() == 5);
            CHECK(p.is_lit);
            for (std::size_t i = 0; i < 5; ++i) {
                CHECK(p.vertices[i] == glm::dvec3(vertices[i]) * 2.0);
                CHECK(p.colors[i] == colors[i]);
            }
        });
    CHECK(calls == 1);
}

TEST_CASE("polygons of very many corners come in parts that share them out", "[geometry]") {
    for (const std::size_t corners : {3u, 63u, 64u, 65u, 66u, 126u, 127u, 200u, 1000u}) {
        const std::vector<glm::vec3> vertices = rim(corners);
        std::vector<Rgba8> colors(corners);
        for (std::size_t i = 0; i < corners; ++i) colors[i] = {std::uint8_t(i), std::uint8_t(i >> 8), 0, 255};
        for (const bool one_color : {false, true}) {
            const Polygon whole{vertices, one_color ? std::span<const Rgba8>(colors).first(1) : colors, false};
            double area = 0;
            std::size_t parts = 0, wrong = 0;
            map_polygon<float>(whole, as_it_is, [&](const Polygon& p) {
                ++parts;
                area += area_of(p);
                wrong += p.vertices.size() < 3 || p.vertices.size() > 64 || !(area_of(p) > 0);
                wrong += p.colors.size() != (one_color ? 1 : p.vertices.size());
                for (std::size_t i = 0; i < p.colors.size(); ++i) {
                    const std::size_t at = p.colors[i].r + std::size_t(256) * p.colors[i].g;
                    wrong += !one_color && p.vertices[i] != vertices[at];
                }
            });
            CHECK(wrong == 0);
            CHECK(parts == (corners <= 64 ? 1 : (corners - 2 + 61) / 62));
            CHECK(area == Approx(area_of(whole)));
        }
    }
}

TEST_CASE("what is no polygon is not mapped", "[geometry]") {
    const std::vector<glm::vec3> vertices = rim(3);
    const std::vector<Rgba8> colors(3);
    const auto count = [&](const Polygon& p) {
        int calls = 0;
        map_polygon<float>(p, as_it_is, [&](const Polygon&) { ++calls; });
        return calls;
    };
    CHECK(count({vertices, colors}) == 1);
    CHECK(count({std::span(vertices).first(2), colors}) == 0);
    CHECK(count({{}, colors}) == 0);
    CHECK(count({vertices, {}}) == 0);
}

TEST_CASE("a sink whose type is forgotten gets what it is sent, of either precision", "[geometry]") {
    const std::vector<glm::vec3> vertices = rim(3);
    const std::vector<glm::dvec3> doubles(4, glm::dvec3(1));
    const Rgba8 color{};
    std::size_t single_corners = 0, double_corners = 0;
    struct Sink {
        std::size_t &single, &both;
        void operator()(const Polygon& p) { single += p.vertices.size(); }
        void operator()(const PolygonD& p) { both += p.vertices.size(); }
    } sink{single_corners, double_corners};
    const AnyPolygonSink any(sink);
    any(Polygon{vertices, {&color, 1}});
    any(PolygonD{doubles, {&color, 1}});
    CHECK(single_corners == 3);
    CHECK(double_corners == 4);
}

TEST_CASE("a polygon carries a value to whoever asks for its type, through maps and sinks of no type", "[geometry]") {
    struct Leaf {
        int number;
    };
    const std::vector<glm::vec3> vertices = rim(64), many = rim(65);
    const Rgba8 color{};
    const Leaf leaf{7};
    const Polygon carrying{vertices, {&color, 1}, false, leaf}, divided{many, {&color, 1}, false, leaf};
    CHECK(carrying.carried.get<Leaf>() == &leaf);
    CHECK(carrying.carried.get<int>() == nullptr);
    CHECK((Polygon{vertices, {&color, 1}}.carried.is_empty() && CarriedValue().get<Leaf>() == nullptr));
    int carried = 0, empty = 0;
    const auto count = [&](const auto& polygon) {
        carried += polygon.carried.template get<Leaf>() == &leaf;
        empty += polygon.carried.is_empty();
    };
    const AnyPolygonSink any(count);
    map_polygon<double>(carrying, as_it_is, any);
    CHECK((carried == 1 && empty == 0));
    map_polygon<float>(divided, as_it_is, any);
    CHECK((carried == 1 && empty == 2));
}
