#include "farfield/view/local_view.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/vec2.hpp>

#include "catch.hpp"
#include "farfield/raster/sample_projection.hpp"
#include "support/pictures.hpp"
#include "support/random.hpp"

using namespace farfield;
using farfield::detail::SampleProjection;
using namespace farfield::test;

namespace {

/// On the picture, in pixels from its upper left corner; and q.
glm::dvec3 on_picture(const LocalView& view, glm::dvec3 p) {
    const SampleProjection to(view, 1);
    const glm::vec3 w = to.project(glm::vec3(p));
    const float inverse = to.inverse_w(w.z);
    return {double(w.x * inverse + to.offset_x) / 256 - to.first_x,
            double(w.y * inverse + to.offset_y) / 256 - to.first_y, double(to.q(w.z, inverse))};
}

}  // namespace

TEST_CASE("inside the planes is what lies on the picture") {
    Random random(150);
    int inside = 0;
    for (int i = 0; i < 5000; ++i) {
        View v = i % 2 ? looking(random.in_cube(2), random.in_cube(1))
                       : looking_orthographic(random.in_cube(2), random.in_cube(1), 2);
        v.width = 50 + int(random.below(300));
        v.height = 50 + int(random.below(300));
        v.camera.near_depth = 0.3f;
        const LocalView view(v, {}, 4);
        const glm::vec3 p = random.in_cube(3);
        double least = 1e30;
        for (const glm::vec4& plane : view.planes)
            least = std::min(least, double(glm::dot(glm::vec3(plane), p) + plane.w));
        if (std::abs(least) < 1e-4) continue;
        const glm::dvec3 at = on_picture(view, p);
        const bool seen = view.depth(p) >= 0.3f && at.x >= 0 && at.x <= v.width && at.y >= 0 && at.y <= v.height;
        CHECK(seen == (least > 0));
        inside += seen;
    }
    CHECK(inside > 200);
}

TEST_CASE("planes have unit normals, and the near one may be missing") {
    const LocalView view(looking_orthographic({1, 2, 3}), {}, 4);
    for (std::size_t i = 0; i < 4; ++i) CHECK(std::abs(glm::length(glm::vec3(view.planes[i])) - 1) < 1e-6f);
    CHECK(view.planes[4] == glm::vec4(0, 0, 0, 1));
    const LocalView perspective(looking({1, 2, 3}), {}, 4);
    CHECK(perspective.near_depth == 4 * 0x1p-40f);
    CHECK(perspective.planes[5] == glm::vec4(0, 0, 0, 1));
    View v = looking({1, 2, 3});
    v.camera.far_depth = 5;
    for (const glm::vec4& p : LocalView(v, {}, 4).planes) CHECK(std::abs(glm::length(glm::vec3(p)) - 1) < 1e-6f);
}

TEST_CASE("a view from inside an instance shows its points where the world's view does") {
    Random random(151);
    for (int i = 0; i < 500; ++i) {
        View v = i % 2 ? looking(random.in_cube(1) + glm::vec3(0, 0, 8), random.in_cube(1), 300)
                       : looking_orthographic(random.in_cube(1) + glm::vec3(0, 0, 8), random.in_cube(1), 5, 300);
        v.camera.near_depth = 0.5f;
        const glm::dvec3 outer_origin = glm::dvec3(random.in_cube(i % 3 == 0 ? 1e6f : 1.0f)),
                         inner_origin = glm::dvec3(random.in_cube(2));
        v.camera.eye += outer_origin;
        const LocalView outer(v, outer_origin, 10);
        glm::dmat4 m = glm::translate(glm::dmat4(1), outer_origin + glm::dvec3(random.in_cube(1)));
        m = glm::rotate(m, double(random.between(0, 6)), glm::dvec3(random.direction()));
        const double scale = double(random.between(0.1f, 5));
        m = glm::scale(m, glm::dvec3(scale));
        const Similarity placed(m);
        const LocalView inner = outer.inside(placed, outer_origin, inner_origin);
        CHECK(inner.near_depth * placed.scale() == Approx(0.5f));
        CHECK(inner.scale == Approx(scale));
        const glm::dvec3 p = glm::dvec3(random.in_cube(1)) / scale;
        const glm::dvec3 a = on_picture(outer, placed.apply(p) - outer_origin), b = on_picture(inner, p - inner_origin);
        CHECK(glm::length(glm::dvec2(a) - glm::dvec2(b)) < 0.02);
        CHECK(std::abs(a.z - b.z) < 2e-5 * (1 + std::abs(a.z)));
        // And says where they lie, of instances in instances too.
        const auto outermost = [](const LocalView& in, glm::dvec3 at) {
            return in.place + glm::dmat3(in.turned) * at * double(in.scale);
        };
        CHECK(outermost(outer, p) == p);
        CHECK(glm::length(outermost(inner, p - inner_origin) - (placed.apply(p) - outer_origin)) < 1e-5);
        const LocalView innermost = inner.inside(placed, inner_origin, inner_origin);
        CHECK(glm::length(outermost(innermost, p - inner_origin) - outermost(inner, placed.apply(p) - inner_origin)) <
              1e-4 * (1 + scale * glm::length(outer_origin)));
        // What is inside the planes stays inside.
        for (std::size_t k = 0; k < 5; ++k) {
            const double da =
                glm::dot(glm::dvec3(outer.planes[k]), placed.apply(p) - outer_origin) + double(outer.planes[k].w);
            const double db =
                (glm::dot(glm::dvec3(inner.planes[k]), p - inner_origin) + double(inner.planes[k].w)) * scale;
            CHECK(std::abs(da - db) < 1e-4);
        }
        Cell cell;
        cell.center = glm::vec3(p - inner_origin);
        cell.half = glm::vec3(0.01f);
        CHECK(std::isfinite(inner.distance_to(cell)));
    }
}

TEST_CASE("distance is that to the nearest point of the box, or depth, never below 0") {
    Random random(152);
    for (int i = 0; i < 3000; ++i) {
        View v = looking(random.in_cube(3), random.in_cube(1));
        v.distance = i % 2 ? DistanceMeasure::depth : DistanceMeasure::nearest_point;
        const LocalView view(v, {}, 4);
        Cell cell;
        cell.center = random.in_cube(3);
        cell.half = glm::vec3(random.between(0, 1), random.between(0, 1), random.between(0, 1));
        double expected = 1e30;
        const Box box = cell.box();
        if (v.distance == DistanceMeasure::nearest_point) {
            expected = glm::length(glm::dvec3(glm::clamp(view.eye, box.lower, box.upper)) - glm::dvec3(view.eye));
        } else {
            for (int c = 0; c < 8; ++c) {
                const glm::vec3 corner(c & 1 ? box.upper.x : box.lower.x, c & 2 ? box.upper.y : box.lower.y,
                                       c & 4 ? box.upper.z : box.lower.z);
                expected = std::min(expected, double(glm::dot(corner - view.eye, view.forward)));
            }
            expected = std::max(expected, 0.0);
        }
        CHECK(std::abs(double(view.distance_to(cell)) - expected) < 1e-5);
        CHECK(view.distance_to(cell) >= 0);
    }
}

TEST_CASE("at distance 0 a length takes infinitely many pixels in perspective, as many as ever in parallel") {
    const LocalView view(looking({0, 0, 1}), {}, 4), parallel(looking_orthographic({0, 0, 1}, {}, 4, 100), {}, 4);
    CHECK(std::isinf(view.pixels(1, 0)));
    CHECK(view.pixels(1, 2) == Approx(view.focal_px / 2));
    CHECK(parallel.pixels(1, 0) == Approx(25));
    CHECK(parallel.pixels(2, 1e9f) == Approx(50));
}

TEST_CASE("directions towards the viewer have length 1, at the eye itself too") {
    Random random(153);
    for (int i = 0; i < 200; ++i) {
        const View v = i % 2 ? looking(random.in_cube(2), random.in_cube(1))
                             : looking_orthographic(random.in_cube(2), random.in_cube(1), 2);
        const LocalView view(v, {}, 4);
        const glm::vec3 p = i % 10 < 2 ? view.eye : glm::vec3(random.in_cube(3)), d = view.direction_towards_viewer(p);
        CHECK(glm::length(d) == Approx(1));
        if (p == view.eye || !view.is_perspective) CHECK(glm::dot(d, -view.forward) == Approx(1));
        if (p != view.eye) CHECK(glm::dot(d, view.towards_viewer(p)) == Approx(glm::length(view.towards_viewer(p))));
    }
}
