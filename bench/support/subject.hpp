// A scene with its reference and the views of the papers' tables, built once for all benchmarks of a program.
#pragma once

#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "scenes/catalog.hpp"
#include "scenes/scene.hpp"
#include "support/seconds.hpp"

namespace farfield::bench {

using Primitive = VertexColoredTriangle;
using ExactHierarchy = SpatialHierarchy<Octree, Exact, TriangleCount>;
using CubeHierarchy = SpatialHierarchy<Octree, ColorCube, TriangleCount>;

/// One scene under one kind of hierarchy, in the hierarchy's order.
template <class H>
struct Built {
    std::vector<Primitive> primitives;
    H hierarchy;
    double build_seconds = 0;

    explicit Built(std::vector<Primitive> p) : primitives(std::move(p)) {
        build_seconds = seconds([&] { hierarchy = build_in_place<H>(primitives); });
    }
    double bytes_per_triangle() const { return double(hierarchy.bytes()) / double(primitives.size()); }
};

inline std::vector<Primitive> triangles_of(const std::string& scene) {
    scenes::Scene s = scenes::make(scene);
    if (!s.groups.back().placements.empty()) s = scenes::expanded(s);
    return std::move(s.groups.back().triangles);
}

/// The same with one color a triangle, and one for two in a row that are a quadrilateral (a, b, c and a, c, d): their
/// mean. What knows no other colors can then draw the same picture.
inline std::vector<Primitive> in_flat_colors(std::vector<Primitive> triangles) {
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        Primitive& t = triangles[i];
        glm::vec4 color = t.color();
        const bool is_half = i + 1 < triangles.size() && t.vertices[0] == triangles[i + 1].vertices[0] &&
                             t.vertices[2] == triangles[i + 1].vertices[1];
        if (is_half) color = 0.5f * (color + triangles[i + 1].color());
        t.rgba.fill(to_rgba8(color));
        if (is_half) triangles[++i].rgba = t.rgba;
    }
    return triangles;
}

/// Chamberlain 1996, Table 2: the view from `distance` radii, `angle_degrees` off axis; a radius is half of the largest
/// side of the bounds.
inline View table_view(const Box& bounds, double distance, double angle_degrees, int size) {
    const double angle = angle_degrees * 3.14159265358979 / 180, radius = bounds.largest_side() / 2;
    const glm::dvec3 center(bounds.center());
    const glm::dvec3 eye = center + glm::dvec3(std::sin(angle), 0, std::cos(angle)) * (radius * distance);
    return {.camera = Camera::perspective(eye, center, {0, 1, 0}, 1.04719755f), .width = size, .height = size};
}

}  // namespace farfield::bench
