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

TEST_CASE("larger triangles and larger images are dearer", "[cost]") {
    const MeasuredTime time;
    const Work work{.triangles = 100, .runs = 2};
    float last = time.cost(work);
    CHECK(time.cost_of_large(work, 0) == Approx(last));
    for (const float pixels : {0.1f, 1.0f, 8.0f, MeasuredTime::near_px, 1000.0f}) {
        CHECK(time.cost_of_large(work, pixels) > last);
        last = time.cost_of_large(work, pixels);
    }
    MeasuredTime odd;  // as on a machine that was busy while it was measured
    odd.near_triangle = 1;
    CHECK(odd.cost_of_large(work, 100) > odd.cost(work));
    CHECK(time.making_cost(0) == time.made_image);
    CHECK(time.making_cost(100) == Approx(time.made_image + 100 * time.made_texel));
    odd.made_texel = -1;
    CHECK(odd.wrong_option() != nullptr);
}
