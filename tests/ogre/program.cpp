#include "catch.hpp"
#include "support/forest_program.hpp"

TEST_CASE("the program draws a forest in Ogre in four ways, prints a table and writes pictures") {
    farfield::test::check_forest_program(FOREST_PROGRAM, {"plain", "LOD generated", "StaticGeometry", "farfield"});
}
