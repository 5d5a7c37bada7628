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

namespace {
/// Triangle `which` of a quadrilateral that its first diagonal cuts, beginning anywhere.
AnyPolygon half_of(const AnyPolygon& q, unsigned which, unsigned turn) {
    const std::array<unsigned, 3> of = which == 0 ? std::array<unsigned, 3>{0, 1, 2} : std::array<unsigned, 3>{0, 2, 3};
    AnyPolygon p;
    for (unsigned c = 0; c < 3; ++c) {
        p.vertices.push_back(q.vertices[of[(c + turn) % 3]]);
        if (q.colors.size() == 4) p.colors.push_back(q.colors[of[(c + turn) % 3]]);
    }
    if (q.colors.size() != 4) p.colors = q.colors;
    return p;
}
AnyPolygon quadrilateral(float bend, std::size_t colors) {
    AnyPolygon q{{{0, 0, 1}, {2, 0, 1.5f}, {2, 1, 1.75f + bend}, {0, 1, 1.25f}}, {}};
    for (std::size_t c = 0; c < colors; ++c)
        q.colors.push_back({std::uint8_t(10 + 20 * (c == 1 || c == 2)), 5, 7, 255});
    return q;
}
}  // namespace

TEST_CASE("two triangles in a row that make a plane quadrilateral become one, and each is still found", "[raster]") {
    for (const std::size_t colors : {1u, 4u}) {
        for (unsigned turn = 0; turn < 9; ++turn) {
            for (const unsigned first : {0u, 1u}) {
                const AnyPolygon q = quadrilateral(0, colors);
                const std::vector<AnyPolygon> polygons{half_of(q, first, turn % 3), half_of(q, 1 - first, turn / 3),
                                                       half_of(q, 0, 0)};
                const PolygonStream stream(source_of(polygons));
                REQUIRE(stream.size() == 2);
                CHECK(stream.first_record(0) == 0);
                CHECK_FALSE(stream.begins_within(0));
                CHECK(stream.first_record(1) == 0);
                CHECK(stream.begins_within(1));
                CHECK(stream.first_record(2) == 1);
                CHECK_FALSE(stream.begins_within(2));
                CHECK(stream.first_record(3) == 2);
                // Each half has the corners that it had, in their order: its depths depend on that.
                CHECK_FALSE(stream[0].is_triangle);
                for (const unsigned half : {0u, 1u}) {
                    for (unsigned c = 0; c < 3; ++c) {
                        const unsigned at = stream[0].half(half)[c];
                        CHECK(corner(stream[0], at) == polygons[half].vertices[c]);
                        if (colors == 4) CHECK(stream.colors(stream[0])[at] == polygons[half].colors[c]);
                    }
                }
            }
        }
    }
}

TEST_CASE("triangles stay triangles that do not make a plane quadrilateral of one gradient", "[raster]") {
    const auto size = [](const AnyPolygon& a, const AnyPolygon& b) {
        return PolygonStream(source_of(std::vector<AnyPolygon>{a, b})).size();
    };
    const AnyPolygon q = quadrilateral(0, 1), bent = quadrilateral(0.01f, 1);
    CHECK(size(half_of(q, 0, 0), half_of(q, 1, 0)) == 1);
    CHECK(size(half_of(bent, 0, 0), half_of(bent, 1, 0)) == 2);
    AnyPolygon other = half_of(q, 1, 0);
    other.colors[0].r = 99;
    CHECK(size(half_of(q, 0, 0), other) == 2);
    other = half_of(q, 1, 0);
    std::swap(other.vertices[1], other.vertices[2]);  // turned away
    CHECK(size(half_of(q, 0, 0), other) == 2);
    AnyPolygon glass = q;
    glass.colors[0].a = 100;
    CHECK(size(half_of(glass, 0, 0), half_of(glass, 1, 0)) == 2);
    AnyPolygon dent = q;
    dent.vertices[1] = {0.2f, 0.6f, 1.2f};  // not convex
    CHECK(size(half_of(dent, 0, 0), half_of(dent, 1, 0)) == 2);
    AnyPolygon many = quadrilateral(0, 4);
    many.colors[3] = {200, 0, 0, 255};
    CHECK(size(half_of(many, 0, 0), half_of(many, 1, 0)) == 2);
    CHECK(size(half_of(q, 0, 0), half_of(q, 0, 0)) == 2);  // the same twice
    // A third one finds no partner.
    const PolygonStream three(source_of(std::vector<AnyPolygon>{half_of(q, 0, 0), half_of(q, 1, 0), half_of(q, 0, 0)}));
    CHECK(three.size() == 2);
}
