#include "farfield/geometry/cell.hpp"

#include "catch.hpp"

using namespace farfield;

TEST_CASE("a cell has a box, which it stands for, and bounds, which hold what is drawn for it", "[geometry]") {
    Cell cell;
    cell.center = {1, 2, 3};
    cell.half = {0.5f, 1, 0.25f};
    cell.bounds_center = {1, 2, 4};
    cell.bounds_half = {1, 1, 2};
    CHECK((cell.box().lower == glm::vec3(0.5f, 1, 2.75f) && cell.box().upper == glm::vec3(1.5f, 3, 3.25f)));
    CHECK((cell.bounds().lower == glm::vec3(0, 1, 2) && cell.bounds().upper == glm::vec3(2, 3, 6)));
    CHECK(cell.largest_side() == 2);
    CHECK(Cell{}.largest_side() == 0);
}
