#include "farfield/raster/far_field/face_triangles.hpp"

#include <cmath>
#include <cstdint>

#include "catch.hpp"
#include "support/random.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

TEST_CASE("a face's triangles are clockwise and cover what the face covers, from either side", "[raster]") {
    Random random(731);
    for (int i = 0; i < 600; ++i) {
        const int side = i % 6, axis = side / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
        const float size = 0.25f * float(1 + random.below(4));
        Face face{glm::vec3(0), glm::vec3(0), {0, 0, 0, 255}, std::uint8_t(side)};
        face.upper[u] = face.upper[v] = size;
        // Squarely seen from 4 units away, on either side.
        glm::dvec3 eye(size / 2);
        eye[axis] = i % 12 < 6 ? 4 : -4;
        glm::dvec3 target(size / 2);
        target[axis] = 0;
        View view;
        glm::vec3 up(0);
        up[u] = 1;
        view.camera = Camera::orthographic(eye, target, up, 2);
        view.width = view.height = 64;
        const SampleProjection projection(LocalView(view, {}, 4), 1);
        std::int64_t doubled_area = 0;
        for_triangles_of(face, projection, [&](const SnappedTriangle& t, const DepthPlane& plane) {
            CHECK(t.doubled_area() > 0);
            CHECK(plane.lowest == plane.highest);
            doubled_area += t.doubled_area();
        });
        // 32 samples a unit, 256 steps a sample.
        const double expected = 2 * std::pow(double(size) * 32 * 256, 2);
        CHECK(double(doubled_area) == Approx(expected).epsilon(1e-3));
    }
}

TEST_CASE("a face behind the eye, or seen on edge, has no triangles", "[raster]") {
    const Face face{{-1, -1, 0}, {1, 1, 0}, {0, 0, 0, 255}, 5};
    const auto triangles_from = [&](glm::dvec3 eye, glm::dvec3 target) {
        View view;
        view.camera = Camera::perspective(eye, target, {0, 1, 0}, 0.8f);
        view.width = view.height = 64;
        int count = 0;
        for_triangles_of(face, SampleProjection(LocalView(view, {}, 4), 1),
                         [&](const SnappedTriangle&, const DepthPlane&) { ++count; });
        return count;
    };
    CHECK(triangles_from({0, 0, 4}, {0, 0, 0}) == 2);
    CHECK(triangles_from({0, 0, 4}, {0, 0, 8}) == 0);
    CHECK(triangles_from({4, 0, 0}, {0, 0, 0}) == 0);
    // Around the eye: what lies before the near plane is cut off.
    CHECK(triangles_from({0, 0.5, 0.001}, {0, -1, 0}) > 0);
}
