// Boxes and polygons of the scene as lines of the picture.
#pragma once

#include <array>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "farfield/camera.hpp"
#include "scenes/how_drawn.hpp"
#include "scenes/looked_at.hpp"

namespace viewer {

struct Line {
    glm::dvec2 from, to;
};

/// A stand-in's outline has its level's color, that of drawn primitives is gray; of what was culled it is red where
/// something hides it, and blue beside the picture.
inline farfield::Rgba8 tint_of(const farfield::scenes::CellOutline& cell) {
    if (cell.is_outside) return {70, 90, 160, 90};
    if (cell.is_hidden) return {230, 30, 40, 130};
    if (!cell.is_stand_in) return {90, 90, 90, 60};
    farfield::Rgba8 tint = farfield::scenes::tint_of_level(cell.depth);
    tint.a = 200;
    return tint;
}

/// Of a perspective camera, in a picture of that size, from its upper left corner; nothing where all of it lies behind
/// the eye.
inline std::optional<Line> project(const farfield::Camera& camera, glm::dvec2 size, glm::dvec3 a, glm::dvec3 b) {
    const auto in_view = [&](glm::dvec3 p) {
        const glm::dvec3 d = p - camera.eye;
        return glm::dvec3(glm::dot(d, glm::dvec3(camera.right)), glm::dot(d, glm::dvec3(camera.up)),
                          glm::dot(d, glm::dvec3(camera.forward)));
    };
    glm::dvec3 p = in_view(a), q = in_view(b);
    // A little before the eye, in parts of the line's own length.
    const double nearest = 1e-3 * glm::length(q - p);
    if (!(nearest > 0) || (p.z < nearest && q.z < nearest)) return std::nullopt;
    const glm::dvec3 cut = p + (q - p) * ((nearest - p.z) / (q.z - p.z));
    if (p.z < nearest) p = cut;
    if (q.z < nearest) q = cut;
    const double focal = 0.5 * size.y / double(camera.half_height);
    const auto on_screen = [&](glm::dvec3 v) {
        return glm::dvec2(0.5 * size.x + focal * v.x / v.z, 0.5 * size.y - focal * v.y / v.z);
    };
    return Line{on_screen(p), on_screen(q)};
}

inline void add_lines(const farfield::Camera& camera, glm::dvec2 size, const farfield::scenes::CellOutline& cell,
                      std::vector<Line>& lines) {
    const auto corner = [&](unsigned i) {
        return cell.center + (i & 1 ? 1.0 : -1.0) * cell.half[0] + (i & 2 ? 1.0 : -1.0) * cell.half[1] +
               (i & 4 ? 1.0 : -1.0) * cell.half[2];
    };
    for (unsigned i = 0; i < 8; ++i) {
        for (unsigned axis = 1; axis < 8; axis *= 2) {
            if (i & axis) continue;
            if (const auto line = project(camera, size, corner(i), corner(i | axis))) lines.push_back(*line);
        }
    }
}

inline void add_lines(const farfield::Camera& camera, glm::dvec2 size, const std::vector<glm::dvec3>& polygon,
                      std::vector<Line>& lines) {
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        if (const auto line = project(camera, size, polygon[i], polygon[(i + 1) % polygon.size()])) {
            lines.push_back(*line);
        }
    }
}

}  // namespace viewer
