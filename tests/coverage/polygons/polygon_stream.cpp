// Records hold each position's polygons, in order, cut into triangles only where they must be.
#include "farfield/coverage/polygons/polygon_stream.hpp"

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <utility>
#include <vector>

#include "catch.hpp"
#include "farfield/primitive/triangle.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

namespace {
/// A convex polygon of any number of corners, in one color or in several.
struct AnyPolygon {
    std::vector<glm::vec3> vertices;
    std::vector<Rgba8> colors;

    Box bounds() const {
        Box box = Box::empty();
        for (const glm::vec3& v : vertices) box.add(Box{v, v});
        return box;
    }
    template <class Sink>
    void polygons(Sink&& sink) const {
        sink(Polygon{vertices, colors});
    }
};

AnyPolygon any_polygon(Random& random, std::size_t corners, std::size_t colors, std::uint8_t alpha = 255) {
    AnyPolygon p;
    for (std::size_t i = 0; i < corners; ++i) p.vertices.push_back(random.in_cube(1));
    for (std::size_t i = 0; i < colors; ++i) {
        p.colors.push_back(random.color());
        p.colors.back().a = alpha;
    }
    return p;
}

template <class P>
Source<P> source_of(const std::vector<P>& primitives) {
    return {primitives, {}, std::uint32_t(primitives.size()), glm::dvec3(0), 0};
}
glm::vec3 corner(const PolygonRecord& r, unsigned c) {
    return {r.x[c], r.y[c], r.z[c]};
}

/// The corners of a polygon's records, fan by fan.
void check(const PolygonStream& stream, std::uint32_t position, const AnyPolygon& p) {
    bool is_flat = true;
    for (const Rgba8 c : p.colors) is_flat = is_flat && c == p.colors[0];
    if (p.colors.size() < p.vertices.size()) is_flat = true;
    std::size_t next = 1;  // of the fan about corner 0
    for (std::uint32_t at = stream.first_record(position); at < stream.first_record(position + 1); ++at) {
        const PolygonRecord& r = stream[at];
        CHECK(r.color == p.colors[0]);
        CHECK(corner(r, 0) == p.vertices[0]);
        REQUIRE(next + 1 < p.vertices.size());
        CHECK(corner(r, 1) == p.vertices[next]);
        CHECK(corner(r, 2) == p.vertices[next + 1]);
        if (r.is_triangle) {
            CHECK(corner(r, 3) == corner(r, 2));
            ++next;
        } else {
            CHECK(is_flat);
            CHECK(p.colors[0].a == 255);  // hashes go by triangles
            REQUIRE(next + 2 < p.vertices.size());
            CHECK(corner(r, 3) == p.vertices[next + 2]);
            next += 2;
        }
        CHECK((r.colors == PolygonRecord::flat) == is_flat);
        if (!is_flat) {
            const Rgba8* colors = stream.colors(r);
            CHECK(colors[0] == p.colors[0]);
            CHECK(colors[1] == p.colors[next - 1]);
            CHECK(colors[2] == p.colors[next]);
        }
    }
    CHECK(next + 1 == p.vertices.size());
}
}  // namespace

TEST_CASE("polygons become quadrilaterals and a triangle; of several colors or translucent ones, triangles",
          "[raster]") {
    Random random(850);
    std::vector<AnyPolygon> polygons;
    for (std::size_t corners = 3; corners < 12; ++corners) {
        polygons.push_back(any_polygon(random, corners, 1));
        polygons.push_back(any_polygon(random, corners, corners));
        polygons.push_back(any_polygon(random, corners, 1, 128));
        polygons.push_back(any_polygon(random, corners, 1));
        polygons.back().colors.resize(corners, polygons.back().colors[0]);  // several that are one
    }
    const PolygonStream stream(source_of(polygons));
    for (std::uint32_t i = 0; i < polygons.size(); ++i) check(stream, i, polygons[i]);
    CHECK(stream.first_record(1) - stream.first_record(0) == 1);  // a triangle
    CHECK(stream.first_record(5) - stream.first_record(4) == 1);  // a quadrilateral
    CHECK(stream.first_record(6) - stream.first_record(5) == 2);  // of several colors
    CHECK(stream.first_record(9) - stream.first_record(8) == 2);  // a pentagon
}

TEST_CASE("a record each: positions are records", "[raster]") {
    Random random(851);
    std::vector<AnyPolygon> polygons;
    for (int i = 0; i < 50; ++i) polygons.push_back(any_polygon(random, 3 + random.below(2), 1));
    const PolygonStream stream(source_of(polygons));
    for (std::uint32_t i = 0; i < polygons.size(); ++i) {
        CHECK(stream.first_record(i) == i);
        check(stream, i, polygons[i]);
    }
}

TEST_CASE("positions go by the source's order; what has no corners takes no record", "[raster]") {
    Random random(852);
    std::vector<AnyPolygon> polygons;
    for (int i = 0; i < 20; ++i) polygons.push_back(any_polygon(random, i % 5 == 0 ? 6 : 3, 1));
    polygons[7].vertices.clear();
    std::vector<std::uint32_t> order;
    for (std::uint32_t i = 0; i < 20; ++i) order.push_back(19 - i);
    order.push_back(3);  // shared
    const Source<AnyPolygon> source{polygons, order, 21, glm::dvec3(0), 0};
    const PolygonStream stream(source);
    for (std::uint32_t i = 0; i < order.size(); ++i) {
        if (order[i] != 7) check(stream, i, polygons[order[i]]);
    }
    CHECK(stream.first_record(12) == stream.first_record(13));
}

TEST_CASE("pieces come in the place of the primitives that they were cut from", "[raster]") {
    const std::vector<Triangle> triangles(2);
    const std::vector<std::uint32_t> order{0, 0, 1}, first{0, 4, 4, 7};  // the second is an instance's: empty
    const std::vector<glm::vec3> vertices{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {5, 0, 0}, {6, 0, 0}, {6, 1, 0}};
    const std::vector<Rgba8> colors(7, Rgba8{1, 2, 3, 255});
    Source<Triangle> source{triangles, order, 3, glm::dvec3(0), 0};
    source.fragments = {first, vertices, colors};
    const PolygonStream stream(source);
    CHECK(stream.first_record(0) == 0);
    CHECK(stream.first_record(1) == 1);
    CHECK(stream.first_record(2) == 1);
    CHECK(stream.first_record(3) == 2);
    CHECK_FALSE(stream[0].is_triangle);
    CHECK(corner(stream[0], 3) == vertices[3]);
    CHECK(stream[1].is_triangle);
    CHECK(corner(stream[1], 0) == vertices[4]);
    CHECK(stream[1].color == Rgba8{1, 2, 3, 255});
}
