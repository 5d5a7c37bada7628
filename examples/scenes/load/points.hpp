// Clouds of points as files have them, and the discs and balls that they become; shared by their loaders, not for
// users.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "farfield/geometry/rgba8.hpp"
#include "farfield/primitive/point.hpp"
#include "scenes/load/load_detail.hpp"
#include "scenes/load/mesh.hpp"

namespace farfield::scenes::detail {

/// All but the positions are empty, or one a point.
struct Cloud {
    std::vector<glm::dvec3> positions{};
    std::vector<Rgba8> colors{};
    std::vector<float> intensities{};  ///< in any unit; they become grays where there are no colors
    std::vector<glm::vec3> normals{};  ///< of any length; 0 or not finite: not known
    std::vector<float> radii{};        ///< not finite or negative: not known
    std::vector<std::string> notes{};
};

/// Sets what is not known of the points: radii from the distances to their neighbors, so that the discs of an evenly
/// sampled surface leave no gap; normals from the plane through the neighbors, where they lie close to one, towards the
/// light. What neighbors agree on holds for a point: one that lies far from all others, or few that do, become no
/// larger than twice what is usual next to them. Points at one place count once. O(n log n); the same on any machine.
struct Unknown {
    bool radii, normals;
};
void set_from_neighbors(std::span<Point> points, std::span<const Unknown> unknown, glm::vec3 up = {0, 1, 0});

/// One disc of 4 triangles (192 bytes) or ball of 8 (384) a point, in order. Points whose position is not finite are
/// left out with a note: scanners write them for what they did not see. Throws if there are no others.
Loaded drawn(Cloud cloud, const LoadOptions& options = {});

/// A table of numbers, with a count before it or several with theirs, or the names of its columns; see load.hpp.
/// Where both can be meant, an intensity comes before the colors if `intensity_first`, as in PTS.
Loaded read_point_table(std::string_view text, bool intensity_first, const LoadOptions& options = {});
/// Whether a file named .xyz is one, and not a molecule.
bool is_point_table(std::string_view text);
Loaded read_pcd(std::string_view bytes, const LoadOptions& options = {});

}  // namespace farfield::scenes::detail
