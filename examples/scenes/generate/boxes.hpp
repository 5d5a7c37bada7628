// Closed boxes of twelve triangles, painted for indoors.
#pragma once

#include <array>
#include <vector>

#include "farfield/geometry/box.hpp"
#include "farfield/primitive/triangle.hpp"
#include "scenes/light.hpp"

namespace farfield::scenes {

inline constexpr std::size_t triangles_per_box = 12;

/// Many lamps on a ceiling over a bright floor: the same from all sides but for a shade between x and z, which keeps
/// edges visible. Furniture may be turned by half a turn under it, and by quarter turns without anybody noticing.
inline glm::vec3 office_lit(glm::vec3 albedo, int axis, bool positive) {
    constexpr Light lamps{
        .to_sun = {0, 1, 0}, .sun = glm::vec3(0.3f), .sky = {1.05f, 1.03f, 0.98f}, .ground = {0.75f, 0.73f, 0.7f}};
    glm::vec3 normal(0);
    normal[axis] = positive ? 1.0f : -1.0f;
    return lit(lamps, albedo, normal, 1.0f, axis == 2 ? 0.78f : 1.0f);
}

/// Appends six quadrilaterals, each two triangles one after the other, counter-clockwise seen from outside: x, y, z,
/// the lower side first. `albedo` is linear; above 1 it glows. `lower_edge` is how much light reaches the
/// lower edge of the sides: 1 for what is continued by other boxes.
inline void add_box(std::vector<VertexColoredTriangle>& triangles, const Box& box, glm::vec3 albedo,
                    float lower_edge = 0.8f) {
    // Bit i of a corner is its upper end on axis i.
    constexpr int faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    for (int face = 0; face < 6; ++face) {
        const int axis = face / 2;
        const glm::vec3 light = office_lit(albedo, axis, face % 2 == 1);
        std::array<glm::vec3, 4> v{};
        std::array<Rgba8, 4> color{};
        for (std::size_t i = 0; i < 4; ++i) {
            const int corner = faces[face][i];
            for (int a = 0; a < 3; ++a) v[i][a] = (corner >> a & 1) ? box.upper[a] : box.lower[a];
            color[i] = display_color(axis != 1 && !(corner & 2) ? light * lower_edge : light);
        }
        triangles.push_back({{v[0], v[1], v[2]}, {color[0], color[1], color[2]}});
        triangles.push_back({{v[0], v[2], v[3]}, {color[0], color[2], color[3]}});
    }
}

}  // namespace farfield::scenes
