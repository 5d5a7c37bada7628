#include "farfield/voxel/voxel_plane.hpp"

#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/gtc/type_precision.hpp>
#include <limits>

#include "catch.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

glm::ivec3 random_voxel(Random& random, std::uint32_t side) {
    const auto x = random.below(side), y = random.below(side), z = random.below(side);
    return {int(x), int(y), int(z)};
}

/// The side of a plane of integers, in halves of voxels: dot(n, voxel + 1/2) + w, and its first component for ties.
bool is_inside(glm::ivec3 n, int w, glm::ivec3 voxel) {
    const glm::ivec3 doubled = 2 * voxel + 1;
    const std::int64_t e = std::int64_t(n.x) * doubled.x + std::int64_t(n.y) * doubled.y +
                           std::int64_t(n.z) * doubled.z + 2 * std::int64_t(w);
    const std::int64_t first = e != 0 ? e : n.x != 0 ? n.x : n.y != 0 ? n.y : n.z;
    return first > 0 || (first == 0 && e == 0);
}

}  // namespace

TEST_CASE("Voxel plane: small integers, with many centers on the planes") {
    Random random(1);
    int wrong = 0, on_plane = 0;
    for (int i = 0; i < 2000; ++i) {
        const glm::ivec3 n = random_voxel(random, 9) - 4;
        const int w = int(random.below(101)) - 50;
        const VoxelPlane plane = VoxelPlane::snapped(glm::dvec4(n, w));
        for (int k = 0; k < 200; ++k) {
            const glm::ivec3 voxel = random_voxel(random, 16);
            const glm::ivec3 doubled = 2 * voxel + 1;
            on_plane += n.x * doubled.x + n.y * doubled.y + n.z * doubled.z + 2 * w == 0;
            wrong += plane.contains(voxel) != is_inside(n, w, voxel);
        }
    }
    CHECK(on_plane > 1000);
    CHECK(wrong == 0);
}

TEST_CASE("Voxel plane: single precision is exact") {
    // Components are multiples of 2^-43 below 1 and w of 2^-43 below 2^6: in units of 2^-44 all is an integer.
    Random random(2);
    int wrong = 0;
    for (int i = 0; i < 20000; ++i) {
        glm::vec4 plane;
        for (int c = 0; c < 3; ++c) {
            const int shift = -int(random.below(20));
            const float unit = random.between(0.5f, 1), sign = random.below(2) == 0 ? 1.0f : -1.0f;
            plane[c] = random.below(8) == 0 ? 0.0f : std::ldexp(sign * unit, shift);
        }
        const glm::ivec3 near = random_voxel(random, 64);
        plane.w = -glm::dot(glm::vec3(plane), glm::vec3(near) + 0.5f);
        if (std::abs(plane.w) < 0x1p-19f) plane.w = 0;  // more digits than the comparison has
        const VoxelPlane snapped = VoxelPlane::snapped(glm::dvec4(plane));
        const auto integer = [](float v, int shift) { return std::int64_t(std::ldexp(double(v), shift)); };
        for (int k = 0; k < 30; ++k) {
            const glm::ivec3 v = k < 15 ? near + random_voxel(random, 3) - 1 : random_voxel(random, 64);
            const std::int64_t e = integer(plane.x, 44) * (2 * v.x + 1) + integer(plane.y, 44) * (2 * v.y + 1) +
                                   integer(plane.z, 44) * (2 * v.z + 1) + integer(plane.w, 45);
            const float first = plane.x != 0 ? plane.x : plane.y != 0 ? plane.y : plane.z;
            wrong += snapped.contains(v) != (e != 0 ? e > 0 : first >= 0);
        }
    }
    CHECK(wrong == 0);
}

TEST_CASE("Voxel plane: the reverse has what the plane has not, at any scale") {
    Random random(3);
    int wrong = 0, not_reversed = 0;
    for (int i = 0; i < 5000; ++i) {
        glm::dvec4 plane;
        const double scale = std::ldexp(1.0, int(random.below(1800)) - 900);
        for (int c = 0; c < 4; ++c) {
            const int shift = -int(random.below(60));
            plane[c] = random.below(6) == 0 ? 0 : scale * std::ldexp(double(random.between(-1, 1)), shift);
        }
        plane.w *= random.below(2) == 0 ? 1 : 1000;
        const VoxelPlane there = VoxelPlane::snapped(plane), back = VoxelPlane::snapped(-plane);
        const bool has_direction = plane.x != 0 || plane.y != 0 || plane.z != 0;
        not_reversed += has_direction && !(back == there.reversed());
        for (int k = 0; k < 10 && has_direction; ++k) {
            const glm::ivec3 voxel = random_voxel(random, 16384);
            wrong += there.contains(voxel) == back.contains(voxel);
        }
    }
    CHECK(not_reversed == 0);
    CHECK(wrong == 0);
}

TEST_CASE("Voxel plane: what is hardly off a center decides") {
    const glm::ivec3 voxel{3, 4, 5};
    CHECK(VoxelPlane::snapped({-1, 0, 0, 3.5 + 0x1p-40}).contains(voxel));
    CHECK_FALSE(VoxelPlane::snapped({-1, 0, 0, 3.5}).contains(voxel));
    CHECK_FALSE(VoxelPlane::snapped({1, 0, 0, -3.5 - 0x1p-40}).contains(voxel));
    CHECK(VoxelPlane::snapped({1, 0, 0, -3.5}).contains(voxel));
    for (const double hair : {0x1p-40, 0x1p-300, 5e-324}) {
        // Normals whose components cancel at the center leave w alone.
        CHECK(VoxelPlane::snapped({-1, 1, 0, hair}).contains({6, 6, 0}));
        CHECK_FALSE(VoxelPlane::snapped({-1, 1, 0, 0}).contains({6, 6, 0}));
        CHECK_FALSE(VoxelPlane::snapped({1, -1, 0, -hair}).contains({6, 6, 0}));
        CHECK(VoxelPlane::snapped({1, -1, 0, 0}).contains({6, 6, 0}));
    }
}

TEST_CASE("Voxel plane: no direction, not finite, far away") {
    const double infinity = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
    const glm::ivec3 voxel{16383, 0, 16383};
    CHECK(VoxelPlane::snapped({0, 0, 0, 0}).contains(voxel));
    CHECK(VoxelPlane::snapped({0, -0.0, 0, 1e300}).contains(voxel));
    CHECK_FALSE(VoxelPlane::snapped({0, 0, 0, -5e-324}).contains(voxel));
    for (const double bad : {infinity, -infinity, nan}) {
        for (int c = 0; c < 4; ++c) {
            glm::dvec4 plane(1, 2, 3, 4);
            plane[c] = bad;
            CHECK_FALSE(VoxelPlane::snapped(plane).contains(voxel));
        }
    }
    CHECK(VoxelPlane::snapped({1e-320, 0, 0, 1e300}).contains(voxel));
    CHECK_FALSE(VoxelPlane::snapped({1, 0, 0, -1e300}).contains(voxel));
    CHECK(VoxelPlane::snapped({-1e308, 1e308, -1e308, 1.7e308}).contains({0, 0, 0}));
    CHECK_FALSE(VoxelPlane::snapped({-1e308, 1e308, -1e308, 1.7e308}).contains(voxel));
}

TEST_CASE("Voxel plane: through corners of a face") {
    // By the definition, in units of 1/256 voxel, where products are small enough for it.
    Random random(4);
    int wrong = 0, on_plane = 0;
    for (int i = 0; i < 5000; ++i) {
        // Few halves of voxels, so that centers lie on faces; or anything.
        const int step = i % 2 == 0 ? 128 : 1;
        const std::uint32_t range = i % 2 == 0 ? 10 : 8192;
        const int offset = i % 2 == 0 ? 128 : 1024;
        glm::ivec3 corner[3];
        for (glm::ivec3& c : corner) c = random_voxel(random, range) * step - offset;
        const VoxelPlane plane = VoxelPlane::through(corner[0], corner[1], corner[2]);
        const glm::i64vec3 p(corner[0]), u = glm::i64vec3(corner[1]) - p, v = glm::i64vec3(corner[2]) - p;
        // Inside is where the faces' outward normals do not point.
        const glm::i64vec3 n(u.z * v.y - u.y * v.z, u.x * v.z - u.z * v.x, u.y * v.x - u.x * v.y);
        for (int k = 0; k < 50; ++k) {
            const glm::ivec3 voxel = random_voxel(random, i % 2 == 0 ? 4 : 16);
            const glm::i64vec3 d = glm::i64vec3(voxel * 256 + 128) - p;
            const std::int64_t e = n.x * d.x + n.y * d.y + n.z * d.z;
            const std::int64_t first = e != 0 ? e : n.x != 0 ? n.x : n.y != 0 ? n.y : n.z;
            on_plane += e == 0;
            wrong += plane.contains(voxel) != (first >= 0);
        }
        // From whichever corner, and by whichever polyhedron.
        wrong += !(VoxelPlane::through(corner[1], corner[2], corner[0]) == plane);
        const VoxelPlane back = VoxelPlane::through(corner[0], corner[2], corner[1]);
        wrong += n != glm::i64vec3(0) && !(back == plane.reversed());
    }
    CHECK(on_plane > 1000);
    CHECK(wrong == 0);
    CHECK(VoxelPlane::through({0, 0, 0}, {256, 256, 256}, {512, 512, 512}) == VoxelPlane{});
    // The largest: a face across the range, and corners beyond the grid.
    const int far = 1 << 20;
    const VoxelPlane plane = VoxelPlane::through({-far, -far, -far}, {far, -far, far}, {-far, far, far});
    const VoxelPlane expected = VoxelPlane::snapped(glm::dvec4(1, 1, -1, double(far) / 256));
    for (const glm::ivec3 voxel :
         {glm::ivec3(0), glm::ivec3(0, 0, 4095), glm::ivec3(0, 0, 4096), glm::ivec3(0, 0, 4097), glm::ivec3(4095)}) {
        CHECK(plane.contains(voxel) == expected.contains(voxel));
    }
}
