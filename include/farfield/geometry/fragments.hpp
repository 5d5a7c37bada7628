// The convex pieces, one for each position, that polygons become in a hierarchy whose partition cuts them.
#pragma once

#include "farfield/settings.hpp"

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

#include "farfield/geometry/polygon.hpp"
#include "farfield/geometry/rgba8.hpp"

namespace farfield {

/// Pieces in the hierarchy's order of items, in its local coordinates. Vertices run counter-clockwise seen from the
/// front, as those of the polygon did that the piece was cut from. Borrowed from the hierarchy.
struct Fragments {
    std::span<const std::uint32_t> first_vertex;  ///< by position, and one more at the end; empty: nothing is cut
    std::span<const glm::vec3> vertices;
    std::span<const Rgba8> colors;  ///< parallel to vertices

    bool empty() const { return first_vertex.empty(); }
    std::size_t size_bytes() const { return first_vertex.size_bytes() + vertices.size_bytes() + colors.size_bytes(); }
    /// A polygon of three vertices or more, or of none where the position is an instance's.
    Polygon operator[](std::uint32_t position) const {
        const std::size_t first = first_vertex[position], count = first_vertex[position + 1] - first;
        return {vertices.subspan(first, count), colors.subspan(first, count)};
    }
};

}  // namespace farfield
