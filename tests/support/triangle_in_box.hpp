// Does a triangle touch a box? The slow way: clipped by the box's six planes, in double.
#pragma once

#include <cstddef>
#include <glm/vec3.hpp>
#include <vector>

#include "farfield/geometry/box.hpp"
#include "farfield/primitive/triangle.hpp"

namespace farfield::test {

/// What is left of a triangle inside a box.
inline std::vector<glm::dvec3> clipped_to(const Triangle& t, const Box& box) {
    std::vector<glm::dvec3> polygon(t.vertices.begin(), t.vertices.end());
    for (int axis = 0; axis < 3; ++axis) {
        for (const double sign : {1.0, -1.0}) {
            const double bound = double(sign > 0 ? box.upper[axis] : box.lower[axis]);
            std::vector<glm::dvec3> out;
            for (std::size_t i = 0; i < polygon.size(); ++i) {
                const glm::dvec3 a = polygon[i], b = polygon[(i + 1) % polygon.size()];
                const double da = sign * (bound - a[axis]), db = sign * (bound - b[axis]);
                if (da >= 0) out.push_back(a);
                if ((da >= 0) != (db >= 0)) {
                    glm::dvec3 cut = a + (b - a) * (da / (da - db));
                    cut[axis] = bound;
                    out.push_back(cut);
                }
            }
            polygon = out;
        }
    }
    return polygon;
}

inline bool touches_by_clipping(const Triangle& t, const Box& box) {
    if (box.is_empty() || !box.intersects(t.bounds())) return false;
    return !clipped_to(t, box).empty();
}

}  // namespace farfield::test
