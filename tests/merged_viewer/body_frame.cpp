#include "farfield/merged_viewer/body_frame.hpp"

#include "catch.hpp"
#include "support/random.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

namespace {

Cell unit_cell() {
    Cell cell;
    cell.half = cell.bounds_half = glm::vec3(1);
    return cell;
}

}  // namespace

TEST_CASE("a plane of one body is that of another, where that is") {
    // A body twice as large, turned about y by a quarter turn, and moved.
    const glm::mat3 turn(glm::vec3(0, 0, -1), glm::vec3(0, 1, 0), glm::vec3(1, 0, 0));
    const Similarity placed(turn, 2, {1, -1, 3});
    const LocalView outer(looking({0, 1, 8}), glm::dvec3(0), 4);
    const BodyFrame world(outer), body(outer.inside(placed, glm::dvec3(0), glm::dvec3(0)));
    Random random(510);
    const Cell cell = unit_cell();
    for (int i = 0; i < 200; ++i) {
        const LocalPlane plane(CuttingPlane{random.direction(), random.between(-1, 1)}, cell);
        const LocalPlane seen = body.seen(world, plane, cell);
        for (int k = 0; k < 10; ++k) {
            const glm::vec3 p = random.in_cube(1);
            CHECK(seen.height(p) * 2 == Approx(plane.height(glm::vec3(placed.apply(glm::dvec3(p))))).margin(2e-5));
        }
    }
}

TEST_CASE("a box lies behind a plane or in front of it, where it has a point on that side alone") {
    Random random(511);
    std::size_t across = 0, wrong = 0;
    for (int i = 0; i < 3000; ++i) {
        const LocalPlane plane(CuttingPlane{random.direction(), random.between(-1, 1)}, unit_cell());
        const glm::vec3 center = random.in_cube(1), half = glm::abs(random.in_cube(0.5f));
        const Box box{center - half, center + half};
        double lowest = 1e9, highest = -1e9;
        for (unsigned corner = 0; corner < 8; ++corner) {
            const glm::vec3 p(corner & 1 ? box.upper.x : box.lower.x, corner & 2 ? box.upper.y : box.lower.y,
                              corner & 4 ? box.upper.z : box.lower.z);
            lowest = std::min(lowest, plane.height(p));
            highest = std::max(highest, plane.height(p));
        }
        if (std::min(std::abs(lowest), std::abs(highest)) < 1e-6) continue;
        const PlaneRelation expected = lowest > 0    ? PlaneRelation::in_front
                                       : highest < 0 ? PlaneRelation::behind
                                                     : PlaneRelation::crossing;
        wrong += side_of_box(plane, box) != expected;
        across += expected == PlaneRelation::crossing;
    }
    CHECK(wrong == 0);
    CHECK(across > 500);
    // On the plane is in front of it.
    const LocalPlane level(CuttingPlane{{0, 0, 1}, 0}, unit_cell());
    CHECK(side_of_box(level, {{-1, -1, 0}, {1, 1, 0}}) == PlaneRelation::in_front);
    CHECK(side_of_box(level, {{-1, -1, -1}, {1, 1, 0}}) == PlaneRelation::behind);
}

TEST_CASE("a box lies behind each of its faces") {
    const Box box{{-0.5f, -0.25f, 0.1f}, {0.3f, 0.75f, 0.9f}};
    for (int face = 0; face < 6; ++face) {
        const LocalPlane plane = face_of_box(box, face, unit_cell());
        CHECK(side_of_box(plane, box) == PlaneRelation::behind);
        glm::vec3 beyond = box.center();
        beyond[face / 2] = face % 2 == 0 ? box.lower[face / 2] - 0.1f : box.upper[face / 2] + 0.1f;
        CHECK(plane.height(beyond) == Approx(0.1));
    }
}
