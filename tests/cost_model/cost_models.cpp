#include <cmath>
#include <string>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/measured_time.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/spatial_hierarchy.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::test;

TEMPLATE_TEST_CASE("cost is linear in every kind of work", "[cost]", TriangleCount, MeasuredTime) {
    const TestType model;
    const Work all{1, 2, 3, 4, 5, 6, 7};
    CHECK(model.cost({}) == 0);
    CHECK(model.cost(all * 3) == Approx(3 * model.cost(all)));
    Work twice = all;
    twice += all;
    CHECK(model.cost(twice) == Approx(2 * model.cost(all)));
    const Work kinds[] = {{.triangles = 1}, {.faces = 1}, {.splats = 1}, {.images = 1},
                          {.texels = 1},    {.cells = 1}, {.runs = 1}};
    float sum = 0;
    for (int i = 0; i < 7; ++i) {
        CHECK(model.cost(kinds[i]) > 0);
        sum += float(i + 1) * model.cost(kinds[i]);
    }
    CHECK(sum == Approx(model.cost(all)));
}

TEST_CASE("the paper counts a triangle as one and a face as two", "[cost]") {
    CHECK(TriangleCount{}.cost({.triangles = 1}) == 1);
    CHECK(TriangleCount{}.cost({.faces = 1}) == 2);
    CHECK(std::string(TriangleCount::unit) == "triangles");
    CHECK(std::string(MeasuredTime::unit) == "nanoseconds");
    CHECK(TriangleCount::file_tag != MeasuredTime::file_tag);
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
