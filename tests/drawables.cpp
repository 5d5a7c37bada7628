#include "farfield/drawables.hpp"

#include <glm/geometric.hpp>
#include <vector>

#include "catch.hpp"
#include "farfield/primitive/triangle.hpp"

using namespace farfield;

TEST_CASE("a face as a polygon is a rectangle that looks to its side, of its color") {
    for (std::uint8_t side = 0; side < 6; ++side) {
        const int axis = side / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
        Face face{{1, 2, 3}, {2, 4, 7}, {60, 30, 0, 120}, side};
        face.upper[axis] = face.lower[axis];
        int calls = 0;
        emit_polygon(face, [&](const Polygon& p) {
            ++calls;
            CHECK(p.is_lit);
            REQUIRE(p.vertices.size() == 4);
            REQUIRE(p.colors.size() == 1);
            CHECK(p.colors[0] == Rgba8{128, 64, 0, 120});  // no longer premultiplied
            glm::vec3 n(0);
            for (std::size_t i = 2; i < 4; ++i) {
                n += 0.5f * glm::cross(p.vertices[i - 1] - p.vertices[0], p.vertices[i] - p.vertices[0]);
            }
            glm::vec3 expected(0);
            expected[axis] =
                (side & 1 ? 1.0f : -1.0f) * (face.upper[u] - face.lower[u]) * (face.upper[v] - face.lower[v]);
            CHECK(glm::length(n - expected) < 1e-5f);
            for (const glm::vec3& corner : p.vertices) CHECK(corner[axis] == face.lower[axis]);
        });
        CHECK(calls == 1);
        face.rgba = {0, 0, 0, 0};
        emit_polygon(face, [](const Polygon&) { FAIL("nothing is seen of it"); });
    }
}

TEST_CASE("a position holds its primitive's polygons less the origin, or the piece that was cut from it") {
    const std::vector<Triangle> triangles{{{{{1, 0, 0}, {2, 0, 0}, {1, 1, 0}}}, {9, 9, 9, 255}},
                                          {{{{5, 0, 0}, {6, 0, 0}, {5, 1, 0}}}, {7, 7, 7, 255}}};
    const std::vector<std::uint32_t> order{1, 0, 1};
    Source<Triangle> source;
    source.primitives = triangles;
    source.item_count = 2;
    CHECK(&source[1] == &triangles[1]);
    source.order = order;
    source.item_count = 3;
    source.origin = {1, 0, 0};
    CHECK(&source[0] == &triangles[1]);
    std::vector<float> first;
    const auto note = [&](const Polygon& p) { first.push_back(p.vertices[0].x); };
    for (std::uint32_t at = 0; at < 3; ++at) source.polygons(at, note);
    CHECK(first == std::vector<float>{4, 0, 4});
    // Pieces are in local coordinates already; the position without one is an instance's.
    const std::vector<std::uint32_t> first_vertex{0, 3, 3, 6};
    const std::vector<glm::vec3> vertices{{10, 0, 0}, {11, 0, 0}, {10, 1, 0}, {20, 0, 0}, {21, 0, 0}, {20, 1, 0}};
    const std::vector<Rgba8> colors(6);
    source.fragments = {first_vertex, vertices, colors};
    first.clear();
    source.polygons(0, note);
    source.polygons(2, note);
    CHECK(first == std::vector<float>{10, 20});
    CHECK(source.fragments[1].vertices.empty());
    CHECK(source.fragments.size_bytes() == 4 * 4 + 6 * 12 + 6 * 4);
}
