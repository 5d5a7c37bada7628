#include "farfield/merged_viewer/clip_stack.hpp"

#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "catch.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::detail;
using farfield::test::Random;

namespace {

Cell unit_cell() {
    Cell cell;
    cell.half = cell.bounds_half = glm::vec3(1);
    return cell;
}

LocalPlane plane(glm::vec3 normal, float offset) {
    return LocalPlane(CuttingPlane{glm::normalize(normal), offset}, unit_cell());
}

bool keeps(const Clip& clip, glm::vec3 p) {
    const double h = clip.plane.height(p);
    return clip.side == Side::in_front ? h >= 0 : h <= 0;
}

Polygon triangle(const std::vector<glm::vec3>& vertices, const Rgba8& color) {
    return {vertices, {&color, 1}, false};
}

double area_of(std::span<const Corner> corners) {
    return corners.size() < 3 ? 0.0 : 0.5 * glm::length(doubled_area(corners));
}

}  // namespace

TEST_CASE("a longer list has what the shorter one had, which stays") {
    ClipStack clips;
    const ClipList one = clips.with({}, plane({1, 0, 0}, 0.25f), Side::in_front);
    const ClipList two = clips.with(one, plane({0, 1, 0}, 0.5f), Side::behind);
    const ClipList other = clips.with(one, plane({0, 0, 1}, 0.75f), Side::in_front);
    REQUIRE(clips[one].size() == 1);
    REQUIRE(clips[two].size() == 2);
    REQUIRE(clips[other].size() == 2);
    CHECK(clips[one][0].plane.normal() == glm::dvec3(1, 0, 0));
    CHECK(clips[two][0].plane.normal() == glm::dvec3(1, 0, 0));
    CHECK(clips[two][1].plane.normal() == glm::dvec3(0, 1, 0));
    CHECK(clips[two][1].side == Side::behind);
    CHECK(clips[other][0].side == Side::in_front);
    CHECK(clips[other][1].plane.normal() == glm::dvec3(0, 0, 1));
    const std::size_t before = clips.size();
    clips.with(other, plane({1, 1, 0}, 0), Side::behind);
    clips.shrink(before);
    CHECK(clips.size() == before);
    CHECK(clips[other][1].plane.normal() == glm::dvec3(0, 0, 1));
}

TEST_CASE("planes that a box is clear of are left out, and one that it lies beyond ends it") {
    ClipStack clips;
    const ClipList both =
        clips.with(clips.with({}, plane({1, 0, 0}, 0), Side::in_front), plane({0, 1, 0}, 0.5f), Side::behind);
    const std::size_t before = clips.size();
    const auto narrowed = [&](const Box& box, bool& left) {
        ClipList list = both;
        left = clips.narrow(list, box);
        return list;
    };
    bool left = false;
    ClipList list = narrowed({glm::vec3(-1), glm::vec3(1)}, left);
    CHECK(left);
    CHECK((list.first == both.first && list.count == 2 && clips.size() == before));
    list = narrowed({{0.25f, -1, -1}, {1, 1, 1}}, left);
    CHECK(left);
    REQUIRE(list.count == 1);
    CHECK(clips[list][0].plane.normal() == glm::dvec3(0, 1, 0));
    clips.shrink(before);
    list = narrowed({{0.25f, -1, -1}, {1, 0.25f, 1}}, left);
    CHECK((left && list.count == 0));
    narrowed({{-1, -1, -1}, {-0.25f, 1, 1}}, left);
    CHECK_FALSE(left);
    CHECK(clips.size() == before);
    narrowed({{0.25f, 0.75f, -1}, {1, 1, 1}}, left);
    CHECK_FALSE(left);
    CHECK(clips.size() == before);
}

TEST_CASE("a box shrinks to what the planes leave, and never by more") {
    Random random(500);
    std::size_t lost = 0, empty = 0, smaller = 0;
    for (int round = 0; round < 2000; ++round) {
        ClipStack clips;
        ClipList list;
        const auto count = 1 + random.below(3);
        for (std::uint32_t i = 0; i < count; ++i) {
            list = clips.with(list, plane(random.direction(), random.between(-1, 1)),
                              random.below(2) == 0 ? Side::behind : Side::in_front);
        }
        Box box{glm::vec3(-1), glm::vec3(1)};
        const bool left = clips.shrink(box, list);
        empty += !left;
        smaller += left && box.size() != glm::vec3(2);
        for (int i = 0; i < 200; ++i) {
            const glm::vec3 p = random.in_cube(1);
            bool kept = true;
            for (const Clip& clip : clips[list]) kept = kept && keeps(clip, p);
            lost += kept && !(left && box.contains(p));
        }
    }
    CHECK(lost == 0);
    CHECK(empty > 20);
    CHECK(smaller > 500);
}

TEST_CASE("a box cut along an axis is that exactly, up to a few steps") {
    ClipStack clips;
    const ClipList list =
        clips.with(clips.with({}, plane({0, 1, 0}, 0.25f), Side::in_front), plane({1, 0, 0}, 0.5f), Side::behind);
    Box box{glm::vec3(-1), glm::vec3(1)};
    REQUIRE(clips.shrink(box, list));
    CHECK(glm::length(box.lower - glm::vec3(-1, 0.25f, -1)) < 1e-5f);
    CHECK(glm::length(box.upper - glm::vec3(0.5f, 1, 1)) < 1e-5f);
}

TEST_CASE("polygons on one side of all planes are told from those that are cut") {
    PolygonClipper clipper;
    ClipStack clips;
    const ClipList list = clips.with({}, plane({1, 0, 0}, 0), Side::in_front);
    const Rgba8 red{200, 0, 0, 255};
    const std::vector<glm::vec3> right{{0.25f, 0, 0}, {1, 0, 0}, {1, 1, 0}},
        left{{-1, 0, 0}, {-0.5f, 0, 0}, {-1, 1, 0}}, across{{-1, 0, 0}, {1, 0, 0}, {1, 1, 0}},
        on{{0, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    CHECK(clipper.clip(triangle(right, red), clips[list]) == PolygonClipper::Left::all);
    CHECK(clipper.corners().size() == 3);
    CHECK(clipper.clip(triangle(left, red), clips[list]) == PolygonClipper::Left::nothing);
    CHECK(clipper.clip(triangle(on, red), clips[list]) == PolygonClipper::Left::all);
    REQUIRE(clipper.clip(triangle(across, red), clips[list]) == PolygonClipper::Left::part);
    CHECK(area_of(clipper.corners()) == Approx(0.75));
    for (const Corner& c : clipper.corners()) {
        CHECK(c.position.x >= 0);
        CHECK(c.color == red);
    }
    // What lies on the plane is in front of it, and so not behind it.
    const ClipList behind = clips.with({}, plane({1, 0, 0}, 0), Side::behind);
    CHECK(clipper.clip(triangle(on, red), clips[behind]) == PolygonClipper::Left::nothing);
    CHECK(clipper.clip(triangle(left, red), clips[behind]) == PolygonClipper::Left::all);
    CHECK(clipper.clip(triangle(right, red), clips[behind]) == PolygonClipper::Left::nothing);
    CHECK(clipper.clip(triangle(right, red), {}) == PolygonClipper::Left::all);
}

TEST_CASE("of a polygon that is cut, both parts together are the whole") {
    Random random(501);
    PolygonClipper clipper;
    std::size_t parts = 0;
    for (int round = 0; round < 2000; ++round) {
        const std::vector<glm::vec3> vertices{random.in_cube(1), random.in_cube(1), random.in_cube(1)};
        const std::vector<Rgba8> colors{random.color(), random.color(), random.color()};
        const Polygon polygon{vertices, colors, false};
        const LocalPlane cut = plane(random.direction(), random.between(-0.5f, 0.5f));
        double sum = 0;
        for (const Side side : {Side::behind, Side::in_front}) {
            const Clip clip{cut, side};
            const auto left = clipper.clip(polygon, {&clip, 1});
            if (left != PolygonClipper::Left::nothing) sum += area_of(clipper.corners());
            parts += left == PolygonClipper::Left::part;
            for (const Corner& c : clipper.corners()) {
                if (left == PolygonClipper::Left::nothing) break;
                const double h = cut.height(c.position);
                CHECK((side == Side::behind ? h <= 2 * cut.tolerance() : h >= -2 * cut.tolerance()));
            }
        }
        const std::vector<Corner> whole{{vertices[0], {}}, {vertices[1], {}}, {vertices[2], {}}};
        CHECK(sum == Approx(area_of(whole)).epsilon(1e-4).margin(1e-6));
    }
    CHECK(parts > 1000);
}
