#include "farfield/measure/projected_rect.hpp"

#include <limits>

#include "catch.hpp"
#include "farfield/view/local_view.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

/// Looks down the z axis from 10 units: a unit at z = 0 is 10 pixels.
View down_z(Projection projection = Projection::perspective) {
    View view;
    view.camera.eye = {0, 0, 10};
    view.camera.projection = projection;
    view.camera.half_height = projection == Projection::perspective ? 1 : 10;
    view.width = 300;
    view.height = 200;
    return view;
}

}  // namespace

TEST_CASE("corners are projected and rounded outwards") {
    const Box flat{{-1, -2, 0}, {3, 4, 0}};
    CHECK(projected_rect(flat, down_z()) == PixelRect{140, 60, 180, 120});
    CHECK(projected_rect(flat, down_z(Projection::orthographic)) == PixelRect{140, 60, 180, 120});
    CHECK(projected_rect(Box{{-1.01f, -2.01f, 0}, {3.01f, 4.01f, 0}}, down_z()) == PixelRect{139, 59, 181, 121});
    // Twice as near is twice as large, but not in parallel.
    const Box deep{{-1, -2, 0}, {3, 4, 5}};
    CHECK(projected_rect(deep, down_z()) == PixelRect{130, 20, 210, 140});
    CHECK(projected_rect(deep, down_z(Projection::orthographic)) == PixelRect{140, 60, 180, 120});
}

TEST_CASE("a rectangle is clipped to the picture and never empty") {
    CHECK(projected_rect(Box{{-100, -100, 0}, {100, 100, 0}}, down_z()) == PixelRect{0, 0, 300, 200});
    CHECK(projected_rect(Box{{14, -1, 0}, {20, 1, 0}}, down_z()) == PixelRect{290, 90, 300, 110});
    const auto point = projected_rect(Box{{1, 1, 0}, {1, 1, 0}}, down_z());
    REQUIRE(point);
    CHECK(point->width() == 1);
    CHECK(point->height() == 1);
    CHECK(projected_rect(Box{{-15, 0, 0}, {-15, 0, 0}}, down_z()) == PixelRect{0, 100, 1, 101});
}

TEST_CASE("where there is nothing to say there is no rectangle") {
    const float infinity = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
    CHECK_FALSE(projected_rect(Box::empty(), down_z()));
    CHECK_FALSE(projected_rect(BoxD::empty(), down_z()));
    CHECK_FALSE(projected_rect(Box{{-infinity, 0, 0}, {0, 1, 1}}, down_z()));
    CHECK_FALSE(projected_rect(Box{{nan, 0, 0}, {0, 1, 1}}, down_z()));
    CHECK_FALSE(projected_rect(Box{{-1, -1, 11}, {1, 1, 12}}, down_z()));   // behind
    CHECK_FALSE(projected_rect(Box{{-1, -1, 0}, {1, 1, 12}}, down_z()));    // around the eye
    CHECK_FALSE(projected_rect(Box{{-1, -1, 10}, {1, 1, 10}}, down_z()));   // at the eye's depth
    CHECK_FALSE(projected_rect(Box{{15, -1, 0}, {16, 1, 0}}, down_z()));    // beside the picture
    CHECK_FALSE(projected_rect(Box{{-1, -16, 0}, {1, -15, 0}}, down_z()));  // below it
    CHECK(projected_rect(Box{{-1, -1, 0}, {1, 1, 12}}, down_z(Projection::orthographic)));
}

TEST_CASE("every point of the box falls into the rectangle, as renderers project it") {
    Random random(5);
    for (int i = 0; i < 2000; ++i) {
        View view;
        view.camera = i % 2 ? Camera::perspective(random.in_cube(9), random.in_cube(1), {0, 1, 0}, 1)
                            : Camera::orthographic(random.in_cube(9), random.in_cube(1), {0, 1, 0}, 4);
        view.width = 1 + int(random.below(300));
        Box box = Box::empty();
        box.add(random.in_cube(2));
        box.add(random.in_cube(2));
        const auto rect = projected_rect(box, view);
        CHECK(rect == projected_rect(BoxD{glm::dvec3(box.lower), glm::dvec3(box.upper)}, view));
        const LocalView local(view, {}, 4);
        for (int k = 0; k < 20; ++k) {
            const glm::vec3 t(random.between(0, 1), random.between(0, 1), random.between(0, 1));
            const glm::vec3 d = box.lower + t * box.size() - glm::vec3(view.camera.eye);
            const float depth = i % 2 ? glm::dot(d, local.forward) : 1;
            if (!(depth > 0)) {
                CHECK_FALSE(rect);
                continue;
            }
            const float x = 0.5f * float(view.width) + local.focal_px * glm::dot(d, local.right) / depth;
            const float y = 0.5f * float(view.height) - local.focal_px * glm::dot(d, local.up) / depth;
            const bool in_picture = x >= 0 && x < float(view.width) && y >= 0 && y < float(view.height);
            if (!rect || !in_picture) continue;
            // Rounding of single precision is all there is beside.
            CHECK(x >= float(rect->x0) - 1e-2f);
            CHECK(x <= float(rect->x1) + 1e-2f);
            CHECK(y >= float(rect->y0) - 1e-2f);
            CHECK(y <= float(rect->y1) + 1e-2f);
        }
    }
}
