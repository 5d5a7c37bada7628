// Scenes that break far fields: each shows one known failure and has a parameter for how bad it is.
//
// All are centered at the origin, y up, and fit the ball of radius 1.75 around it, save for what a scene says of
// itself. Their light is baked. Same options, same bytes. Each throws std::invalid_argument, one line that names the
// option, for a number that makes no scene (no triangles, a length that is not positive and finite).
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "farfield/primitive/triangle.hpp"

namespace farfield::scenes {

/// A venetian blind: slats along x, one above the other, in the square |x|, |y| <= 1. It shows a face of a cell as a
/// mixture of what it is from in front and from above, and darkens or thickens with the angle.
struct SlatsOptions {
    std::uint32_t slats = 32;
    /// 0: lying, seen edge-on from z; 90: upright, a wall seen from z.
    float angle_degrees = 45;
    /// Depth of a slat in distances between slats: 1 just closes the blind when upright.
    float breadth = 1;
    /// Quads along a slat; each is two triangles, 2 * slats * segments in all.
    std::uint32_t segments = 64;
};
std::vector<Triangle> slats(const SlatsOptions& options = {});

/// A square of side 2, tessellated finely: 2 * side_quads^2 triangles, checkered 8 x 8. Its cells' faces cover, seen
/// along the normal, more or less than all of it: it tears or thickens.
struct WallOptions {
    glm::vec3 normal{1, 1, 1};  ///< any length but 0
    std::uint32_t side_quads = 64;
};
std::vector<Triangle> wall(const WallOptions& options = {});

/// Head, neck and shoulders on a flat base: closed, outward and star-shaped about the origin, so that whatever is seen
/// of the background inside its silhouette is an error. 12 * side_quads^2 triangles; every edge lies in two of them, on
/// the same bits. Lit before it is turned, so that it looks the same from wherever it looks to.
struct BustOptions {
    glm::vec3 looks_to{0, 0, 1};  ///< any length but 0
    std::uint32_t side_quads = 42;
};
std::vector<Triangle> bust(const BustOptions& options = {});

/// Thin straight twigs, turned every way, in the unit ball: three-sided prisms without ends, 6 * segments triangles
/// each. From afar they cover less than a sample: a far field that rounds up thickens, one that thresholds loses them.
struct TwigsOptions {
    std::uint64_t seed = 1;
    std::uint32_t twigs = 400;
    float length = 0.6f;
    float thickness = 0.005f;    ///< side of the prism
    std::uint32_t segments = 8;  ///< along the twig
};
std::vector<Triangle> twigs(const TwigsOptions& options = {});

/// Leaves turned every way in the unit ball, one triangle each, lit by a sun at +x: those turned towards it and those
/// with few leaves before them are bright. Cells that mix front and back lose the difference between the sides.
struct LeavesOptions {
    std::uint64_t seed = 1;
    std::uint32_t leaves = 20'000;
    /// Area of all leaves, one side each, in areas of the ball's disk: leaves are the smaller the more there are.
    float cover = 4;
    /// 0: one tone everywhere; 1: no light but the sun's.
    float contrast = 1;
};
std::vector<Triangle> lit_leaves(const LeavesOptions& options = {});

/// Parallel squares of side 2, alternately dark and bright: 2 * sheets * side_quads^2 triangles. What is in front is
/// decided by depths that hardly differ (Klein et al. 2002, figure 5).
struct SheetsOptions {
    std::uint32_t sheets = 6;
    float spacing = 0.01f;
    glm::vec3 normal{0.3f, 0.2f, 1};  ///< the nearest sheet to a viewer from there is dark; any length but 0
    std::uint32_t side_quads = 40;
};
std::vector<Triangle> sheets(const SheetsOptions& options = {});

/// One ground plane of two triangles at y = -1 under the leaves of `lit_leaves`. The plane reaches beyond the ball: it
/// stretches the root cell, and belongs to every cell or to none.
struct GroundOptions {
    LeavesOptions leaves{.leaves = 1'000'000};
    float half_side = 100;
};
std::vector<Triangle> ground_and_leaves(const GroundOptions& options = {});

/// Blades of grass on the square |x|, |z| <= 1 at y = 0, upright but for a third of their height, one triangle each:
/// cells are far wider than the layer is thick, and most of what they hold is seen edge-on from above.
struct MeadowOptions {
    std::uint64_t seed = 1;
    std::uint32_t blades = 90'000;
    float height = 0.04f;
    /// Area of all blades, one side each, in areas of the square: blades are the narrower the more there are.
    float cover = 0.9f;
};
std::vector<Triangle> meadow(const MeadowOptions& options = {});

/// Balls of leaves in a row along z, from -1 to 1. Seen along the row each covers a part of what those before it leave
/// open: where each covers a fifth, 16 leave 3 %.
struct CloudsOptions {
    std::uint64_t seed = 1;
    std::uint32_t clouds = 16;
    std::uint32_t leaves = 1'500;  ///< of each
    /// Area of a cloud's leaves, one side each, in areas of its disk, of which half is seen.
    float cover = 0.6f;
    float radius = 0.04f;  ///< of a cloud
};
std::vector<Triangle> clouds(const CloudsOptions& options = {});

/// A scene of the gallery with what an experiment needs to know of it.
struct GalleryScene {
    std::string name;
    std::vector<Triangle> triangles;
    glm::vec3 towards_viewer{0, 0, 1};  ///< unit vector: where the failure shows most plainly
    bool is_closed = false;             ///< no background may be seen inside the silhouette at any sampling rate
    bool is_opaque = false;             ///< nor, seen from towards_viewer, here: a closed surface or a wall
};

/// What a name means. Severities run from 0 to 1; where the failure is not monotonic in it, `severity` says so.
struct GalleryEntry {
    std::string_view name;
    std::string_view failure;   ///< what it shows: tearing, inflation, tone, noise, seams or loss
    std::string_view severity;  ///< what the parameter changes, from 0 to 1
};

/// In the order in which to list them:
///
///     slats   tone       angle of the slats, 0 to 90 degrees; worst in between; the viewer is 45 degrees above them
///     wall    tearing    normal and viewer go from z (0) over 45 degrees between x and z (0.5) to (1,1,1) (1)
///     bust    tearing    likewise
///     twigs   inflation  thickness from 0.01 down to 0.01 / 32, by halves at every 0.2
///     leaves  tone       contrast of the light
///     sheets  noise      spacing from 0.25 down to 0.25 / 1024, by halves at every 0.1
///     ground  seams      half side of the plane from 2 to 2048, by doubles at every 0.1
///     meadow  loss       height of the blades from 0.08 down to 0.08 / 16, by halves at every 0.25
///     clouds  loss       clouds in a row, 2 to 32, by doubles at every 0.25; the viewer looks along the row
std::span<const GalleryEntry> gallery();

/// As many triangles as the scene's rules allow, but at most `triangles` (at least half of them). Throws
/// std::invalid_argument for an unknown name (listing the known ones), a severity outside [0, 1] and fewer than 1000
/// triangles.
GalleryScene make_gallery(std::string_view name, float severity, std::uint32_t triangles = 20'000);

/// The same picture with one color at each corner.
std::vector<VertexColoredTriangle> vertex_colored(std::span<const Triangle> triangles);

}  // namespace farfield::scenes
