// A mesh as its file has it, in double precision, and the same in single precision around an origin of its own. Files
// far from zero (terrain in UTM coordinates, a part of a city) keep their details, if nothing is rounded before the
// origin is subtracted.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "farfield/geometry/box.hpp"
#include "farfield/geometry/rgba8.hpp"
#include "farfield/primitive/triangle.hpp"

namespace farfield::scenes::detail {

using Triangles = std::vector<VertexColoredTriangle>;

/// What a reader gives: a point of the file is `origin` plus a point of the triangles.
struct Loaded {
    Triangles triangles{};
    glm::dvec3 origin{0.0};
    /// What the file has and the triangles have not, one line each.
    std::vector<std::string> notes{};
    /// The light, if it was asked for, is in the colors already.
    bool lit = false;
    /// See Scene::is_closed.
    bool is_closed = false;
};

/// The point to subtract, in double precision, from all that lies in `box` before it is rounded to single precision.
/// On an axis where no coordinate is farther from zero than 16 times the longest side it is 0: floats keep 20 of their
/// 24 bits there, and the file's own coordinates are worth more than the rest. On any other axis it is the multiple
/// next to the middle of the power of ten next above the longest side; the same scene given once around zero and once
/// a round number away comes out with the same floats. What is left is at most 5.5 sides from zero.
glm::dvec3 origin_of(const BoxD& box);

/// The same for centers of atoms or of points. Where all are at one place, what is drawn there reaches about 1 around
/// it.
glm::dvec3 origin_of_centers(BoxD centers);

/// `point` relative to `origin`. Throws std::runtime_error, "vertex 7 is ...", if it is not finite or farther than
/// 2^100 from the origin on any axis, the range in which the library draws the same whatever the unit.
glm::vec3 in_single_precision(const glm::dvec3& point, const glm::dvec3& origin, std::string_view kind,
                              std::size_t index);

/// Throws std::runtime_error if nothing in `box` could be drawn: its longest side is less than 2^-100 and not 0.
void check_size(const BoxD& box);

struct MeshTriangle {
    std::array<std::uint32_t, 3> corners;  ///< into the positions
    std::array<Rgba8, 3> colors;
};

struct Mesh {
    std::vector<glm::dvec3> positions{};
    std::vector<MeshTriangle> triangles{};
};

/// The mesh's triangles in their order. Positions that no triangle names have no say in where the origin is. Throws
/// std::runtime_error as the functions above do.
Loaded in_single_precision(const Mesh& mesh);

}  // namespace farfield::scenes::detail
