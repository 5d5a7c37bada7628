#include "farfield/cost_model/triangle_count.hpp"

#include <string>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/build.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/spatial_hierarchy.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::test;

TEST_CASE("the paper counts a triangle as one and a face as two", "[cost]") {
    CHECK(TriangleCount{}.cost({.triangles = 1}) == 1);
    CHECK(TriangleCount{}.cost({.faces = 1}) == 2);
    CHECK(std::string(TriangleCount::unit) == "triangles");
}

TEST_CASE("dearer stand-ins are fewer", "[cost]") {
    using Cubes = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
    const Triangles triangles = random_triangles(5000, 1, 0.02f);
    std::size_t before = ~std::size_t(0);
    for (const float price : {1.0f, 4.0f, 16.0f, 100.0f, 1e6f}) {
        const Cubes h = build<Cubes>(triangles, {.cost_model = {.triangles_per_splat = price}});
        CHECK(h.report().stand_ins <= before);
        before = h.report().stand_ins;
    }
    CHECK(before == 0);
}
