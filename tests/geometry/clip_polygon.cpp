#include "farfield/geometry/clip_polygon.hpp"

#include <cmath>

#include "catch.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

const Cell unit_cell{glm::vec3(0), glm::vec3(1), glm::vec3(0), glm::vec3(1), 0, 0};

std::vector<Corner> corners_of(const std::vector<glm::vec3>& positions, Rgba8 color = {}) {
    std::vector<Corner> out;
    for (const glm::vec3& p : positions) out.push_back({p, color});
    return out;
}
std::vector<Corner> part(const std::vector<Corner>& polygon, const LocalPlane& plane, Side side) {
    std::vector<Corner> out;
    const bool is_any = append_part(polygon, plane, side, glm::vec3(glm::normalize(doubled_area(polygon))), out);
    CHECK(is_any == !out.empty());
    return out;
}
double area(const std::vector<Corner>& polygon) {
    return 0.5 * glm::length(doubled_area(polygon));
}

}  // namespace

TEST_CASE("heights are measured from the cell's center") {
    const Cell cell{{100, 200, 300}, glm::vec3(4), {100, 200, 300}, glm::vec3(4), 0, 0};
    const LocalPlane plane({{0, 1, 0}, 2}, cell);
    CHECK(plane.height(glm::vec3(7, 205, 9)) == 3);
    CHECK(plane.height(glm::vec4(7, 205, 9, 1)) == 3);
    CHECK(plane.height(glm::vec4(0, -1, 5, 0)) == -1);  // a direction
    CHECK(plane.tolerance() == 304 * 0x1p-22);
    CHECK(plane.height_or_on(glm::vec3(0, 202, 0)) == 0);
    CHECK(plane.height_or_on(glm::vec3(0, std::nextafter(202.0f, 300.0f), 0)) == 0);
    CHECK(plane.height_or_on(glm::vec3(0, 202.001f, 0)) > 0);
}

TEST_CASE("a square is halved, corners in its order, colors in between") {
    std::vector<Corner> square = corners_of({{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}});
    square[0].color = square[3].color = {0, 100, 200, 255};
    square[1].color = square[2].color = {101, 0, 200, 255};
    const LocalPlane plane({{1, 0, 0}, 0}, unit_cell);
    const auto behind = part(square, plane, Side::behind), in_front = part(square, plane, Side::in_front);
    REQUIRE(behind.size() == 4);
    REQUIRE(in_front.size() == 4);
    CHECK(behind[0].position == glm::vec3(-1, -1, 0));
    CHECK(behind[1].position == glm::vec3(0, -1, 0));
    CHECK(behind[1].color == Rgba8{51, 50, 200, 255});
    CHECK(behind[2].position == glm::vec3(0, 1, 0));
    CHECK(in_front[0].position == glm::vec3(0, -1, 0));
    CHECK(in_front[0].color == behind[1].color);
    CHECK(area(behind) == 2);
    CHECK(area(in_front) == 2);
}

TEST_CASE("corners on the plane belong to both sides, and a side with nothing but them is empty") {
    const auto triangle = corners_of({{0, -1, 0}, {1, 0, 0}, {0, 1, 0}});
    const LocalPlane through_edge({{1, 0, 0}, 0}, unit_cell), through_corner({{0, 1, 0}, 0}, unit_cell);
    CHECK(part(triangle, through_edge, Side::behind).empty());
    CHECK(part(triangle, through_edge, Side::in_front).size() == 3);
    CHECK(part(triangle, through_corner, Side::behind).size() == 3);
    CHECK(part(triangle, through_corner, Side::in_front).size() == 3);
}

TEST_CASE("parts of any polygon add up to it") {
    Random random(90);
    for (int i = 0; i < 3000; ++i) {
        const glm::vec3 a = random.in_cube(1), b = random.in_cube(1), c = random.in_cube(1),
                        normal = random.direction();
        const float offset = random.between(-1, 1);
        const LocalPlane plane({normal, offset}, unit_cell);
        const auto whole = corners_of({a, b, c});
        const auto behind = part(whole, plane, Side::behind), in_front = part(whole, plane, Side::in_front);
        CHECK(behind.size() + in_front.size() >= 3);
        CHECK(std::abs(area(behind) + area(in_front) - area(whole)) < 1e-6);
        for (const Corner& p : behind) CHECK(plane.height(p.position) <= plane.tolerance());
        for (const Corner& p : in_front) CHECK(plane.height(p.position) >= -plane.tolerance());
    }
}

TEST_CASE("polygons without area have none, to the last bit") {
    Random random(91);
    for (int i = 0; i < 1000; ++i) {
        const glm::vec3 a = random.in_cube(1), b = random.in_cube(1);
        CHECK(doubled_area(corners_of({a, b, a})) == glm::dvec3(0));
        CHECK(doubled_area(corners_of({a, 2.0f * a, 4.0f * a})) == glm::dvec3(0));
        CHECK(doubled_area(corners_of({a, a})) == glm::dvec3(0));
    }
}
