#include "farfield/approximation/cell_faces.hpp"

#include <bit>
#include <cmath>
#include <cstdint>

#include "catch.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::test;

TEST_CASE("faces as polygons look outwards and give back the color", "[approximation]") {
    Random random(40);
    for (unsigned side = 0; side < 6; ++side) {
        Cell cell;
        cell.center = random.in_cube(3);
        cell.half = {0.5f, 0.25f, 1};
        const Rgba8 color{100, 50, 0, 200};
        int polygons = 0;
        emit_polygon(face_of(cell, side, color), [&](const Polygon& p) {
            ++polygons;
            REQUIRE(p.vertices.size() == 4);
            const glm::vec3 n = glm::cross(p.vertices[1] - p.vertices[0], p.vertices[2] - p.vertices[0]);
            const int axis = int(side / 2);
            CHECK((side & 1 ? n[axis] > 0 : n[axis] < 0));
            CHECK(std::abs(n[(axis + 1) % 3]) < 1e-6f);
            CHECK(glm::length(n) == Approx(4 * cell.half[(axis + 1) % 3] * cell.half[(axis + 2) % 3]));
            REQUIRE(p.colors.size() == 1);
            CHECK(p.colors[0].a == 200);
            CHECK(std::abs(p.colors[0].r - 127.5) <= 1);
            CHECK(std::abs(p.colors[0].g - 63.75) <= 1);
            for (const glm::vec3& v : p.vertices)
                CHECK(v[axis] == cell.center[axis] + (side & 1 ? cell.half[axis] : -cell.half[axis]));
        });
        CHECK(polygons == 1);
        emit_polygon(face_of(cell, side, {0, 0, 0, 0}), [&](const Polygon&) { ++polygons; });
        CHECK(polygons == 1);
    }
}

TEST_CASE("small is what takes no more than the limit where it is", "[approximation]") {
    View v;
    v.camera = Camera::perspective({0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 1);
    const LocalView view(v, {}, 10);
    const float side = 2.0f * 5 / view.focal_px;
    CHECK(is_small({0, 0, -5}, side * 0.999f, view, 2));
    CHECK_FALSE(is_small({0, 0, -5}, side * 1.001f, view, 2));
    CHECK_FALSE(is_small({0, 0, -5}, side * 0.5f, view, 0));
    CHECK_FALSE(is_small({0, 0, 0}, side * 1e-6f, view, 2));
    CHECK_FALSE(is_small({0, 0, 5}, side * 1e-6f, view, 2));
}

TEST_CASE("a splat whose area all but vanishes keeps its color", "[approximation]") {
    View v;
    v.camera = Camera::perspective({0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 1);
    const LocalView view(v, {}, 10);
    for (const float footprint : {1.0f, 0x1p-100f, 0x1p-126f, 0x1p-130f, 0x1p-140f}) {
        const Splat splat = splat_of({0, 0, -5}, footprint, 0.5f, glm::vec4(0, 100, 255, 255) * footprint, view);
        CHECK(splat.rgb.r == 0);
        CHECK(splat.rgb.b <= 255);
        if (footprint > 0x1p-118f) CHECK(splat.rgb.b == 255);
        CHECK(splat.opacity > 0);
        CHECK(splat.opacity <= 1);
    }
}

TEST_CASE("a splat of opaque faces is opaque, and no more than that", "[approximation]") {
    View v;
    v.camera = Camera::perspective({0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 1);
    const LocalView view(v, {}, 10);
    Random random(41);
    for (int i = 0; i < 2000; ++i) {
        float footprint = 0;
        glm::vec4 sum(0);
        for (int face = 0; face < 3; ++face) {
            const float area = random.between(0, 1);
            footprint += area;
            sum += glm::vec4(255) * area;
        }
        const float opacity = splat_of({0, 0, -5}, footprint, 0.5f, sum, view).opacity;
        CHECK(opacity <= 1);
        CHECK(opacity > 1 - 1e-6f);
    }
}

TEST_CASE("the unit of a cell's length is the power of two above its side, for every side", "[approximation]") {
    int wrong = 0;
    for (std::uint32_t bits = 0; bits < 0x7f800000u; bits += 0x3ff7) {
        Cell cell;
        cell.half = glm::vec3(std::bit_cast<float>(bits));
        const float side = cell.largest_side();
        if (std::isfinite(side) && side > 0) {
            const float unit = length_unit(cell);
            const bool is_within = side < 0x1p126f && side >= 0x1p-127f;
            wrong += is_within && !(unit > side && 0.5f * unit <= side);
            wrong += !is_within && unit != (side >= 1 ? 0x1p126f : 0x1p-126f);
        }
    }
    CHECK(wrong == 0);
    CHECK(length_unit(Cell{}) == 1);
}
