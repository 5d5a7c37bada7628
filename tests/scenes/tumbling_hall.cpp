#include "scenes/generate/tumbling_hall.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <map>
#include <stdexcept>
#include <utility>

#include "catch.hpp"
#include "scenes/generate/building.hpp"

using namespace farfield;
using namespace farfield::scenes;

namespace {

using Triangles = std::vector<VertexColoredTriangle>;

bool same_bytes(const Triangles& a, const Triangles& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0;
}

/// Every edge lies in two triangles, once in each direction, on the same bits.
bool is_watertight(const Triangles& triangles) {
    using Point = std::array<float, 3>;
    std::map<std::pair<Point, Point>, int> edges;
    for (const VertexColoredTriangle& t : triangles) {
        for (std::size_t k = 0; k < 3; ++k) {
            const glm::vec3 a = t.vertices[k], b = t.vertices[(k + 1) % 3];
            ++edges[{{a.x, a.y, a.z}, {b.x, b.y, b.z}}];
        }
    }
    return std::all_of(edges.begin(), edges.end(), [&](const auto& edge) {
        const auto back = edges.find({edge.first.second, edge.first.first});
        return edge.second == 1 && back != edges.end() && back->second == 1;
    });
}

double volume(const Triangles& triangles) {
    double sum = 0;
    for (const VertexColoredTriangle& t : triangles) {
        const glm::dvec3 a(t.vertices[0]), b(t.vertices[1]), c(t.vertices[2]);
        sum += glm::dot(a, glm::cross(b, c)) / 6;
    }
    return sum;
}

/// No corner lies before any triangle, by more than rounding.
bool is_convex(const Triangles& triangles) {
    for (const VertexColoredTriangle& t : triangles) {
        const glm::vec3 n = glm::normalize(glm::cross(t.vertices[1] - t.vertices[0], t.vertices[2] - t.vertices[0]));
        for (const VertexColoredTriangle& other : triangles) {
            for (const glm::vec3& v : other.vertices) {
                if (glm::dot(n, v - t.vertices[0]) > 1e-5f) return false;
            }
        }
    }
    return true;
}

bool has_one_color(const VertexColoredTriangle& t) {
    return t.rgba[0] == t.rgba[1] && t.rgba[1] == t.rgba[2] && t.rgba[0].a == 255;
}

}  // namespace

TEST_CASE("a tumbling hall has closed bodies of all shapes, convex where they say so", "[scenes]") {
    const TumblingHall hall = tumbling_hall();
    REQUIRE(hall.bodies.size() == 12);
    for (const Body& b : hall.bodies) {
        INFO(b.shape);
        CHECK(is_watertight(b.triangles));
        CHECK(volume(b.triangles) > 0.001);
        CHECK(b.is_convex == is_convex(b.triangles));
        CHECK(std::all_of(b.triangles.begin(), b.triangles.end(), has_one_color));
        float reach = 0;
        for (const VertexColoredTriangle& t : b.triangles) {
            for (const glm::vec3& v : t.vertices) reach = std::max(reach, glm::length(v));
        }
        CHECK(reach < 0.6f);
        CHECK(reach > 0.15f);
    }
    CHECK(std::all_of(hall.building.begin(), hall.building.end(), has_one_color));
    CHECK(hall.building.size() > 10'000);
    CHECK(same_bytes(hall.building, tumbling_hall().building));
    CHECK(same_bytes(hall.bodies[5].triangles, tumbling_hall().bodies[5].triangles));
    CHECK_FALSE(same_bytes(hall.bodies[5].triangles, tumbling_hall({.seed = 2}).bodies[5].triangles));
    CHECK_THROWS_AS(tumbling_hall({.bodies = 0}), std::invalid_argument);
    CHECK_THROWS_AS(tumbling_hall({.rooms_per_side = 0}), std::invalid_argument);
}

TEST_CASE("bodies of a tumbling hall move rigidly, continuously, inside, and come back", "[scenes]") {
    const TumblingHall hall = tumbling_hall({.bodies = 20});
    Box inside = Box::empty();
    for (const VertexColoredTriangle& t : hall.building) inside.add(t.bounds());
    std::vector<glm::mat4> last = placements_at(hall, 0);
    REQUIRE(last.size() == 20);
    for (int step = 1; step <= 1000; ++step) {
        const std::vector<glm::mat4> now = placements_at(hall, step / 1000.0);
        for (std::size_t i = 0; i < now.size(); ++i) {
            float moved = 0;
            for (int c = 0; c < 4; ++c) moved = std::max(moved, glm::length(now[i][c] - last[i][c]));
            CHECK(moved < 0.06f);
            CHECK(moved > 0);
            const glm::mat3 turned(now[i]), square = glm::transpose(turned) * turned;
            for (int c = 0; c < 3; ++c) {
                for (int r = 0; r < 3; ++r) CHECK(std::abs(square[c][r] - float(c == r)) < 1e-5f);
            }
            const glm::vec3 at(now[i][3]);
            CHECK((at.x > inside.lower.x && at.x < inside.upper.x && at.z > inside.lower.z && at.z < inside.upper.z));
            CHECK((at.y > 0.3f && at.y < 2));
        }
        last = now;
    }
    CHECK(last == placements_at(hall, 0));
    CHECK(placements_at(hall, 0.25) == placements_at(hall, -1.75));
}

TEST_CASE("bodies between rooms fly through the doors", "[scenes]") {
    const TumblingHall hall = tumbling_hall({.bodies = 30});
    for (int step = 0; step < 200; ++step) {
        const std::vector<glm::mat4> at = placements_at(hall, step / 200.0);
        for (std::size_t i = 2; i < at.size(); i += 3) {
            // The wall's triangles in the plane z = 1.25: none at the middle of the body on its way.
            const float x = at[i][3].x, y = at[i][3].y;
            for (const VertexColoredTriangle& t : hall.building) {
                const Box b = t.bounds();
                const bool in_wall = b.lower.z > 1.1f && b.upper.z < 1.4f && b.lower.z == b.upper.z;
                if (!in_wall || b.lower.x >= x || b.upper.x <= x || b.lower.y >= y || b.upper.y <= y) continue;
                const auto side = [&](std::size_t k) {
                    const glm::vec3 p = t.vertices[k], q = t.vertices[(k + 1) % 3];
                    return (q.x - p.x) * (y - p.y) - (q.y - p.y) * (x - p.x) > 0;
                };
                CHECK_FALSE((side(0) == side(1) && side(1) == side(2)));
            }
        }
        if (step == 0) CHECK(at.size() == 30);
    }
}

TEST_CASE("a tumbling hall as groups is the building, its bodies and a root", "[scenes]") {
    const TumblingHall hall = tumbling_hall({.bodies = 7, .rooms_per_side = 2});
    const Scene scene = scene_at(hall, 0.3);
    REQUIRE(scene.groups.size() == 9);
    std::uint64_t triangles = hall.building.size();
    for (const Body& b : hall.bodies) triangles += b.triangles.size();
    CHECK(triangle_count(scene) == triangles);
    CHECK(same_bytes(scene.groups[0].triangles, hall.building));
    const auto& root = scene.groups.back();
    CHECK(root.triangles.empty());
    REQUIRE(root.placements.size() == 8);
    CHECK(root.placements[0].to_parent == glm::mat4(1));
    const std::vector<glm::mat4> placements = placements_at(hall, 0.3);
    for (std::size_t i = 0; i < 7; ++i) {
        CHECK(root.placements[i + 1].group == i + 1);
        CHECK(root.placements[i + 1].to_parent == placements[i]);
        CHECK(same_bytes(scene.groups[i + 1].triangles, hall.bodies[i].triangles));
    }
}
