#include "farfield/raster/sample_projection.hpp"

#include <cmath>

#include "catch.hpp"
#include "support/random.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

namespace {

/// In samples from the upper left corner, and q.
glm::dvec3 on_grid(const SampleProjection& to, glm::vec3 p) {
    const glm::vec3 w = to.project(p);
    const float inverse = to.inverse_w(w.z);
    return {double(w.x * inverse + to.offset_x) / 256 - to.first_x,
            double(w.y * inverse + to.offset_y) / 256 - to.first_y, double(to.q(w.z, inverse))};
}

}  // namespace

TEST_CASE("points come where a pinhole, or parallel rays, put them, rows downwards", "[raster]") {
    Random random(820);
    for (int i = 0; i < 3000; ++i) {
        View view = i % 2 ? looking({0, 0, 4}) : looking_orthographic({0, 0, 4}, {}, 3);
        view.width = 1 + int(random.below(600));
        view.height = 1 + int(random.below(600));
        const int side = 1 + int(random.below(8));
        const SampleProjection to(LocalView(view, glm::dvec3(0), 4), side);
        CHECK((to.end_x - to.first_x == view.width * side && to.end_y - to.first_y == view.height * side));
        const glm::vec3 p = random.in_cube(1);
        const double depth = 4 - double(p.z), half = double(view.camera.half_height) * (i % 2 ? depth : 1.0);
        const double a_unit = 0.5 * view.height * side / half;
        const glm::dvec3 found = on_grid(to, p);
        CHECK(std::abs(found.x - (0.5 * view.width * side + double(p.x) * a_unit)) < 0.01);
        CHECK(std::abs(found.y - (0.5 * view.height * side - double(p.y) * a_unit)) < 0.01);
        constexpr double unit = 8;  // the power of two above the diagonal
        CHECK(found.z == Approx(i % 2 ? unit / depth : -depth / unit));
    }
}

TEST_CASE("depths in instances of any scale are those of the world", "[raster]") {
    Random random(821);
    for (int i = 0; i < 500; ++i) {
        const LocalView outer(i % 2 ? looking({0, 0, 4}) : looking_orthographic({0, 0, 4}, {}, 3), glm::dvec3(0), 4);
        const float scale = random.between(0.1f, 3);
        const Similarity placed(glm::mat3(1.0f), scale, glm::dvec3(random.in_cube(0.5f)));
        const SampleProjection world(outer, 2), inside(outer.inside(placed, glm::dvec3(0), glm::dvec3(0)), 2);
        const glm::vec3 p = random.in_cube(0.5f);
        const glm::dvec3 a = on_grid(inside, p), b = on_grid(world, glm::vec3(placed.apply(glm::dvec3(p))));
        CHECK(std::abs(a.x - b.x) < 0.01);
        CHECK(std::abs(a.y - b.y) < 0.01);
        CHECK(a.z == Approx(b.z).epsilon(1e-5));
    }
}

TEST_CASE("what is nearer has the larger q", "[raster]") {
    for (const View& view : {looking({0, 0, 4}), looking_orthographic({0, 0, 4})}) {
        const SampleProjection to(LocalView(view, glm::dvec3(0), 4), 1);
        float last = -1e30f;
        for (float z = -20; z < 3.9f; z += 0.1f) {
            const glm::vec3 w = to.project({0.1f, 0.2f, z});
            const float q = to.q(w.z, to.inverse_w(w.z));
            CHECK(q > last);
            last = q;
        }
    }
}
