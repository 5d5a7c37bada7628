// Sums over the surfaces in a cell, from which its opacity tensor is made. A parent's sums are the sums
// of its children's.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <initializer_list>
#include <span>

#include "farfield/approximation/opacity_tensor/axis_masks.hpp"
#include "farfield/geometry/box.hpp"
#include "farfield/geometry/cell.hpp"
#include "farfield/geometry/clip_triangle.hpp"
#include "farfield/geometry/length.hpp"
#include "farfield/geometry/polygon.hpp"
#include "farfield/geometry/rgba8.hpp"
#include "farfield/sampler.hpp"

namespace farfield {

/// Areas A of surfaces, weighted by alpha, and the quantities that add up with them. Lengths are local, times
/// Cell::to_ordinary() of the cell.
struct AreaSums {
    std::array<float, 6> tensor{};  ///< sum of A n n^T: xx, yx, zx, yy, zy, zz
    float area = 0;
    float opaque_area = 0;    ///< as if every alpha were 1
    glm::vec3 normal{0};      ///< sum of A n
    glm::vec3 along_axes{0};  ///< sum of A |n|: the area seen along each axis if nothing hides anything
    glm::vec3 moment{0};      ///< sum of A times the centroid's distance from the cell's center
    /// Integral over A of the squared distances from the cell's center, along each axis: a length to the fourth power,
    /// which leaves single precision long before the area does.
    glm::dvec3 squares{0};
    glm::vec3 color{0};  ///< sum of A times the mean color of both sides (of the front, if surfaces are closed)
    /// Sum of A n times half of the luminance that the front has more than the back (the front's, if they are closed).
    glm::vec3 tone{0};

    /// The same in a space `factor` times as large.
    AreaSums scaled(float factor) const {
        const float areas = factor * factor;
        AreaSums s = *this;
        for (float& t : s.tensor) t *= areas;
        for (float* v : {&s.area, &s.opaque_area}) *v *= areas;
        for (glm::vec3* v : {&s.normal, &s.along_axes, &s.color, &s.tone}) *v *= areas;
        s.moment *= areas * factor;
        s.squares *= double(areas) * double(areas);
        return s;
    }
    /// The same about a center that lies `by` from this one.
    AreaSums about(glm::vec3 by) const {
        AreaSums moved = *this;
        moved.moment -= area * by;
        moved.squares += glm::dvec3(by) * (double(area) * glm::dvec3(by) - 2.0 * glm::dvec3(moment));
        return moved;
    }

    AreaSums& operator+=(const AreaSums& o) {
        for (std::size_t i = 0; i < 6; ++i) tensor[i] += o.tensor[i];
        area += o.area;
        opaque_area += o.opaque_area;
        normal += o.normal;
        along_axes += o.along_axes;
        moment += o.moment;
        squares += o.squares;
        color += o.color;
        tone += o.tone;
        return *this;
    }
};

namespace detail {

/// Luminance of a color as stored (Rec. 709).
inline float luminance(glm::vec3 rgb) {
    return glm::dot(rgb, glm::vec3(0.2126f, 0.7152f, 0.0722f));
}

/// A surface in the light of its sampler.
struct LitSurface {
    glm::vec3 normal;  ///< of unit length
    float alpha;
    glm::vec3 rgb;  ///< 0 to 255; times the area it goes into AreaSums::color
    float tone;     ///< luminance; times the area and the normal it goes into AreaSums::tone
};

template <class Sampler>
LitSurface lit_surface(const Polygon& polygon, glm::vec4 color, glm::vec3 normal, bool closed_surfaces,
                       const Sampler& sampler) {
    float front = 1, back = 1;
    if constexpr (LightsPolygons<Sampler>) {
        front = sampler.brightness(polygon, normal);
        if (!closed_surfaces) back = sampler.brightness(polygon, -normal);
    }
    const glm::vec3 rgb = glm::vec3(color) * 255.0f;
    if (closed_surfaces) return {normal, color.w, front * rgb, front * luminance(rgb)};
    return {normal, color.w, 0.5f * (front + back) * rgb, 0.5f * (front - back) * luminance(rgb)};
}

}  // namespace detail

/// A cell's contents while a hierarchy is built, in lengths as those of AreaSums. All members of several cells add up.
struct TensorSums {
    AreaSums sums;
    Box contents = Box::empty();
    AxisMasks masks;

    /// The same in a space `factor` times as large.
    TensorSums scaled(float factor) const {
        return {sums.scaled(factor), {contents.lower * factor, contents.upper * factor}, masks};
    }

    /// Adds the part of a polygon that lies within the cell's bounds. Closed surfaces show their front only.
    template <class Sampler>
    void add(const Cell& local_cell, const Polygon& polygon, bool closed_surfaces, const Sampler& sampler) {
        const float ordinary = local_cell.to_ordinary();
        const Cell cell = local_cell.scaled(ordinary);
        const Box bounds = cell.bounds();
        const std::span<const Rgba8> colors = polygon.colors;
        const bool one_color = colors.size() < polygon.vertices.size();
        for_each_triangle(polygon.vertices.size(), [&](std::size_t a, std::size_t b, std::size_t c) {
            const glm::vec3 corners[3] = {polygon.vertices[a] * ordinary, polygon.vertices[b] * ordinary,
                                          polygon.vertices[c] * ordinary};
            glm::vec4 color = to_vec4(colors[a]);
            if (!one_color) color = (color + to_vec4(colors[b]) + to_vec4(colors[c])) * (1.0f / 3);
            const glm::vec3 doubled = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
            const float length = length_of(doubled);
            if (!(length > 0)) return;
            const auto surface = detail::lit_surface(polygon, color, doubled / length, closed_surfaces, sampler);
            const glm::vec3 lower = glm::min(corners[0], glm::min(corners[1], corners[2]));
            const glm::vec3 upper = glm::max(corners[0], glm::max(corners[1], corners[2]));
            if (bounds.contains(lower) && bounds.contains(upper)) {
                add(cell, bounds, corners, 0.5f * length, surface);
            } else {
                add_clipped(cell, bounds, corners, surface);
            }
        });
    }

  private:
    void add_clipped(const Cell& cell, const Box& bounds, const glm::vec3 (&corners)[3],
                     const detail::LitSurface& surface) {
        const ClippedTriangle inside(bounds, corners);
        const std::span<const glm::vec3> left = inside.corners();
        for_each_triangle(left.size(), [&](std::size_t a, std::size_t b, std::size_t c) {
            const glm::vec3 part[3] = {left[a], left[b], left[c]};
            const glm::vec3 n = glm::cross(part[1] - part[0], part[2] - part[0]);
            add(cell, bounds, part, 0.5f * length_of(n), surface);
        });
    }

    void add(const Cell& cell, const Box& bounds, const glm::vec3 (&corners)[3], float opaque_area,
             const detail::LitSurface& surface) {
        for (const glm::vec3 p : corners) contents.add(p);
        masks.add(bounds, corners);
        const glm::vec3 n = surface.normal;
        const float area = opaque_area * surface.alpha;
        AreaSums& s = sums;
        const glm::vec3 weighted = area * n;
        s.tensor[0] += weighted.x * n.x;
        s.tensor[1] += weighted.y * n.x;
        s.tensor[2] += weighted.z * n.x;
        s.tensor[3] += weighted.y * n.y;
        s.tensor[4] += weighted.z * n.y;
        s.tensor[5] += weighted.z * n.z;
        s.area += area;
        s.opaque_area += opaque_area;
        s.normal += weighted;
        s.along_axes += glm::abs(weighted);
        const glm::vec3 from_center =
            (corners[0] - cell.center) + (corners[1] - cell.center) + (corners[2] - cell.center);
        s.moment += (area / 3) * from_center;
        // Exact for a triangle: quadrature by its corners and its centroid.
        glm::dvec3 squared = glm::dvec3(from_center) * glm::dvec3(from_center);
        for (const glm::vec3 p : corners) {
            const glm::dvec3 off(p - cell.center);
            squared += off * off;
        }
        s.squares += double(area / 12) * squared;
        s.color += area * surface.rgb;
        s.tone += surface.tone * weighted;
    }
};

}  // namespace farfield
