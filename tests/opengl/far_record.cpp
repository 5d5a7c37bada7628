#include "opengl/far_record.hpp"

#include <bit>
#include <glm/vec3.hpp>

#include "catch.hpp"

using namespace farfield;
using opengl::FarRecord;

TEST_CASE("a record holds a face", "[opengl]") {
    for (std::uint8_t side = 0; side < 6; ++side) {
        Face face{{1, 2, 3}, {1.5f, 2.25f, 3.125f}, {10, 20, 30, 200}, side};
        face.upper[side / 2] = face.lower[side / 2];
        const FarRecord r = opengl::record_of(face);
        CHECK(opengl::is_face(r));
        CHECK((r.u >> 31 | r.v >> 31 << 1) == side / 2u);
        CHECK(opengl::law_of(r) == law_of_opacity(200 / 255.0f));
        const Box box = opengl::box_of(r);
        for (int axis = 0; axis < 3; ++axis) {
            CHECK(box.lower[axis] == face.lower[axis]);
            CHECK(box.upper[axis] == Approx(face.upper[axis]).epsilon(1e-6));
        }
    }
}

TEST_CASE("a record holds a splat", "[opengl]") {
    for (const AreaLaw law : {AreaLaw::independent, AreaLaw::mixed, AreaLaw::coherent}) {
        for (const float opacity : {0.0f, 1e-5f, 0.3f, 1.0f}) {
            const Splat splat{{1, 2, 3}, {0.1f, 1e-7f}, opacity, {10, 20, 30, std::uint8_t(law)}};
            const FarRecord r = opengl::record_of(splat);
            CHECK(!opengl::is_face(r));
            CHECK(opengl::law_of(r) == law);
            CHECK(std::bit_cast<float>(r.u & 0x7ffffe00u) == Approx(0.1f).epsilon(1e-4));
            CHECK(std::bit_cast<float>(r.v & 0x7fffff00u) == Approx(1e-7f).epsilon(1e-4));
            const std::uint32_t bits = r.color >> 24 << 16 | (r.v & 255u) << 8 | (r.u >> 1 & 255u);
            CHECK(float(bits) / float(0xffffff) == Approx(opacity).margin(1e-7));
            CHECK((r.color & 0xffffff) == (10u | 20u << 8 | 30u << 16));
        }
    }
}
