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
#include "farfield/geometry/polygon.hpp"

namespace farfield {

/// 24 bytes a cell: a color for each of six sides, the center of the areas and how much of a side of the cell they
/// fill. The paper has one color ("the median of all polygon colors depending on the polygon areas"), which shows what
/// lies behind as often as what lies in front; here it is a mean of what a sampled image shows from each side.
struct AreaSplat {
    /// The size of the splat, which is opaque: that of the areas; or of the cell, as the paper draws it, where thin
    /// things become too large and nothing has holes.
    enum class Size : std::uint8_t { of_areas, of_cell };
    Size size = Size::of_areas;
    /// Orthographic samples along a side of the cell, 1 to 8, that colors are made from. 0 takes all polygons, hidden
    /// or not, weighted by their projected areas: the paper's color, from each side.
    std::uint32_t samples = 4;
    /// The part of their areas that surfaces show on average. Cauchy: a flat one shows half of it.
    float shown = 0.5f;

    struct stand_in_draft {
        ColorCube::stand_in_draft faces{};
        glm::vec3 moment{0};  ///< sum of area times place about the cell's center, in ordinary units
        float area = 0;       ///< in ordinary units of the cell (Cell::to_ordinary)
        glm::vec3 color{0};   ///< sum of area times color, for what samples miss
    };
    /// Sides -x, +x, -y, +y, -z, +z. Fourth bytes hold, in order, the center's place in the cell's bounds (three bytes)
    /// and the filled part of a side (two bytes, the upper one first).
    using stand_in_data = std::array<Rgba8, 6>;
    static constexpr ApproximationFacts facts{.needs_polygons = true,
                                              .stands_in = true,
                                              .merges_octants = true,
                                              .bounds_error = true,
                                              .expects_error = true,
                                              .file_tag = 0x41530001u};

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
            for (const glm::vec3& v : polygon.vertices) sum += (v - cell.center) * unit;
            d.area += area;
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
            own.color += child.draft->color * (larger * larger);
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
            data[std::size_t(axis)].a = std::uint8_t(inside * 255 + 0.5f);
        }
        const float side = cell.largest_side() * unit;
        set_filled_part(data, side > 0 ? std::min(shown * d.area / (side * side), 1.0f) : 1.0f);
        return data;
    }

    /// What is left to draw where `drawn` of the areas, 0 to 1, has been drawn: of a side of which `a` is filled in
    /// all, the part of what a drawn leaves.
    stand_in_data rest_of(stand_in_data data, float drawn) const {
        const float all = filled_part(data), covered = all * drawn;
        if (all > 0) set_filled_part(data, covered < 1 ? (all - covered) / (1 - covered) : 1.0f);
        return data;
    }

    Work expected_work() const { return {.splats = 1}; }
    /// Contents without an area must not vanish, so their stand-in is never worth it.
    Work work(const stand_in_data& data) const {
        if (filled_part(data) == 0) return {.splats = std::numeric_limits<float>::infinity()};
        return expected_work();
    }
    bool is_sound(const stand_in_data& data) const { return data[5].a == 0; }

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
        const float outline = outline_of(cell.half / unit, direction_of(view.towards_viewer(center_in(data, cell))));
        const float area = filled_part(data) * part * part;
        return outline > area ? area / outline : 1.0f;
    }
    /// As one face of a cube, of one color and in one place.
    float expected_rmse(float side_px, float covered) const { return cube_rmse(side_px, covered); }

    /// One splat, or the faces that are seen where the renderer has none.
    template <class Sink>
    void draw_stand_in(const stand_in_data& data, const Cell& cell, const LocalView& view, Sink&& sink) const {
        const float part = filled_part(data);
        if (part == 0) return;
        const VisibleFaces seen(cell, view);
        const float shrunk = size == Size::of_areas ? std::sqrt(part) : 1.0f;
        const glm::vec3 center = center_in(data, cell);
        if (!(sink.splat_limit_px > 0)) {
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
        sink(Splat{
            center, glm::vec2(cell.largest_side() * shrunk * std::sqrt(view.stretch(center))), 1,
            Rgba8{std::uint8_t(rgb.x), std::uint8_t(rgb.y), std::uint8_t(rgb.z), std::uint8_t(AreaLaw::coherent)}});
    }

  private:
    ColorCube colors() const { return {.samples = samples}; }
    static void set_filled_part(stand_in_data& data, float part) {
        const auto steps = std::max(unsigned(part * 65535 + 0.5f), 1u);  // 0 is nothing
        data[3].a = std::uint8_t(steps >> 8);
        data[4].a = std::uint8_t(steps & 255);
    }
    static float filled_part(const stand_in_data& data) {
        return float(unsigned(data[3].a) << 8 | data[4].a) * (1.0f / 65535);
    }
    static glm::vec3 center_in(const stand_in_data& data, const Cell& cell) {
        const glm::vec3 place = glm::vec3(data[0].a, data[1].a, data[2].a) * (2.0f / 255) - 1.0f;
        return cell.bounds_center + place * cell.bounds_half;
    }
};

}  // namespace farfield
