// The contents of a tile, whatever hierarchy they are from, and the bytes of the GLB that holds them.
#pragma once

#include <cstddef>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "farfield/geometry/box.hpp"
#include "farfield/geometry/polygon.hpp"
#include "farfield/geometry/rgba8.hpp"
#include "gaussian.hpp"

namespace farfield_export {

/// Three vertices a triangle.
struct TileMesh {
    std::vector<glm::vec3> positions{};
    std::vector<farfield::Rgba8> colors{};  ///< as displays take them, not premultiplied

    std::size_t triangles() const { return positions.size() / 3; }
    void add(const farfield::Polygon& polygon);
};

struct TileContent {
    TileMesh surfaces{};  ///< primitives, seen from both sides
    TileMesh faces{};     ///< what stands in for cells, seen from the front, with opacities
    /// One in the middle of each primitive that may become smaller than a pixel: a triangle that no pixel's center lies
    /// in is not drawn, and a point is.
    std::vector<glm::vec3> points{};
    std::vector<farfield::Rgba8> point_colors{};
    std::vector<GaussianSplat> splats{};

    bool is_empty() const {
        return surfaces.positions.empty() && faces.positions.empty() && points.empty() && splats.empty();
    }
    /// Of triangles, points and splats; an axis-aligned box.
    farfield::Box bounds() const;
};

/// glTF 2.0 as one binary file: a mesh with a primitive for each kind that there is. Triangles and points have
/// KHR_materials_unlit, since light is in the colors; splats KHR_gaussian_splatting, whose fallback is points.
/// Coordinates are those of the content: what is up there is up in glTF if it is y. Of contents that lie far from zero,
/// more than 16 times their extent along an axis, the node has the translation and vertices the rest, without rounding:
/// viewers add up transforms in double precision, and transform vertices in single. Equal contents give equal bytes.
std::string glb_of(const TileContent& content);

}  // namespace farfield_export
