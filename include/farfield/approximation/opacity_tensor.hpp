// A cell as a tensor of its surfaces' areas: how much of them is seen from any direction, which six faces cannot say.
//
// Six opaque faces seen off their axes are too large ("the color-cube ... tends to be larger", Chamberlain et al. 1995,
// section 5), and tear apart where each is covered in part. The sums T = sum A n n^T over areas A with unit normals n
// give the projected area sqrt(W w^T T w) (W = sum A) towards a unit vector w: exactly for one flat piece, and rescaled
// to the mean of Cauchy's formula (W / 2 over all directions) within a few per cent for most else. It is the form of
// Heitz et al. 2015 ("SGGX"). Sums are merged by adding them; only what is stored is rescaled.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "farfield/approximation.hpp"
#include "farfield/approximation/cell_faces.hpp"
#include "farfield/approximation/opacity_tensor/area_sums.hpp"
#include "farfield/approximation/opacity_tensor/stored_tensor.hpp"
#include "farfield/geometry/clip_triangle.hpp"

namespace farfield {

/// One tensor a cell. 16 bytes. Drawn as one deposit: an upright rectangle of the picture with an opacity.
struct OpacityTensor {
    /// Surfaces are closed and counter-clockwise seen from outside: back sides are not counted, for something hides
    /// them. Goes with a renderer that culls back faces.
    bool closed_surfaces = false;
    /// Areas that hide one another within a cell are counted once. False: for experiments.
    bool counts_overlap = true;
    /// Area of the rectangle in which leaves are strewn, in parts of that of a rectangle as wide and high (in the mean
    /// square) as the contents' box. Less than 1, for contents are denser in their middle. More blurs; less shrinks
    /// outlines.
    float strewn_over = 0.4f;
    /// A sheet's opacity is multiplied by it: rectangles meet but roughly, and what is too much in one place does not
    /// make up for what is missing in another. Costs as much of the coverage of what is smaller than a cell. Of closed
    /// surfaces more is needed, for no back sides close the gaps.
    float sheet_gain = 1.15f, closed_sheet_gain = 1.6f;

    using stand_in_draft = TensorSums;
    using stand_in_data = StoredTensor;
    static constexpr ApproximationFacts facts{.needs_polygons = true,
                                              .stands_in = true,
                                              .merges_octants = true,
                                              .bounds_error = true,
                                              .provides_area_law = true,
                                              .file_tag = 0x4f540001u};

    /// Children's masks nest in their parent's.
    bool merges_children() const { return true; }

    template <class Contents, OrthographicSampler Sampler>
    stand_in_draft sample(const Cell& cell, Contents&& contents, Sampler& sampler) const {
        stand_in_draft d;
        contents([&](const Polygon& polygon) { add(d, cell, polygon, sampler); });
        if constexpr (!LightsPolygons<Sampler>) {
            // Its light is known from its pictures alone.
            const SampleGrid grid{cell.bounds(), 4, 1};
            std::vector<Rgba8> out(grid.size());
            sampler.sample(grid, contents, std::span<Rgba8>(out));
            glm::vec4 sum(0);
            for (const Rgba8 c : out) sum += glm::vec4(float(c.r), float(c.g), float(c.b), float(c.a));
            if (sum.a > 0) d.sums.color = glm::vec3(sum) * (255 / sum.a * d.sums.area);
        }
        return d;
    }

    void merge(const Cell& cell, stand_in_draft& own, std::span<const ChildDraft<stand_in_draft>> children) const {
        const Box bounds = cell.bounds();
        for (const auto& child : children) {
            AreaSums sums = child.draft->sums;
            sums.moment += sums.area * (child.cell->center - cell.center);
            own.sums += sums;
            own.contents.add(child.draft->contents);
            own.masks.add_child(bounds, child.draft->masks, child.cell->bounds());
        }
    }

    stand_in_data finish(const Cell& cell, const stand_in_draft& d) const {
        const TensorFit fit(d, cell, closed_surfaces);
        if (fit.is_empty()) return {};
        TensorShape s = fit.shape(counts_overlap);
        const TensorShape kept = StoredTensor(s).unpacked();
        s.error = fit.held_out_error([&](glm::vec3 w) { return seen_from(kept, w).area; });
        return StoredTensor(s);
    }

    Work expected_work() const { return {.splats = 1}; }
    /// What has no area must not vanish: no price is high enough.
    Work work(const stand_in_data& data) const {
        if (data == StoredTensor{}) return {.splats = std::numeric_limits<float>::infinity()};
        return expected_work();
    }
    std::optional<AreaLaw> area_law(const stand_in_data& data) const { return data.area_law(); }
    bool is_sound(const stand_in_data& data) const { return data.is_sound(); }

    /// The projected side of the cell, for where in it something lies is lost, and as much again if it showed as much
    /// too much or too little as it could: measured when it was made, from directions that nothing was fitted to. Of a
    /// child it is never more.
    float error_px(const stand_in_data& data, const Cell& cell, const LocalView& view) const {
        return view.pixels(cell.largest_side(), view.distance_to(cell)) * (1 + data.error());
    }
    float least_error_px(const Cell& cell, unsigned levels, const LocalView& view) const {
        return least_projected_side(cell, levels, view);
    }

    /// One splat; where the renderer has none, three faces that cross.
    template <class Sink>
    void draw_stand_in(const stand_in_data& data, const Cell& cell, const LocalView& view, Sink&& sink) const {
        const TensorShape s = data.unpacked();
        const float unit = tensor_unit(cell);
        const glm::vec3 center = center_of(s, cell), towards = view.towards_viewer(center);
        if (!(sink.splat_limit_px > 0)) {
            for (int axis = 0; axis < 3; ++axis) {
                if (towards[axis] == 0) continue;  // edge-on
                const Face face = crossing_face(s, cell, axis, towards[axis] > 0);
                if (face.rgba.a != 0) sink(face);
            }
            return;
        }
        const float length = std::sqrt(glm::dot(towards, towards));
        if (!(length > 0) || (view.is_perspective && !(view.depth(center) > 0))) return;
        const Seen seen = seen_from(s, towards / length);
        if (!(seen.area > 0)) return;
        const glm::vec2 size = rectangle(s, center, view);
        const float part = seen.area * view.stretch(center) / (size.x * size.y);
        const float gain = s.law != AreaLaw::coherent ? 1.0f : closed_surfaces ? closed_sheet_gain : sheet_gain;
        const glm::vec3 rgb = seen.rgb + 0.5f;
        sink(Splat{center, size * (unit * std::sqrt(std::max(part, 1.0f))), std::min(gain * part, 1.0f),
                   Rgba8{std::uint8_t(rgb.r), std::uint8_t(rgb.g), std::uint8_t(rgb.b), std::uint8_t(s.law)}});
    }

    /// Three rectangles that cross, each as opaque as the contents are along its normal: turned with an instance, their
    /// tensors add up as all others do.
    template <class Sink>
    void polygons(const stand_in_data& data, const Cell& cell, Sink&& sink) const {
        const TensorShape s = data.unpacked();
        for (int axis = 0; axis < 3; ++axis) emit_polygon(crossing_face(s, cell, axis, true), sink);
    }

  private:
    /// Squares of doubled areas leave single precision long before the areas do.
    static float length_of(glm::vec3 v) {
        const glm::vec3 a = glm::abs(v);
        const float largest = std::max(a.x, std::max(a.y, a.z));
        if (!(largest > 0)) return 0;
        const glm::vec3 scaled = a * (1 / largest);
        return largest * std::sqrt(glm::dot(scaled, scaled));
    }

    template <class Sampler>
    void add(stand_in_draft& d, const Cell& cell, const Polygon& polygon, const Sampler& sampler) const {
        const Box bounds = cell.bounds();
        const std::span<const Rgba8> colors = polygon.colors;
        const bool one_color = colors.size() < polygon.vertices.size();
        for (std::size_t i = 2; i < polygon.vertices.size(); ++i) {
            const glm::vec3 corners[3] = {polygon.vertices[0], polygon.vertices[i - 1], polygon.vertices[i]};
            glm::vec4 color = to_vec4(colors[0]);
            if (!one_color) color = (color + to_vec4(colors[i - 1]) + to_vec4(colors[i])) * (1.0f / 3);
            const glm::vec3 doubled = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
            const float length = length_of(doubled);
            if (!(length > 0)) continue;
            const Surface surface = lit(polygon, color, doubled / length, sampler);
            const glm::vec3 lower = glm::min(corners[0], glm::min(corners[1], corners[2]));
            const glm::vec3 upper = glm::max(corners[0], glm::max(corners[1], corners[2]));
            if (bounds.contains(lower) && bounds.contains(upper)) {
                add(d, cell, bounds, corners, 0.5f * length, surface);
                continue;
            }
            const ClippedTriangle inside(bounds, corners);
            const std::span<const glm::vec3> left = inside.corners();
            for (std::size_t k = 2; k < left.size(); ++k) {
                const glm::vec3 part[3] = {left[0], left[k - 1], left[k]};
                const glm::vec3 n = glm::cross(part[1] - part[0], part[2] - part[0]);
                add(d, cell, bounds, part, 0.5f * length_of(n), surface);
            }
        }
    }

    struct Surface {
        glm::vec3 normal;
        float alpha;
        glm::vec3 rgb;  ///< 0 to 255, what goes into AreaSums::color
        float tone;     ///< likewise
    };
    template <class Sampler>
    Surface lit(const Polygon& polygon, glm::vec4 color, glm::vec3 normal, const Sampler& sampler) const {
        float front = 1, back = 1;
        if constexpr (LightsPolygons<Sampler>) {
            front = sampler.brightness(polygon, normal);
            if (!closed_surfaces) back = sampler.brightness(polygon, -normal);
        }
        const glm::vec3 rgb = glm::vec3(color) * 255.0f;
        if (closed_surfaces) return {normal, color.a, front * rgb, front * luminance(rgb)};
        return {normal, color.a, 0.5f * (front + back) * rgb, 0.5f * (front - back) * luminance(rgb)};
    }

    static void add(stand_in_draft& d, const Cell& cell, const Box& bounds, const glm::vec3 (&corners)[3],
                    float opaque_area, const Surface& surface) {
        for (const glm::vec3 p : corners) d.contents.add(p);
        d.masks.add(bounds, corners);
        const glm::vec3 n = surface.normal;
        const float area = opaque_area * surface.alpha;
        AreaSums& s = d.sums;
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
        s.color += area * surface.rgb;
        s.tone += surface.tone * weighted;
    }

    struct Seen {
        float area;     ///< covered, each place once; in squares of the bounds' side
        glm::vec3 rgb;  ///< 0 to 255
    };
    Seen seen_from(const TensorShape& s, glm::vec3 w) const {
        float area = s.area_seen_from(w);
        if (!(area > 0)) return {0, s.rgb};
        float tone = std::max(1 + glm::dot(s.tone, w) / area, 0.0f);
        if (closed_surfaces) {
            const float fronts = 1 + glm::clamp(glm::dot(s.facing, w) / area, -1.0f, 1.0f);
            if (fronts < 0.04f) return {0, s.rgb};
            tone = std::min(tone / fronts, 2.0f);
            area *= 0.5f * fronts;
        }
        if (counts_overlap) {
            const float outline = outline_of(s, w);
            area = outline * (1 - transmitted(1, area / outline, s.law));
        }
        return {area, glm::min(s.rgb * tone, glm::vec3(255))};
    }

    /// Of the contents' box, in which sheets lie anyhow. What is strewn in it is thin where it is seen through an edge
    /// or a corner, and counts for less there: within 4 % of what leaves cover that fill a cube once or twice.
    static float outline_of(const TensorShape& s, glm::vec3 w) {
        const glm::vec3 e = s.extent, sides = glm::abs(w) * glm::vec3(e.y * e.z, e.z * e.x, e.x * e.y);
        const float outline = sides.x + sides.y + sides.z;
        return s.law == AreaLaw::coherent ? outline : 0.15f * outline + 0.85f * std::sqrt(glm::dot(sides, sides));
    }

    /// Width and height in the picture, in sides of the bounds.
    glm::vec2 rectangle(const TensorShape& s, glm::vec3 center, const LocalView& view) const {
        glm::vec3 right = view.right, up = view.up;
        if (view.is_perspective) {  // what lies deeper is nearer to the vanishing point
            const glm::vec3 d = center - view.eye;
            const float inverse = 1 / glm::dot(d, view.forward);
            right -= view.forward * (glm::dot(d, view.right) * inverse);
            up -= view.forward * (glm::dot(d, view.up) * inverse);
        }
        if (s.law != AreaLaw::coherent) {
            right *= s.extent;
            up *= s.extent;
            return glm::sqrt(strewn_over * glm::vec2(glm::dot(right, right), glm::dot(up, up)));
        }
        // In a flat sheet the coordinate in which it is steepest follows from the others: it is not as large as its
        // box.
        const glm::vec2 box(glm::dot(glm::abs(right), s.extent), glm::dot(glm::abs(up), s.extent));
        const glm::vec3 n = s.sheet_normal(), steep = glm::abs(n);
        const int k = steep.x >= steep.y && steep.x >= steep.z ? 0 : steep.y >= steep.z ? 1 : 2;
        if (n[k] != 0) {
            right -= n * (right[k] / n[k]);
            up -= n * (up[k] / n[k]);
        }
        const glm::vec2 size(glm::dot(glm::abs(right), s.extent), glm::dot(glm::abs(up), s.extent));
        return glm::max(glm::min(size, box), 0x1p-8f);  // edge-on
    }

    static glm::vec3 center_of(const TensorShape& s, const Cell& cell) {
        return cell.bounds_center - cell.bounds_half + s.center * tensor_unit(cell);
    }

    Face crossing_face(const TensorShape& s, const Cell& cell, int axis, bool looks_up) const {
        const glm::vec3 center = center_of(s, cell), half = s.extent * (0.5f * tensor_unit(cell));
        glm::vec3 w(0);
        w[axis] = looks_up ? 1.0f : -1.0f;
        const Seen seen = seen_from(s, w);
        const float outline = s.extent[(axis + 1) % 3] * s.extent[(axis + 2) % 3];
        const float alpha = std::min(seen.area / outline, 1.0f);
        Face face{center - half, center + half, to_rgba8(glm::vec4(seen.rgb * (alpha / 255), alpha)),
                  std::uint8_t(2 * axis + (looks_up ? 1 : 0))};
        face.lower[axis] = face.upper[axis] = center[axis];
        return face;
    }
};

}  // namespace farfield
