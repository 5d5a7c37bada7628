// A cell as one splat of a representative color, as large or as opaque as the areas in the cell: the
// "far-off-splatting" of Klein et al. 2002, section 4.5.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <span>

#include "farfield/approximation.hpp"
#include "farfield/approximation/cell_faces.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/geometry/box.hpp"
#include "farfield/geometry/cell.hpp"
#include "farfield/geometry/polygon.hpp"

namespace farfield {

/// 24 bytes a cell: a color for each of six sides, the center of the areas and how much of a side of the cell they
/// fill, seen along each axis. The paper has one color ("the median of all polygon colors depending on the polygon
/// areas"), which shows what lies behind as often as what lies in front; here it is a mean of what a sampled image
/// shows from each side. The paper's splat is a square; here it is a rectangle that lies as the surfaces do, so that
/// ground seen at a grazing angle is closed by what is wide and low, where squares of its area leave gaps beside one
/// another.
struct AreaSplat {
    /// The size of the splat, which is opaque: that of the areas; or of the cell, as the paper draws it, where thin
    /// things become too large and nothing has holes.
    enum class Size : std::uint8_t { of_areas, of_cell };
    Size size = Size::of_areas;
    /// Orthographic samples along a side of the cell, 1 to 8, that colors are made from. 0 takes all polygons, hidden
    /// or not, weighted by their projected areas: the paper's color, from each side.
    std::uint32_t samples = 4;
    /// The part of their areas that surfaces show, averaged over all directions. Cauchy: a flat one shows half of it.
    float shown = 0.5f;

    struct stand_in_draft {
        ColorCube::stand_in_draft faces{};
        glm::vec3 moment{0};     ///< sum of area times place about the cell's center, in ordinary units
        float area = 0;          ///< in ordinary units of the cell (Cell::to_ordinary)
        glm::vec3 projected{0};  ///< sums of the areas, each seen along an axis from both sides
        glm::vec3 color{0};      ///< sum of area times color, for what samples miss
        Box contents = Box::empty();
    };
    /// Sides -x, +x, -y, +y, -z, +z. Fourth bytes hold, in order, the center's place in the cell's bounds (three bytes,
    /// of the first of which the lowest bit says whether the contents lie in flat_part()) and, along x, y and z, the
    /// root of the part of a side that is filled.
    using stand_in_data = std::array<Rgba8, 6>;
    static constexpr ApproximationFacts facts{.needs_polygons = true,
                                              .stands_in = true,
                                              .merges_octants = true,
                                              .bounds_error = true,
                                              .expects_error = true,
                                              .file_tag = 0x41530003u};

    const char* wrong_option() const {
        if (size > Size::of_cell) return "AreaSplat: an option is not in its enum";
        if (samples > 8) return "AreaSplat: samples must be at most 8";
        return shown > 0 && shown <= 1 ? nullptr : "AreaSplat: shown must lie above 0 and at most at 1";
    }

    bool merges_children() const { return true; }

    template <class Contents, OrthographicSampler Sampler>
    stand_in_draft sample(const Cell& cell, Contents&& contents, Sampler& sampler) const {
        stand_in_draft d{.faces = colors().sample(cell, contents, sampler)};
        const float unit = cell.to_ordinary();
        contents([&](const Polygon& polygon) {
            const std::size_t corners = polygon.vertices.size();
            const glm::vec3 normal =
                doubled_area<float>(corners, [&](std::size_t i) { return polygon.vertices[i] * unit; });
            const float area = 0.5f * glm::length(normal);
            glm::vec3 sum(0);
            for (const glm::vec3& v : polygon.vertices) {
                sum += (v - cell.center) * unit;
                d.contents.add(v);
            }
            d.area += area;
            d.projected += 0.5f * glm::abs(normal);
            d.moment += sum * (area / float(corners));
            glm::vec3 color(0);
            for (const Rgba8 c : polygon.colors) color += glm::vec3(to_vec4(c));
            if constexpr (LightsPolygons<Sampler>) color *= sampler.brightness(polygon, normal);
            d.color += color * (area / float(polygon.colors.size()));
        });
        return d;
    }

    void merge(const Cell& cell, stand_in_draft& own, std::span<const ChildDraft<stand_in_draft>> children) const {
        std::array<ChildDraft<ColorCube::stand_in_draft>, 8> faces;
        const float unit = cell.to_ordinary();
        for (std::size_t i = 0; i < children.size(); ++i) {
            const auto& child = children[i];
            faces[i] = {child.child, child.cell, &child.draft->faces};
            const float larger = unit / child.cell->to_ordinary();
            const float area = child.draft->area * larger * larger;
            own.area += area;
            own.projected += child.draft->projected * (larger * larger);
            own.color += child.draft->color * (larger * larger);
            own.contents.add(child.draft->contents);
            own.moment +=
                child.draft->moment * (larger * larger * larger) + (child.cell->center - cell.center) * unit * area;
        }
        colors().merge(cell, own.faces,
                       std::span<const ChildDraft<ColorCube::stand_in_draft>>(faces.data(), children.size()));
    }

    stand_in_data finish(const Cell& cell, const stand_in_draft& d) const {
        stand_in_data data;
        data.fill({0, 0, 0, 0});
        if (!(d.area > 0)) return data;
        glm::vec4 mean(0);
        for (const glm::vec4& face : d.faces) mean += face;
        if (!(mean.w > 0)) mean = glm::vec4(d.color, d.area);
        for (std::size_t side = 0; side < 6; ++side) {
            // A side that nothing is seen through has no color of its own.
            const glm::vec4 c = d.faces[side].w > 0 ? d.faces[side] : mean;
            data[side] = to_rgba8(glm::vec4(glm::vec3(c) / c.w, 0));
        }
        const float unit = cell.to_ordinary();
        const glm::vec3 center = (d.moment / d.area) / unit + cell.center;
        const glm::vec3 place = (center - (cell.bounds_center - cell.bounds_half)) / (2.0f * cell.bounds_half);
        for (int axis = 0; axis < 3; ++axis) {
            const float inside = cell.bounds_half[axis] > 0 ? glm::clamp(place[axis], 0.0f, 1.0f) : 0.5f;
            data[std::size_t(axis)].a =
                std::uint8_t(axis == 0 ? 2 * unsigned(inside * 127 + 0.5f) : unsigned(inside * 255 + 0.5f));
        }
        const float side = cell.largest_side() * unit, mean_projected = mean_length(d.projected);
        const float shown_part = side > 0 ? shown * d.area / (side * side) : 1.0f;
        set_filled_parts(data,
                         mean_projected > 0 ? d.projected * (shown_part / mean_projected) : glm::vec3(shown_part));
        const Box flat = flat_part(data, cell);
        const int axis = flat_axis(filled_parts(data));
        const bool is_flat = d.contents.lower[axis] >= flat.lower[axis] && d.contents.upper[axis] <= flat.upper[axis];
        data[0].a = std::uint8_t(data[0].a | unsigned(is_flat));
        return data;
    }

    /// What is left to draw where `drawn` of the areas, 0 to 1, has been drawn: of a side of which `a` is filled in
    /// all, the part of what a drawn leaves.
    stand_in_data rest_of(stand_in_data data, float drawn) const {
        if (is_nothing(data)) return data;
        glm::vec3 parts = filled_parts(data);
        for (int axis = 0; axis < 3; ++axis) {
            const float covered = parts[axis] * drawn;
            parts[axis] = covered < 1 ? (parts[axis] - covered) / (1 - covered) : 1.0f;
        }
        set_filled_parts(data, parts);
        return data;
    }

    Work expected_work() const { return {.splats = 1}; }
    /// Contents without an area must not vanish, so their stand-in is never worth it.
    Work work(const stand_in_data& data) const {
        if (is_nothing(data)) return {.splats = std::numeric_limits<float>::infinity()};
        return expected_work();
    }
    bool is_sound(const stand_in_data&) const { return true; }  // whatever the bytes are, they stand for something

    /// The projected side of the cell: "its projected bounding box is at most i^2 pixels" (section 4.5).
    float error_px(const stand_in_data&, const Cell& cell, const LocalView& view) const {
        return view.pixels(cell.largest_side(), view.distance_to(cell));
    }
    float least_error_px(const Cell& cell, unsigned levels, const LocalView& view) const {
        return least_projected_side(cell, levels, view);
    }

    /// What is drawn is opaque, so that is what covers.
    float covered_part(const stand_in_data& data, const Cell& cell, const LocalView& view) const {
        if (size == Size::of_cell) return 1;
        const float side = cell.largest_side(), unit = length_unit(cell), part = side * (1 / unit);
        const glm::vec3 w = view.direction_towards_viewer(center_in(data, cell));
        const float outline = outline_of(cell.half / unit, w), area = part_seen(filled_parts(data), w) * part * part;
        return outline > area ? area / outline : 1.0f;
    }
    /// As one face of a cube, of one color and in one place.
    float expected_rmse(float side_px, float covered) const { return cube_rmse(side_px, covered); }

    /// One splat, or the faces that are seen where the renderer has none.
    template <class Sink>
    void draw_stand_in(const stand_in_data& data, const Cell& cell, const LocalView& view, Sink&& sink) const {
        if (is_nothing(data)) return;
        const VisibleFaces seen(cell, view);
        const glm::vec3 center = center_in(data, cell), parts = filled_parts(data);
        const float part = part_seen(parts, view.direction_towards_viewer(center));
        if (size == Size::of_areas && !(part > 0)) return;  // flat, and seen from its edge
        if (!(sink.splat_limit_px > 0)) {
            const float shrunk = size == Size::of_areas ? std::sqrt(part) : 1.0f;
            for (int i = 0; i < seen.count; ++i) {
                const unsigned side = seen.side[std::size_t(i)];
                Face face = face_of(cell, side, {data[side].r, data[side].g, data[side].b, 255});
                face.lower = center + (face.lower - cell.center) * shrunk;
                face.upper = center + (face.upper - cell.center) * shrunk;
                sink(face);
            }
            return;
        }
        glm::vec3 sum(0);
        float weight = 0;
        for (int i = 0; i < seen.count; ++i) {
            const Rgba8 c = data[seen.side[std::size_t(i)]];
            const float projected = seen.projected[std::size_t(i)];
            sum += glm::vec3(c.r, c.g, c.b) * projected;
            weight += projected;
        }
        if (!(weight > 0)) return;
        const glm::vec3 rgb = glm::min(sum / weight + 0.5f, glm::vec3(255.0f));
        Splat splat{
            center, glm::vec2(cell.largest_side() * std::sqrt(view.stretch(center))), 1,
            Rgba8{std::uint8_t(rgb.x), std::uint8_t(rgb.y), std::uint8_t(rgb.z), std::uint8_t(AreaLaw::coherent)}};
        if (size == Size::of_areas) lay(splat, parts, part, cell, view);
        sink(splat);
    }

    /// All that the contents of a cell may reach, or a layer in it, where the contents lie in one.
    ContentsBox contents_box(const stand_in_data& data, const Cell& cell, const Box& reach,
                             const LocalView& view) const {
        if (is_nothing(data)) return {};
        Box box = (data[0].a & 1) != 0 ? flat_part(data, cell) : reach;
        box = {glm::clamp(box.lower, reach.lower, reach.upper), glm::clamp(box.upper, reach.lower, reach.upper)};
        const glm::vec3 center = box.center(), half = box.upper * 0.5f - box.lower * 0.5f, parts = filled_parts(data),
                        w = view.direction_towards_viewer(center);
        const float outline = outline_of(half / cell.largest_side(), w), area = part_seen(parts, w);
        glm::vec3 sum(0);
        for (const Rgba8 c : data) sum += glm::vec3(c.r, c.g, c.b);
        const glm::vec3 rgb = sum / 6.0f + 0.5f;
        return {center, half, outline > area ? area / outline : 1.0f,
                Rgba8{std::uint8_t(rgb.x), std::uint8_t(rgb.y), std::uint8_t(rgb.z), std::uint8_t(AreaLaw::coherent)}};
    }

  private:
    ColorCube colors() const { return {.samples = samples}; }

    /// Makes a square as large as the cell a rectangle of the area that is seen, which lies within the box of the cell
    /// in the picture and has its shape. Where nearly all is seen along one axis, as of ground or a wall, that is the
    /// shape of the box without its depth along that axis.
    static void lay(Splat& splat, glm::vec3 parts, float part, const Cell& cell, const LocalView& view) {
        // What a step to the right, and up, is in the picture at the depth of the center: a plane's linear projection.
        const glm::vec3 d = splat.center - view.eye;
        const float depth = glm::dot(d, view.forward);
        const bool is_stretched = view.is_perspective && depth > 0;
        const glm::vec3 to_right =
            is_stretched ? view.right - view.forward * (glm::dot(d, view.right) / depth) : view.right;
        const glm::vec3 to_up = is_stretched ? view.up - view.forward * (glm::dot(d, view.up) / depth) : view.up;
        const auto extent = [&](glm::vec3 half) {
            return glm::vec2(glm::dot(glm::abs(to_right), half), glm::dot(glm::abs(to_up), half)) * 2.0f;
        };
        const glm::vec2 box = extent(cell.half);
        const glm::vec2 shape = extent(without_depth(cell.half, parts));
        if (!(shape.x > 0) || !(shape.y > 0)) return;
        const float side = splat.size.x * std::sqrt(part);  // of a square of the area that is seen
        float width = glm::min(side * std::sqrt(shape.x / shape.y), box.x);
        const float height = glm::min(side * (side / width), box.y);
        width = glm::min(side * (side / height), box.x);
        splat.size = {width, height};
        // Its place is where the areas are, as far as it does not leave the box.
        const glm::vec3 from_middle = splat.center - cell.center;
        const glm::vec2 place(glm::dot(to_right, from_middle), glm::dot(to_up, from_middle));
        const glm::vec2 most = (box - splat.size) * 0.5f, moved = glm::clamp(place, -most, most) - place;
        splat.center += view.right * moved.x + view.up * moved.y;
    }

    /// That most is seen along.
    static int flat_axis(glm::vec3 parts) {
        return parts.x >= parts.y ? (parts.x >= parts.z ? 0 : 2) : (parts.y >= parts.z ? 1 : 2);
    }
    /// The layer of a cell's bounds that a plane through the center would lie in which shows as much along each axis.
    /// It is no thinner than the center's place is uncertain.
    static Box flat_part(const stand_in_data& data, const Cell& cell) {
        const glm::vec3 parts = filled_parts(data);
        const int flat = flat_axis(parts);
        const float slopes = (parts[(flat + 1) % 3] + parts[(flat + 2) % 3]) / parts[flat];
        Box box = cell.bounds();
        const float middle = center_in(data, cell)[flat], half = cell.bounds_half[flat] * (slopes + 1.0f / 64);
        box.lower[flat] = glm::max(box.lower[flat], middle - half);
        box.upper[flat] = glm::min(box.upper[flat], middle + half);
        return box;
    }

    /// Half of a box, less thick along the axis that most is seen along; all of it where as much is seen along another.
    static glm::vec3 without_depth(glm::vec3 half, glm::vec3 parts) {
        const int flat = flat_axis(parts);
        const float others = glm::max(parts[(flat + 1) % 3], parts[(flat + 2) % 3]) / parts[flat];
        half[flat] *= others * others;
        return half;
    }

    /// The mean over all directions d of |(p.x d.x, p.y d.y, p.z d.z)|, within 2 % of it: a half for one axis alone, 1
    /// for three alike.
    static float mean_length(glm::vec3 p) {
        return 0.316f * ((p.x + p.y + p.z) / 3) + 0.684f * std::sqrt(glm::dot(p, p) / 3);
    }
    /// The part of a side that is filled, seen from a unit vector: exact along the axes, and where as much is seen
    /// along each of them, from everywhere.
    static float part_seen(glm::vec3 parts, glm::vec3 w) { return glm::min(length_of(parts * w), 1.0f); }

    static void set_filled_parts(stand_in_data& data, glm::vec3 parts) {
        const float most = glm::max(parts.x, glm::max(parts.y, parts.z));
        for (int axis = 0; axis < 3; ++axis) {
            const auto steps = unsigned(std::sqrt(glm::min(parts[axis], 1.0f)) * 255 + 0.5f);
            data[std::size_t(3 + axis)].a =
                std::uint8_t(steps == 0 && parts[axis] == most ? 1 : steps);  // 0 is nothing
        }
    }
    static glm::vec3 filled_parts(const stand_in_data& data) {
        const glm::vec3 roots = glm::vec3(data[3].a, data[4].a, data[5].a) * (1.0f / 255);
        return roots * roots;
    }
    static bool is_nothing(const stand_in_data& data) { return (data[3].a | data[4].a | data[5].a) == 0; }
    static glm::vec3 center_in(const stand_in_data& data, const Cell& cell) {
        const glm::vec3 place =
            glm::vec3(data[0].a & 0xfeu, data[1].a, data[2].a) * (2.0f / glm::vec3(254, 255, 255)) - 1.0f;
        return cell.bounds_center + place * cell.bounds_half;
    }
};

}  // namespace farfield
