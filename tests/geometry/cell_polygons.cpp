#include "farfield/geometry/cell_polygons.hpp"

#include <vector>

#include "catch.hpp"
#include "support/clipped_contents.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

struct Scene : ClippedContents {
    PlaneRelation relation(std::size_t i, const CuttingPlane& plane) const {
        return all().relation(i, plane, LocalPlane(plane, unit_cell()), unit_cell());
    }
};

std::vector<glm::vec3> square(float z, float tilt = 0) {
    return {{-1, -1, z}, {1, -1, z + tilt}, {1, 1, z + tilt}, {-1, 1, z}};
}
const CuttingPlane level{{0, 0, 1}, 0.25f};

}  // namespace

TEST_CASE("polygons lie behind a plane, on it, in front of it or across it", "[geometry]") {
    Scene scene;
    for (const float z : {-0.5f, 0.25f, 0.5f}) scene.add(square(z));
    scene.add(square(0, 0.5f));
    scene.add(square(0.25f, 0.5f));  // from the plane on upwards
    CHECK(scene.relation(0, level) == PlaneRelation::behind);
    CHECK(scene.relation(1, level) == PlaneRelation::on);
    CHECK(scene.relation(2, level) == PlaneRelation::in_front);
    CHECK(scene.relation(3, level) == PlaneRelation::crossing);
    CHECK(scene.relation(4, level) == PlaneRelation::in_front);
    CHECK(scene.all().instances() == 0);
    CHECK(scene.all().polygon(3).size() == 4);
}

TEST_CASE("a polygon lies on its own plane, whatever rounding made of its corners", "[geometry]") {
    Scene scene;
    scene.add(square(0.1f, 0.3f));
    const CuttingPlane own = scene.all().plane_of(0, unit_cell());
    CHECK(scene.relation(0, own) == PlaneRelation::on);
    // A corner that was cut and came out beside the plane.
    scene.corners[2].position.z += 1e-4f;
    CHECK(scene.relation(0, own) == PlaneRelation::on);
    CuttingPlane beside = own;
    beside.offset = std::nextafter(beside.offset, 2.0f);
    CHECK(scene.relation(0, beside) != PlaneRelation::on);
}

TEST_CASE("an instance is never on a plane: as thin as that it is in front", "[geometry]") {
    Scene scene;
    scene.add_instance({{-1, -1, -1}, {1, 1, 0}});
    scene.add_instance({{-1, -1, 0.25f}, {1, 1, 0.25f}});
    scene.add_instance({{-1, -1, 0.25f}, {1, 1, 1}});
    scene.add_instance({{-1, -1, 0}, {1, 1, 1}});
    scene.add(square(0));
    CHECK(scene.all().instances() == 4);
    CHECK(scene.relation(0, level) == PlaneRelation::behind);
    CHECK(scene.relation(1, level) == PlaneRelation::in_front);
    CHECK(scene.relation(2, level) == PlaneRelation::in_front);
    CHECK(scene.relation(3, level) == PlaneRelation::crossing);
}

TEST_CASE("one item needs no order, nor do polygons in one plane", "[geometry]") {
    Scene scene;
    CHECK(scene.all().need_no_order(unit_cell()));
    scene.add(square(0.25f));
    CHECK(scene.all().need_no_order(unit_cell()));
    scene.add({{0, 0, 0.25f}, {1, 0, 0.25f}, {0, 1, 0.25f}});
    CHECK(scene.all().need_no_order(unit_cell()));
    scene.add(square(0.25f, 0.01f));
    CHECK_FALSE(scene.all().need_no_order(unit_cell()));
    Scene instance;
    instance.add_instance({glm::vec3(-1), glm::vec3(1)});
    CHECK(instance.all().need_no_order(unit_cell()));
    instance.add(square(3));
    CHECK_FALSE(instance.all().need_no_order(unit_cell()));
}
