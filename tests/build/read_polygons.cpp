// What is joined, and what is not: tests/partition/polygon_bsp.cpp.
#include "farfield/build/read_polygons.hpp"

#include <vector>

#include "catch.hpp"

using namespace farfield;
using farfield::detail::PolygonReader;

namespace {

const Rgba8 red{200, 0, 0, 255};

void add(PolygonReader& reader, const std::vector<glm::vec3>& vertices, std::uint32_t source = 0, float cost = 1) {
    reader.add({vertices, {&red, 1}}, source, cost);
}

}  // namespace

TEST_CASE("a polygon keeps its corners, and has bounds and the plane that suits them best") {
    PolygonReader reader;
    add(reader, {{0, 0, 1}, {2, 0, 1}, {2, 2, 1}, {1, 3, 1}, {0, 2, 1}}, 7, 3);
    REQUIRE(reader.items.size() == 1);
    const ClippedItem& item = reader.items[0];
    CHECK((item.source == 7 && item.cost == 3 && item.corners == 5 && item.first_corner == 0));
    CHECK((item.bounds.lower == glm::vec3(0, 0, 1) && item.bounds.upper == glm::vec3(2, 3, 1)));
    CHECK(reader.planes[item.polygon].normal == glm::vec3(0, 0, 1));
    CHECK(reader.planes[item.polygon].offset == 1);
    for (const Corner& c : reader.corners) CHECK(c.color == red);
}

TEST_CASE("corners that come twice are one, and what has no area is left out and counted") {
    PolygonReader reader;
    const glm::vec3 a(0, 0, 0), b(1, 0, 0), c(1, 1, 0), d(2, 0, 0);
    add(reader, {a, a, b, b, b, c, a});
    REQUIRE(reader.items.size() == 1);
    CHECK(reader.items[0].corners == 3);
    CHECK(reader.corners.size() == 3);
    for (const std::vector<glm::vec3>& none :
         {std::vector<glm::vec3>{a, a, a}, {a, b, a}, {a, b, d}, {a, b, b, a}, {b, a, d, a}}) {
        add(reader, none);
    }
    CHECK(reader.items.size() == 1);
    CHECK(reader.corners.size() == 3);
    CHECK(reader.without_area == 5);
}

TEST_CASE("two triangles of a quadrilateral become it, of both costs the mean, unless interrupted") {
    const glm::vec3 a(0, 0, 0), b(1, 0, 0), c(1, 1, 0), d(0, 1, 0);
    PolygonReader reader;
    add(reader, {a, b, c}, 0, 1);
    add(reader, {a, c, d}, 1, 3);
    REQUIRE(reader.items.size() == 1);
    CHECK(reader.joined == 1);
    CHECK((reader.items[0].corners == 4 && reader.items[0].source == 0 && reader.items[0].cost == 2));
    CHECK(reader.corners.size() == 4);
    CHECK((reader.items[0].bounds.lower == a && reader.items[0].bounds.upper == c));
    // A third is not joined with the two.
    add(reader, {d, c, c + d - a}, 2);
    CHECK(reader.items.size() == 2);
    PolygonReader interrupted;
    add(interrupted, {a, b, c});
    interrupted.interrupt();
    add(interrupted, {a, c, d});
    CHECK(interrupted.items.size() == 2);
    CHECK(interrupted.joined == 0);
}
