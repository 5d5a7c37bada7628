#include "farfield/merged_viewer/split_region.hpp"

#include <glm/geometric.hpp>
#include <vector>

#include "catch.hpp"
#include "support/random.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

namespace {

/// A body whose coordinates are the world's.
BodyFrame frame() {
    return BodyFrame(LocalView(looking({0, 0, 8}), glm::dvec3(0), 4));
}

BodyPart part(std::uint32_t body, glm::vec3 lower, glm::vec3 upper) {
    BodyPart p;
    p.body = body;
    p.box = {lower, upper};
    p.cell.center = p.cell.bounds_center = p.box.center();
    p.cell.half = p.cell.bounds_half = 0.5f * p.box.size();
    return p;
}

BodyPart slab(std::uint32_t body, float from, float to) {
    return part(body, {from, -1, -1}, {to, 1, 1});
}

}  // namespace

TEST_CASE("parts go to the sides of a plane that they lie on, and those across it to both") {
    const std::vector<BodyFrame> frames(4, frame());
    ClipStack clips;
    SidesOfPlane sides;
    std::vector<BodyPart> parts{slab(0, -3, -1), slab(1, 1, 2), slab(2, -1, 1), slab(3, 0, 1)};
    for (BodyPart& p : parts) p.visibility_tested = true;
    const LocalPlane plane(CuttingPlane{{1, 0, 0}, 0}, part(0, glm::vec3(-1), glm::vec3(1)).cell);
    divide(parts, frames, 0, plane, clips, sides);
    REQUIRE(sides.behind.size() == 2);
    REQUIRE(sides.in_front.size() == 3);
    CHECK((sides.behind[0].body == 0 && sides.behind[1].body == 2));
    CHECK((sides.in_front[0].body == 1 && sides.in_front[1].body == 2 && sides.in_front[2].body == 3));
    // Only the one across is cut, and has to be asked for again.
    CHECK((sides.behind[0].clips.count == 0 && sides.behind[0].visibility_tested));
    CHECK((sides.in_front[2].clips.count == 0 && sides.in_front[2].visibility_tested));
    REQUIRE(sides.behind[1].clips.count == 1);
    REQUIRE(sides.in_front[1].clips.count == 1);
    CHECK(clips[sides.behind[1].clips][0].side == Side::behind);
    CHECK(clips[sides.in_front[1].clips][0].side == Side::in_front);
    CHECK_FALSE((sides.behind[1].visibility_tested || sides.in_front[1].visibility_tested));
    // What was there is forgotten.
    divide({}, frames, 0, plane, clips, sides);
    CHECK((sides.behind.empty() && sides.in_front.empty()));
}

TEST_CASE("the largest of polygons in one plane says which") {
    // Two in one plane, up to rounding; the larger one is exact.
    const std::vector<glm::vec3> vertices{{0, 0, 0.25f}, {0.01f, 0, 0.25f}, {0, 0.01f, 0.250001f},
                                          {0, 0, 0.25f}, {1, 0, 0.25f},     {0, 1, 0.25f}};
    const std::vector<std::uint32_t> first{0, 3, 6};
    const std::vector<Rgba8> colors(6);
    const Cell cell = part(0, glm::vec3(-1), glm::vec3(1)).cell;
    const LocalPlane plane = plane_of_polygons({first, vertices, colors}, 0, 2, cell);
    CHECK(plane.normal() == glm::dvec3(0, 0, 1));
    CHECK(plane.height(glm::vec3(0, 0, 0.25f)) == 0);
    const LocalPlane small = plane_of_polygons({first, vertices, colors}, 0, 1, cell);
    CHECK(small.normal() != glm::dvec3(0, 0, 1));
}

TEST_CASE("a face that separates cuts nothing and has something beyond it") {
    const std::vector<BodyFrame> frames(8, frame());
    // Side by side: one to two, the one whose face it is counted.
    const std::vector<BodyPart> three{slab(0, -3, -2), slab(1, 0, 1), slab(2, 2, 3)};
    const auto face = separating_face(three, frames);
    REQUIRE(face);
    const LocalPlane plane = face_of_box(three[face->part].box, face->face, three[face->part].cell);
    int cut = 0, in_front = 0;
    for (std::size_t i = 0; i < three.size(); ++i) {
        if (i == face->part) continue;
        const PlaneRelation relation = side_of_box(plane, three[i].box);
        cut += relation == PlaneRelation::crossing;
        in_front += relation == PlaneRelation::in_front;
    }
    CHECK(cut == 0);
    CHECK((in_front == 1 || in_front == 2));
    // Of two that meet, and of one within another, none.
    CHECK_FALSE(separating_face(std::vector<BodyPart>{slab(0, -1, 1), slab(1, 0, 2)}, frames));
    CHECK_FALSE(
        separating_face(std::vector<BodyPart>{slab(0, -1, 1), part(1, glm::vec3(-0.5f), glm::vec3(0.5f))}, frames));
    // Those that touch do not meet.
    CHECK(separating_face(std::vector<BodyPart>{slab(0, -1, 0), slab(1, 0, 2)}, frames));
}

TEST_CASE("of many parts the face that divides them most evenly is taken, though it may cut few") {
    std::vector<BodyPart> parts;
    for (int i = 0; i < 8; ++i) parts.push_back(slab(std::uint32_t(i), float(2 * i), float(2 * i + 1)));
    const std::vector<BodyFrame> frames(9, frame());
    const auto face = separating_face(parts, frames);
    REQUIRE(face);
    int behind = 0;
    const LocalPlane plane = face_of_box(parts[face->part].box, face->face, parts[face->part].cell);
    for (const BodyPart& p : parts) behind += side_of_box(plane, p.box) == PlaneRelation::behind;
    CHECK((behind == 4 || behind == 3));
    // One long one across all the faces, which few others cross: one cut costs four, and there are four on each side.
    parts.push_back(part(8, {-1, -0.1f, -0.1f}, {16, 0.1f, 0.1f}));
    REQUIRE(separating_face(parts, frames));
    parts.erase(parts.begin(), parts.begin() + 4);
    CHECK_FALSE(separating_face(parts, frames));
}
