// What the generators and loaders give: triangles in groups, and groups placed in groups.
#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "farfield/geometry/box.hpp"
#include "farfield/primitive/triangle.hpp"

namespace farfield::scenes {

/// One instance of an earlier group. `to_parent` is a similarity: rotation, uniform scale, translation.
struct Placement {
    std::size_t group;
    glm::mat4 to_parent;
};

/// Own triangles, and instances of groups with a smaller index.
struct Group {
    std::vector<VertexColoredTriangle> triangles{};
    std::vector<Placement> placements{};
};

/// Right-handed. The last group is the root; a scene has at least one. Lighting, where there is any, is baked
/// into the colors, as Chamberlain's color cubes assume.
struct Scene {
    std::string name{};
    std::vector<Group> groups{};
    glm::vec3 up{0.0f, 1.0f, 0.0f};
    /// Where the root's zero lies in the coordinates of the file that the scene is from: not 0 only if single precision
    /// would be too coarse there.
    glm::dvec3 origin{0.0, 0.0, 0.0};
    /// What the file has and the scene has not (further models, textures that are missing), one line each.
    std::vector<std::string> notes{};
    /// All surfaces are known to be closed and counter-clockwise from outside, so that no back face is ever seen.
    bool is_closed = false;
};

// All below throw std::invalid_argument if there is no group, or if a placement names a group that is not
// earlier than its own.

/// Triangles of the root with every instance counted; saturates at 2^64 - 1.
std::uint64_t triangle_count(const Scene& scene);

/// Encloses the root in world space. Exact for own triangles; an instance adds the box of its group's
/// transformed box, which is larger than it need be unless rotated by a multiple of 90 degrees.
Box bounds(const Scene& scene);

/// Memory of the triangles and placements as stored: a group counts once however often it is placed.
std::uint64_t bytes(const Scene& scene);

/// The same picture as one group without placements: own triangles first, then placements in their order,
/// depth first. Throws std::length_error, before allocating, if that is more than `triangle_limit`.
Scene expanded(const Scene& scene, std::uint64_t triangle_limit = std::uint64_t{32} << 20);

}  // namespace farfield::scenes
