#include "farfield/cost_model/measured_time.hpp"

#include <string>

#include "catch.hpp"
#include "farfield/cost_model/triangle_count.hpp"

using namespace farfield;

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

TEST_CASE("models say what they count in, and are told apart in files", "[cost]") {
    CHECK(std::string(MeasuredTime::unit) == "nanoseconds");
    CHECK(TriangleCount::file_tag != MeasuredTime::file_tag);
}
