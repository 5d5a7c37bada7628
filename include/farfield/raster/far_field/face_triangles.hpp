// Cuts a face of the far field into triangles on the screen.
#pragma once

#include "farfield/settings.hpp"

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>

#include "farfield/drawables.hpp"
#include "farfield/raster/polygon_clip.hpp"
#include "farfield/raster/sample_projection.hpp"
#include "farfield/raster/scan_conversion.hpp"

namespace farfield::detail {

/// Calls f(triangle, depth plane) for each clockwise triangle of the face, clipped to what can be drawn. Adjoining
/// faces leave no gap.
template <class F>
void for_triangles_of(const Face& face, const SampleProjection& projection, F&& f) {
    ClippedPolygon polygon;
    const int axis = face.side / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (int corner = 0; corner < 4; ++corner) {
        glm::vec3 p = face.lower;
        if (corner == 1 || corner == 2) p[u] = face.upper[u];
        if (corner >= 2) p[v] = face.upper[v];
        polygon.add(p, projection);
    }
    polygon.clip(projection);
    for (std::size_t i = 2; i < polygon.size(); ++i) {
        SnappedTriangle t;
        const std::size_t from[3] = {0, i - 1, i};
        for (unsigned c = 0; c < 3; ++c) polygon.snap(from[c], projection, t, c);
        std::int64_t doubled_area = t.doubled_area();
        if (doubled_area == 0) continue;
        if (doubled_area < 0) {
            t.flip();
            doubled_area = -doubled_area;
        }
        f(t, DepthPlane(t, doubled_area));
    }
}

}  // namespace farfield::detail
