#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <stdexcept>

#include "catch.hpp"
#include "farfield/geometry/similarity.hpp"
#include "scenes/generate/boxes.hpp"
#include "scenes/generate/building.hpp"
#include "scenes/generate/chessboard.hpp"
#include "scenes/generate/quadrupled_forest.hpp"
#include "scenes/generate/square_cube.hpp"

using namespace farfield;
using namespace farfield::scenes;

namespace {

using Triangles = std::vector<VertexColoredTriangle>;
using glm::dvec3;

bool identical(const Scene& a, const Scene& b) {
    if (a.groups.size() != b.groups.size()) return false;
    for (std::size_t g = 0; g < a.groups.size(); ++g) {
        const Group &s = a.groups[g], &t = b.groups[g];
        if (s.triangles.size() != t.triangles.size() || s.placements.size() != t.placements.size()) return false;
        if (!s.triangles.empty() &&
            std::memcmp(s.triangles.data(), t.triangles.data(), s.triangles.size() * sizeof(VertexColoredTriangle))) {
            return false;
        }
        for (std::size_t i = 0; i < s.placements.size(); ++i) {
            if (s.placements[i].group != t.placements[i].group) return false;
            if (s.placements[i].to_parent != t.placements[i].to_parent) return false;
        }
    }
    return true;
}

bool all_finite(const Scene& scene) {
    for (const Group& group : scene.groups) {
        for (const VertexColoredTriangle& t : group.triangles) {
            if (!t.bounds().is_finite() || !(t.area() > 0)) return false;
        }
    }
    return true;
}

dvec3 normal(const VertexColoredTriangle& t) {
    const dvec3 a(t.vertices[0]), b(t.vertices[1]), c(t.vertices[2]);
    return glm::cross(b - a, c - a);
}

/// Every directed edge once, and its opposite once, bit for bit.
bool is_watertight(const VertexColoredTriangle* first, std::size_t count) {
    using Edge = std::array<float, 6>;
    std::vector<Edge> edges, opposite;
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
            const glm::vec3 p = first[i].vertices[k], q = first[i].vertices[(k + 1) % 3];
            edges.push_back({p.x, p.y, p.z, q.x, q.y, q.z});
            opposite.push_back({q.x, q.y, q.z, p.x, p.y, p.z});
        }
    }
    std::sort(edges.begin(), edges.end());
    std::sort(opposite.begin(), opposite.end());
    return edges == opposite && std::adjacent_find(edges.begin(), edges.end()) == edges.end();
}

/// Triangles that the segment passes through (Moeller and Trumbore 1997), from both sides, by looking at all.
std::size_t hits(const Triangles& triangles, dvec3 from, dvec3 to) {
    std::size_t count = 0;
    const dvec3 direction = to - from;
    for (const VertexColoredTriangle& t : triangles) {
        const dvec3 a(t.vertices[0]), e1 = dvec3(t.vertices[1]) - a, e2 = dvec3(t.vertices[2]) - a;
        const dvec3 p = glm::cross(direction, e2);
        const double determinant = glm::dot(e1, p);
        if (determinant == 0) continue;
        const dvec3 s = (from - a) / determinant, q = glm::cross(s, e1);
        const double u = glm::dot(s, p), v = glm::dot(direction, q), at = glm::dot(e2, q);
        count += u >= 0 && v >= 0 && u + v <= 1 && at >= 0 && at <= 1;
    }
    return count;
}

/// Where the point falls in the image, +-1 at its edges if it is square; behind the camera: infinity.
glm::dvec2 projected(const Camera& camera, dvec3 p) {
    const dvec3 d = p - camera.eye;
    const double depth = glm::dot(d, dvec3(camera.forward)) * double(camera.half_height);
    if (!(depth > 0)) return glm::dvec2(std::numeric_limits<double>::infinity());
    return {glm::dot(d, dvec3(camera.right)) / depth, glm::dot(d, dvec3(camera.up)) / depth};
}

/// The largest coordinate of a projected corner.
double reach(const Camera& camera, const Box& box) {
    double most = 0;
    for (int i = 0; i < 8; ++i) {
        const glm::vec3 corner(i & 1 ? box.upper.x : box.lower.x, i & 2 ? box.upper.y : box.lower.y,
                               i & 4 ? box.upper.z : box.lower.z);
        const glm::dvec2 p = projected(camera, dvec3(corner));
        most = std::max({most, std::abs(p.x), std::abs(p.y)});
    }
    return most;
}

/// One floor, one corridor, three rooms on each side of it: x from -6 to 6, z from -6.25 to 6.25.
BuildingOptions small_building() {
    BuildingOptions options;
    options.floors = options.corridors = 1;
    options.rooms_per_side = 3;
    return options;
}

}  // namespace

TEST_CASE("a chessboard has the nearest number of triangles that is twice a square", "[scenes]") {
    for (std::uint32_t wanted = 1; wanted < 700; ++wanted) {
        ChessboardOptions options;
        options.triangles = wanted;
        const std::uint32_t n = squares_per_side(options);
        const auto distance = [&](std::uint32_t k) { return std::abs(2.0 * k * k - wanted); };
        CHECK(n >= 1);
        CHECK(distance(n) <= distance(n + 1));
        if (n > 1) CHECK(distance(n) <= distance(n - 1));
        CHECK(triangle_count(chessboard(wanted)) == 2 * n * n);
    }
    CHECK(triangle_count(chessboard(80'000)) == 80'000);
    CHECK(triangle_count(chessboard(2'000'000)) == 2'000'000);
    ChessboardOptions huge;
    huge.triangles = 320'000'000;
    CHECK(2u * squares_per_side(huge) * squares_per_side(huge) == 319'994'402);
    huge.triangles = 4'294'967'295;
    CHECK(squares_per_side(huge) == 46'341);
}

TEST_CASE("the squares of a chessboard tile it, alternate, and are seen from above", "[scenes]") {
    for (const float side : {100.0f, 7.3f, 1e-20f, 1e20f}) {
        for (const std::uint32_t n : {1u, 2u, 7u, 100u}) {
            ChessboardOptions options;
            options.side_m = side;
            options.triangles = 2 * n * n;
            const Scene scene = chessboard(options);
            const Triangles& t = scene.groups[0].triangles;
            REQUIRE(t.size() == 2 * n * n);
            CHECK(bounds(scene).lower == glm::vec3(-0.5f * side, 0, -0.5f * side));
            CHECK(bounds(scene).upper == glm::vec3(0.5f * side, 0, 0.5f * side));
            // Square (column, row) shares the bits of its corners with the next ones along x and z; so nothing is left
            // open and nothing covered twice between the outer lines.
            std::size_t wrong = 0;
            for (std::size_t i = 0; i < t.size(); i += 2) {
                const glm::vec3 a = t[i].vertices[0], b = t[i].vertices[1], c = t[i].vertices[2];
                const glm::vec3 d = t[i + 1].vertices[2];
                const std::size_t column = i / 2 % n, row = i / 2 / n;
                wrong += !(t[i + 1].vertices[0] == a && t[i + 1].vertices[1] == c);
                wrong += !(a.x == b.x && c.x == d.x && a.z == d.z && b.z == c.z && a.x < c.x && a.z < c.z);
                wrong += !(normal(t[i]).y >= 0 && normal(t[i + 1]).y >= 0 && a.y == 0 && c.y == 0);
                wrong += t[i].rgba[0] != t[i + 1].rgba[2];
                if (column + 1 < n) wrong += !(t[i + 2].vertices[0] == d && t[i + 2].vertices[1] == c);
                if (column + 1 < n) wrong += t[i].rgba[0] == t[i + 2].rgba[0];
                if (row + 1 < n) wrong += !(t[i + 2 * n].vertices[0] == b && t[i + 2 * n].vertices[2].x == c.x);
                if (row + 1 < n) wrong += t[i].rgba[0] == t[i + 2 * n].rgba[0];
            }
            CHECK(wrong == 0);
        }
    }
    CHECK(identical(chessboard(5'000), chessboard(5'000)));
    CHECK(all_finite(chessboard(5'000)));
    const Camera low = low_over_chessboard(ChessboardOptions{});
    CHECK(low.eye.y == Approx(2));
    CHECK(std::abs(projected(low, {0, 0, 0}).y) < 1);
}

TEST_CASE("an impossible chessboard is refused", "[scenes]") {
    ChessboardOptions options;
    options.triangles = 0;
    CHECK_THROWS_AS(chessboard(options), std::invalid_argument);
    for (const float side : {0.0f, -1.0f, 1e-38f, std::numeric_limits<float>::infinity(), std::nanf("")}) {
        options = {};
        options.side_m = side;
        CHECK_THROWS_AS(chessboard(options), std::invalid_argument);
    }
}

TEST_CASE("the square cube has 192 flat squares that face the diagonal, all in view", "[scenes]") {
    for (const SquareCubeForm form : {SquareCubeForm::faces, SquareCubeForm::cubes}) {
        SquareCubeOptions options;
        options.form = form;
        const Scene scene = square_cube(options);
        const Triangles& t = scene.groups[0].triangles;
        REQUIRE(t.size() == 2 * 192);
        CHECK(all_finite(scene));
        CHECK(identical(scene, square_cube(options)));
        CHECK(bounds(scene).lower == glm::vec3(-1));
        CHECK(bounds(scene).upper == glm::vec3(1));
        std::array<int, 3> facing{};
        for (std::size_t i = 0; i < t.size(); i += 2) {
            const dvec3 n = glm::normalize(normal(t[i]));
            for (int axis = 0; axis < 3; ++axis) facing[std::size_t(axis)] += n[axis] > 0.999;
            CHECK(glm::dot(n, glm::normalize(normal(t[i + 1]))) > 0.999);
            CHECK(t[i].vertices[0] == t[i + 1].vertices[0]);
            CHECK(t[i].vertices[2] == t[i + 1].vertices[1]);
            CHECK(t[i].area() == Approx(t[i + 1].area()));
            CHECK(t[i].rgba == t[i + 1].rgba);
        }
        CHECK(facing == std::array<int, 3>{64, 64, 64});
        CHECK(reach(square_cube_camera(options), bounds(scene)) < 1);
        CHECK(reach(square_cube_camera(options), bounds(scene)) > 0.5);
    }
}

TEST_CASE("the squares of the cube are sorted front to back", "[scenes]") {
    for (const SquareCubeForm form : {SquareCubeForm::faces, SquareCubeForm::cubes}) {
        for (const float gap : {0.0f, 0.3f, 1.0f}) {
            SquareCubeOptions options;
            options.form = form;
            options.gap = gap;
            const Triangles t = square_cube(options).groups[0].triangles;
            for (const dvec3 eye : {square_cube_camera(options).eye, dvec3(1.5, 4, 2), dvec3(1.1, 1.2, 6)}) {
                // The segment from the eye to a square's middle passes through no square that comes after it.
                std::size_t wrong = 0;
                for (std::size_t i = 0; i < t.size(); i += 2) {
                    const dvec3 middle = 0.5 * (dvec3(t[i].vertices[0]) + dvec3(t[i].vertices[2]));
                    wrong += hits({t.begin() + std::ptrdiff_t(i) + 2, t.end()}, eye, eye + 0.999 * (middle - eye));
                }
                CHECK(wrong == 0);
            }
        }
    }
}

TEST_CASE("an impossible cube is refused", "[scenes]") {
    for (const float side : {0.0f, -1.0f, std::numeric_limits<float>::infinity(), std::nanf("")}) {
        SquareCubeOptions options;
        options.side_m = side;
        CHECK_THROWS_AS(square_cube(options), std::invalid_argument);
    }
    for (const float gap : {-0.1f, std::numeric_limits<float>::infinity(), std::nanf("")}) {
        SquareCubeOptions options;
        options.gap = gap;
        CHECK_THROWS_AS(square_cube(options), std::invalid_argument);
    }
}

TEST_CASE("the quadrupled forest has 4^levels trees and the memory of one", "[scenes]") {
    QuadrupledForestOptions options;
    options.ground = false;
    CHECK(triangle_count(quadrupled_forest(options)) == 859'668'480);  // 16,384 trees: the paper's 859 million
    const std::uint64_t tree_bytes = 52'472 * sizeof(VertexColoredTriangle);
    std::uint64_t trees = 1;
    for (std::uint32_t levels = 0; levels <= 9; ++levels, trees *= 4) {
        const Scene scene = quadrupled_forest(levels);
        CHECK(scene.groups.size() == levels + 1);
        CHECK(triangle_count(scene) == trees * 52'472);
        CHECK(bytes(scene) == tree_bytes + levels * 4 * sizeof(Placement));
        const float half = std::ldexp(4.0f, int(levels));
        CHECK(bounds(scene).lower == glm::vec3(-half, bounds(scene).lower.y, -half));
        CHECK(bounds(scene).upper.x == half);
        CHECK(bounds(scene).upper.z == half);
        CHECK(all_finite(scene));
    }
    CHECK(identical(quadrupled_forest(3), quadrupled_forest(3)));
    options.seed = 2;
    CHECK_FALSE(identical(quadrupled_forest(options), quadrupled_forest(7)));
    options.levels = 20;
    CHECK(triangle_count(quadrupled_forest(options)) == (std::uint64_t{1} << 40) * 52'470);
}

TEST_CASE("every level of the quadrupled forest turns its four differently", "[scenes]") {
    const Scene scene = quadrupled_forest(7);
    for (std::size_t g = 1; g < scene.groups.size(); ++g) {
        CHECK(scene.groups[g].triangles.empty());
        REQUIRE(scene.groups[g].placements.size() == 4);
        for (std::size_t i = 0; i < 4; ++i) {
            const Placement& p = scene.groups[g].placements[i];
            CHECK(p.group == g - 1);
            CHECK_NOTHROW(Similarity(p.to_parent));
            for (std::size_t k = 0; k < i; ++k) {
                CHECK(glm::mat3(p.to_parent) != glm::mat3(scene.groups[g].placements[k].to_parent));
            }
        }
    }
}

TEST_CASE("the ground of the quadrupled forest has no gaps", "[scenes]") {
    QuadrupledForestOptions options;
    options.levels = 3;
    options.tree_triangles = 2'000;
    const Triangles t = expanded(quadrupled_forest(options)).groups[0].triangles;
    REQUIRE(t.size() == 64 * 2'002);
    // Patches are squares of 8 m: each corner inside belongs to four of them, and there are 9 x 9 corners.
    std::map<std::pair<float, float>, int> corners;
    for (std::size_t tree = 0; tree < 64; ++tree) {
        const VertexColoredTriangle &a = t[tree * 2'002 + 2'000], &b = t[tree * 2'002 + 2'001];
        CHECK(normal(a) == dvec3(0, 64, 0));
        CHECK(normal(b) == dvec3(0, 64, 0));
        for (const glm::vec3& v : a.vertices) ++corners[{v.x, v.z}];
        ++corners[{b.vertices[2].x, b.vertices[2].z}];
    }
    CHECK(corners.size() == 81);
    for (const auto& [at, count] : corners) {
        CHECK(count == (std::abs(at.first) < 32 ? 2 : 1) * (std::abs(at.second) < 32 ? 2 : 1));
    }
}

TEST_CASE("cameras see the quadrupled forest from the edge and all of it from above", "[scenes]") {
    double last = 0;
    for (std::uint32_t levels = 0; levels <= 8; ++levels) {
        QuadrupledForestOptions options;
        options.levels = levels;
        const Box box = bounds(quadrupled_forest(levels));
        for (const double elevation : {10.0, 35.0, 80.0}) CHECK(reach(aerial(options, elevation), box) < 1);
        const float half = float(half_extent_m(options)) + 2;  // what it leaves room for
        CHECK(reach(aerial(options), {{-half, 0, -half}, {half, 12, half}}) > 0.95);
        CHECK(reach(aerial(options), {{-half, 0, -half}, {half, 12, half}}) < 1);
        CHECK(glm::length(aerial(options).eye) > last);
        last = glm::length(aerial(options).eye);
        CHECK(eye_level(options, 1.7).eye.y == 1.7);
        CHECK(eye_level(options).eye.z - half_extent_m(options) == 2);
        CHECK(eye_level(options).forward.z < -0.9f);
    }
}

TEST_CASE("an impossible quadrupled forest is refused", "[scenes]") {
    QuadrupledForestOptions options;
    options.levels = 21;
    CHECK_THROWS_AS(quadrupled_forest(options), std::invalid_argument);
    options = {};
    options.tree_triangles = 10;
    CHECK_THROWS_AS(quadrupled_forest(options), std::invalid_argument);
    for (const float spacing : {0.0f, -8.0f, 1e38f, std::nanf("")}) {
        options = {};
        options.spacing_m = spacing;
        CHECK_THROWS_AS(quadrupled_forest(options), std::invalid_argument);
    }
}

TEST_CASE("a building is made of closed boxes that face outwards, wherever they are placed", "[scenes]") {
    const Scene scene = building(small_building());
    CHECK(all_finite(scene));
    for (const Group& group : scene.groups) CHECK(group.triangles.size() % triangles_per_box == 0);
    const Triangles t = expanded(scene).groups[0].triangles;
    std::size_t leaky = 0, inward = 0;
    for (std::size_t first = 0; first < t.size(); first += triangles_per_box) {
        leaky += !is_watertight(&t[first], triangles_per_box);
        Box box = Box::empty();
        for (std::size_t i = first; i < first + triangles_per_box; ++i) box.add(t[i].bounds());
        for (std::size_t i = first; i < first + triangles_per_box; ++i) {
            inward += !(glm::dot(normal(t[i]), dvec3(t[i].vertices[0]) - dvec3(box.center())) > 0);
        }
    }
    CHECK(leaky == 0);
    CHECK(inward == 0);
}

TEST_CASE("a building has the extent of its plan, with walls and without", "[scenes]") {
    for (const bool walls : {true, false}) {
        BuildingOptions options = small_building();
        options.floors = 3;
        options.corridors = 2;
        options.exterior_walls = walls;
        const Box box = bounds(building(options));
        const double wider = 0.0625 + 0.03125;  // posts, and window sills
        CHECK(box.lower.y == -0.25f);
        CHECK(box.upper.y == 3 * 3.5f);
        CHECK(box.upper.x == Approx(6 + (walls ? wider : 0.0625)));
        CHECK(box.upper.z == Approx(12.5 + (walls ? wider : 0.0625)));
        CHECK(box.lower.x == -box.upper.x);
        CHECK(box.lower.z == -box.upper.z);
        CHECK(reach(outside_building(options), box) <= 1);
        CHECK(reach(outside_building(options), box) > 0.7);
    }
}

TEST_CASE("floors are replicated: triangles grow with them, memory hardly", "[scenes]") {
    BuildingOptions options;
    const Scene usual = building(options);
    CHECK(triangle_count(usual) == 961'452);
    CHECK(identical(usual, building(options)));
    options.seed = 2;
    CHECK_FALSE(identical(usual, building(options)));
    options.seed = 1;
    options.floors = 10;
    const Scene higher = building(options);
    CHECK(triangle_count(higher) - 12 == 2 * (triangle_count(usual) - 12));  // 12: the roof
    CHECK(bytes(higher) == bytes(usual) + 5 * sizeof(Placement));
    options = {};
    options.exterior_walls = false;
    CHECK(triangle_count(building(options)) == 938'772);
    const Scene greene = building(building_of_408_floors());
    CHECK(triangle_count(greene) == 2 * std::uint64_t{166'346'502});  // "approximately 167 million"
    CHECK(bytes(greene) < 1'000'000);
    CHECK(expanded(usual).groups[0].triangles.size() == triangle_count(usual));
}

TEST_CASE("one sees through the doors of a building and not through its walls", "[scenes]") {
    const Triangles t = expanded(building(small_building())).groups[0].triangles;
    for (const double x : {-4.0, 0.0, 4.0}) {
        // From the middle of one room through two doors across the corridor into the other, above the furniture.
        CHECK(hits(t, {x, 1.65, -4.1}, {x, 1.65, 4.1}) == 0);
        CHECK(hits(t, {x + 0.35, 1.65, -1.5}, {x - 0.35, 1.65, 1.5}) == 0);
        // Beside the doors there are two walls, above them two lintels: in and out of each.
        CHECK(hits(t, {x + 1.3, 1.65, -2.0}, {x + 1.3, 1.65, 2.0}) == 4);
        CHECK(hits(t, {x + 0.01, 2.4, -2.0}, {x + 0.01, 2.4, 2.0}) == 4);
    }
    // Along the corridor.
    CHECK(hits(t, {-5.8, 1.65, 0.1}, {5.8, 1.65, 0.1}) == 0);
    // The floor is closed: straight down through the slab of a room and of the corridor.
    CHECK(hits(t, {0.3, 0.5, 0.2}, {0.3, -1, 0.2}) == 2);
    CHECK(hits(t, {0.3, 0.03, 2.0}, {0.3, -1, 2.0}) == 2);
}

TEST_CASE("some neighbors have a door between them, open as well", "[scenes]") {
    BuildingOptions options = small_building();
    options.rooms_per_side = 12;
    const Triangles t = expanded(building(options)).groups[0].triangles;
    std::size_t open = 0;
    for (int i = 1; i < 12; ++i) {
        const double x = 4.0 * i - 24.0, z = -6.25 + 3.625;
        const std::size_t walls = hits(t, {x - 0.3, 1.65, z + 0.01}, {x + 0.3, 1.65, z + 0.01});
        CHECK((walls == 0 || walls == 2));
        open += walls == 0;
    }
    CHECK(open > 0);
    CHECK(open < 11);
}

TEST_CASE("without exterior walls one sees into a building", "[scenes]") {
    for (const bool walls : {true, false}) {
        BuildingOptions options = small_building();
        options.exterior_walls = walls;
        const Triangles t = expanded(building(options)).groups[0].triangles;
        for (const double x : {-4.3, 0.3, 4.3}) {
            CHECK(hits(t, {x, 0.02, -8}, {x, 0.02, -6.1}) == (walls ? 2 : 0));
            CHECK(hits(t, {x, 1.7, -8}, {x, 1.7, -6.1}) == 0);  // a window, without glass
        }
        CHECK((hits(t, {-9, 0.5, 0}, {-5.5, 0.5, 0}) == 0) == !walls);
    }
}

TEST_CASE("the camera inside a building looks through two doors", "[scenes]") {
    for (const std::size_t corridors : {1u, 2u, 3u}) {
        for (const std::size_t floors : {1u, 2u, 3u}) {
            BuildingOptions options = small_building();
            options.corridors = corridors;
            options.floors = floors;
            const Triangles t = expanded(building(options)).groups[0].triangles;
            const Camera camera = inside_building(options);
            CHECK(hits(t, camera.eye, camera.eye + 8.0 * dvec3(camera.forward)) == 0);
            for (const double aside : {-0.3, 0.3}) {  // the wall on both sides of the door
                const dvec3 direction = dvec3(camera.forward) + aside * dvec3(camera.right);
                CHECK(hits(t, camera.eye, camera.eye + 8.0 * direction) >= 2);
            }
        }
    }
}

TEST_CASE("an impossible building is refused", "[scenes]") {
    for (std::size_t BuildingOptions::*count : {&BuildingOptions::floors, &BuildingOptions::corridors,
                                                &BuildingOptions::rooms_per_side, &BuildingOptions::room_kinds}) {
        BuildingOptions options;
        options.*count = 0;
        CHECK_THROWS_AS(building(options), std::invalid_argument);
    }
    BuildingOptions least = small_building();
    least.rooms_per_side = least.room_kinds = 1;
    CHECK(triangle_count(building(least)) > 0);
}
