// On which side of a plane is the center of a voxel? Exact, in integers: convex polyhedra that share a face take each
// voxel once.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace farfield {

/// E(i, j, k) = e + a i + b j + c k is 0 or more if the center of voxel (i, j, k), which lies at
/// (i + 1/2, j + 1/2, k + 1/2), is inside. |a|, |b|, |c| at most 2^44, |e| at most 2^61; voxels from 0 to 2^14 - 1.
///
/// A center on the plane is inside if the normal's first component that is not 0 is positive, as if the center lay a
/// little towards +x, and less towards +y, and still less towards +z. So a plane and its reverse part the voxels
/// between them, and of polyhedra that fill space without overlapping each center belongs to one, also at their edges
/// and corners.
struct VoxelPlane {
    std::int64_t e = 0, a = 0, b = 0, c = 0;

    /// Inside is where dot(n, p) + w > 0, n = plane.xyz; p in voxels. This is exact if components of n are 0 or at
    /// least 2^-20 of the largest and have no more digits than a float; others are rounded to 2^-44 of the largest,
    /// which at 16384 voxels is 2^-30 voxel. snapped(-plane) is snapped(plane).reversed(). With n = 0 everything is
    /// inside if w >= 0; a plane that is not finite has nothing inside.
    static VoxelPlane snapped(const glm::dvec4& plane) {
        for (int i = 0; i < 4; ++i) {
            if (!std::isfinite(plane[i])) return {-1, 0, 0, 0};
        }
        const double largest = std::max({std::abs(plane.x), std::abs(plane.y), std::abs(plane.z)});
        if (largest == 0) return {plane.w >= 0 ? 0 : -1, 0, 0, 0};
        int exponent = 0;
        std::frexp(largest, &exponent);
        VoxelPlane p;
        p.a = std::llround(std::ldexp(plane.x, 44 - exponent));
        p.b = std::llround(std::ldexp(plane.y, 44 - exponent));
        p.c = std::llround(std::ldexp(plane.z, 44 - exponent));
        // Twice E at (0, 0, 0), because centers are at halves. A fraction only says that no center is on the plane.
        const double doubled_w = std::ldexp(plane.w, 45 - exponent), floor = std::floor(doubled_w);
        const auto doubled = std::int64_t(std::clamp(floor, -0x1p61, 0x1p61)) + p.a + p.b + p.c;
        p.e = (doubled - (floor == doubled_w && !p.owns_its_points())) >> 1;
        return p;
    }

    /// The plane of a polyhedron's face with corners p, q and r, snapped to 1/256 voxel, counter-clockwise seen from
    /// outside in right-handed axes; exact for |coordinates| of at most 2^20. Corners in one line give a plane that has
    /// everything inside: a polyhedron needs other faces too.
    static VoxelPlane through(glm::ivec3 p, glm::ivec3 q, glm::ivec3 r) {
        const std::int64_t ux = r.x - p.x, uy = r.y - p.y, uz = r.z - p.z;
        const std::int64_t vx = q.x - p.x, vy = q.y - p.y, vz = q.z - p.z;
        VoxelPlane plane;
        plane.a = uy * vz - uz * vy;
        plane.b = uz * vx - ux * vz;
        plane.c = ux * vy - uy * vx;
        // Whole voxels and the rest are kept apart, or products would not fit.
        const std::int64_t rest = plane.a * (128 - (p.x & 255)) + plane.b * (128 - (p.y & 255)) +
                                  plane.c * (128 - (p.z & 255)) - !plane.owns_its_points();
        plane.e = (rest >> 8) - plane.a * (p.x >> 8) - plane.b * (p.y >> 8) - plane.c * (p.z >> 8);
        return plane;
    }

    /// Exchanges inside and outside.
    VoxelPlane reversed() const { return {-e - 1, -a, -b, -c}; }

    std::int64_t at(glm::ivec3 voxel) const { return e + a * voxel.x + b * voxel.y + c * voxel.z; }
    bool contains(glm::ivec3 voxel) const { return at(voxel) >= 0; }

    friend bool operator==(const VoxelPlane&, const VoxelPlane&) = default;

  private:
    bool owns_its_points() const { return a != 0 ? a > 0 : b != 0 ? b > 0 : c >= 0; }
};

}  // namespace farfield
