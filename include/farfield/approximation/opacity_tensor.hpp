// A cell as a tensor of its surfaces' areas: how much of them is seen from any direction, which six faces cannot say.
//
// Six opaque faces seen off their axes are too large ("the color-cube ... tends to be larger", Chamberlain et al. 1995,
// section 5) and tear apart where each is only partly covered. The sums T = sum A n n^T over areas A with unit normals
// n give the projected area sqrt(W w^T T w) (W = sum A) towards a unit vector w: exactly for one flat piece, and
// rescaled to the mean of Cauchy's formula (W / 2 over all directions) within a few per cent for most else. It is the
// form of Heitz et al. 2015 ("SGGX"). Sums are merged by adding them; only what is stored is rescaled.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <span>
#include <vector>

#include "farfield/approximation/axis_masks.hpp"
#include "farfield/approximation/cell_faces.hpp"
#include "farfield/approximation/packed_tensor.hpp"
#include "farfield/geometry/clip_to_box.hpp"
#include "farfield/policy.hpp"

namespace farfield {

/// What of a cell's contents adds up: areas, and what is weighted by them. Areas are weighted by alpha.
struct AreaSums {
    std::array<float, 6> tensor{};  ///< sum of A n n^T: xx, yx, zx, yy, zy, zz
    float area = 0;
    float opaque_area = 0;    ///< the same with every alpha 1
    glm::vec3 normal{0};      ///< sum of A n
    glm::vec3 along_axes{0};  ///< sum of A |n|: what is seen along each axis if nothing overlaps
    glm::vec3 moment{0};      ///< sum of A times the centroid's distance from the cell's center
    glm::vec3 color{0};       ///< sum of A times the mean color of both sides, or of the front if surfaces are closed
    glm::vec3 tone{0};        ///< sum of A n times half of the luminance that the front has more than the back; if
                              ///< surfaces are closed, times the front's

    AreaSums& operator+=(const AreaSums& o) {
        for (std::size_t i = 0; i < 6; ++i) tensor[i] += o.tensor[i];
        area += o.area;
        opaque_area += o.opaque_area;
        normal += o.normal;
        along_axes += o.along_axes;
        moment += o.moment;
        color += o.color;
        tone += o.tone;
        return *this;
    }
};

/// One tensor a cell. 16 bytes.
struct OpacityTensor {
    /// Surfaces are closed and counter-clockwise seen from outside: back sides are not counted, for something hides
    /// them. Goes with a renderer that culls back faces.
    bool closed_surfaces = false;
    /// The part of the contents' outline that the square has in which they are strewn, unless they need more.
    float footprint = 0.4f;

    struct draft {
        AreaSums sums;
        Box contents = Box::empty();
        AxisMasks masks;
    };
    using cell_data = PackedTensor;
    struct pool_element {};
    static constexpr ApproximationFacts facts{
        .needs = needs_polygons, .stands_in = true, .bounds_error = true, .file_tag = 0x4f540001u};

    /// Masks of children nest where cells are halved.
    bool wants_all_contents(const PartitionFacts& partition) const { return !partition.halves; }

    template <class Contents, OrthographicSampler Sampler>
    draft sample(const Cell& cell, Contents&& contents, Sampler& sampler) const {
        draft d;
        const Box bounds = cell.bounds();
        contents([&](const Polygon& polygon) { add(d, cell, bounds, polygon, sampler); });
        if constexpr (!LightsPolygons<Sampler>) {
            // Its light is known from its pictures alone.
            const SampleGrid grid{bounds, 4, 1};
            std::vector<Rgba8> out(grid.size());
            sampler.sample(grid, contents, std::span<Rgba8>(out));
            glm::vec4 sum(0);
            for (const Rgba8 c : out) sum += glm::vec4(float(c.r), float(c.g), float(c.b), float(c.a));
            if (sum.a > 0) d.sums.color = glm::vec3(sum) * (255 / sum.a * d.sums.area);
        }
        return d;
    }

    void merge(const Cell& cell, draft& own, std::span<const ChildDraft<draft>> children) const {
        const Box bounds = cell.bounds();
        for (const auto& child : children) {
            AreaSums sums = child.draft->sums;
            sums.moment += sums.area * (child.cell->center - cell.center);
            own.sums += sums;
            own.contents.add(child.draft->contents);
            own.masks.add_child(bounds, child.draft->masks, child.cell->bounds());
        }
    }

    cell_data finish(const Cell& cell, const draft& d, std::vector<pool_element>&) const {
        const Fit fit(*this, cell, d);
        return fit.is_empty ? PackedTensor{} : PackedTensor(fit.shape);
    }

    Work expected_work() const { return {.splats = 1}; }
    /// What has no area must not vanish: no price is high enough.
    Work work(const cell_data& data) const {
        if (data == PackedTensor{}) return {.splats = std::numeric_limits<float>::infinity()};
        return expected_work();
    }
    AreaLaw law(const cell_data& data) const { return data.law(); }
    bool is_sound(const cell_data& data, std::span<const pool_element>) const { return data.is_sound(); }

    /// The projected side of the cell.
    float error_px(const cell_data&, const Cell& cell, const LocalView& view) const {
        return view.pixels(cell.largest_side(), view.distance_to(cell));
    }
    float least_error_px(const Cell& cell, unsigned levels, const LocalView& view) const {
        return least_projected_side(cell, levels, view);
    }

    template <class Sink>
    void stand_in(const cell_data& data, std::span<const pool_element>, const Cell& cell, const LocalView& view,
                  Sink&& sink) const {
        const TensorShape s = data.unpacked();
        const float unit = 2 * cell.bounds_half.x;
        const glm::vec3 center = cell.bounds_center - cell.bounds_half + s.center * unit;
        const glm::vec3 d = view.towards_viewer(center);
        const glm::vec3 w = d * (1 / std::sqrt(glm::dot(d, d)));
        const glm::vec3 u = s.seen_from(w);
        float area = std::sqrt(glm::dot(u, u));
        if (!(area > 0)) return;
        float tone = glm::max(1 + glm::dot(s.tone, w) / area, 0.0f);
        if (closed_surfaces) {
            const float fronts = 1 + glm::clamp(glm::dot(s.facing, w) / area, -1.0f, 1.0f);
            if (fronts < 0.04f) return;
            tone = std::min(tone / fronts, 2.0f);
            area *= 0.5f * fronts;
        }
        const glm::vec3 rgb = glm::min(s.rgb * tone, glm::vec3(255));
        const glm::vec3 e = s.extent;
        const float outline = std::abs(w.x) * e.y * e.z + std::abs(w.y) * e.z * e.x + std::abs(w.z) * e.x * e.y;
        const float covered = outline * (1 - transmitted(1, area / outline, s.law));
        if (!(covered > 0)) return;
        const float square = s.law == AreaLaw::coherent ? covered : std::max(covered, footprint * outline);
        sink(Splat{center, square * unit * unit, covered / square,
                   Rgba8{std::uint8_t(rgb.r + 0.5f), std::uint8_t(rgb.g + 0.5f), std::uint8_t(rgb.b + 0.5f),
                         std::uint8_t(s.law)}});
    }

    template <class Sink>
    void polygons(const cell_data& data, std::span<const pool_element>, const Cell& cell, Sink&& sink) const {
        (void)data, (void)cell, (void)sink;
    }

  private:
    template <class Sampler>
    void add(draft& d, const Cell& cell, const Box& bounds, const Polygon& polygon, const Sampler& sampler) const {
        const bool one_color = polygon.colors.size() < polygon.vertices.size();
        for (std::size_t i = 2; i < polygon.vertices.size(); ++i) {
            const glm::vec3 corners[3] = {polygon.vertices[0], polygon.vertices[i - 1], polygon.vertices[i]};
            const glm::vec4 color =
                one_color ? to_vec4(polygon.colors[0])
                          : (to_vec4(polygon.colors[0]) + to_vec4(polygon.colors[i - 1]) + to_vec4(polygon.colors[i])) *
                                (1.0f / 3);
            Box box{corners[0], corners[0]};
            box.add(corners[1]);
            box.add(corners[2]);
            if (bounds.contains(box.lower) && bounds.contains(box.upper)) {
                add(d, cell, bounds, corners, polygon, color, sampler);
                continue;
            }
            const ClippedTriangle inside(bounds, corners);
            const std::span<const glm::vec3> left = inside.corners();
            for (std::size_t k = 2; k < left.size(); ++k) {
                const glm::vec3 part[3] = {left[0], left[k - 1], left[k]};
                add(d, cell, bounds, part, polygon, color, sampler);
            }
        }
    }

    template <class Sampler>
    void add(draft& d, const Cell& cell, const Box& bounds, const glm::vec3 (&corners)[3], const Polygon& polygon,
             glm::vec4 color, const Sampler& sampler) const {
        const glm::vec3 doubled = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
        const float length = std::sqrt(glm::dot(doubled, doubled));
        if (!(length > 0)) return;
        const glm::vec3 n = doubled / length;
        const float opaque_area = 0.5f * length, area = opaque_area * color.a;
        for (const glm::vec3 p : corners) d.contents.add(p);
        d.masks.add(bounds, corners);
        AreaSums& s = d.sums;
        s.tensor[0] += area * n.x * n.x;
        s.tensor[1] += area * n.y * n.x;
        s.tensor[2] += area * n.z * n.x;
        s.tensor[3] += area * n.y * n.y;
        s.tensor[4] += area * n.z * n.y;
        s.tensor[5] += area * n.z * n.z;
        s.area += area;
        s.opaque_area += opaque_area;
        s.normal += area * n;
        s.along_axes += area * glm::abs(n);
        s.moment +=
            area * ((corners[0] - cell.center) + (corners[1] - cell.center) + (corners[2] - cell.center)) * (1.0f / 3);
        float front = 1, back = 1;
        if constexpr (LightsPolygons<Sampler>) {
            front = sampler.brightness(polygon, n);
            back = closed_surfaces ? front : sampler.brightness(polygon, -n);
        }
        const glm::vec3 rgb = glm::vec3(color) * 255.0f;
        s.color += area * (0.5f * (front + back)) * rgb;
        s.tone += area * (closed_surfaces ? front : 0.5f * (front - back)) * luminance(rgb) * n;
    }

    static float luminance(glm::vec3 rgb) { return glm::dot(rgb, glm::vec3(0.2126f, 0.7152f, 0.0722f)); }

    /// From sums to what is stored.
    struct Fit {
        TensorShape shape;
        bool is_empty = true;

        Fit(const OpacityTensor& options, const Cell& cell, const draft& d) {
            const AreaSums& sums = d.sums;
            const float unit = 2 * cell.bounds_half.x;
            if (!(sums.area > 0) || !(unit > 0)) return;
            is_empty = false;
            const glm::vec3 size = d.contents.size() * (1 / unit);
            shape.extent = glm::clamp(size, 1.0f / 32, 1.0f);
            shape.center = (cell.center + sums.moment / sums.area - (cell.bounds_center - cell.bounds_half)) / unit;
            shape.rgb = sums.color / sums.area;
            const float per_unit = 1 / (unit * unit);
            const float area = sums.area * per_unit, alpha = sums.area / sums.opaque_area;
            const glm::vec3 seen = sums.along_axes * (per_unit * (options.closed_surfaces ? 0.5f : 1.0f));
            constexpr float sample = 1.0f / (AxisMasks::side * AxisMasks::side);
            glm::vec3 outline, covered;
            for (int axis = 0; axis < 3; ++axis) {
                outline[axis] = shape.extent[(axis + 1) % 3] * shape.extent[(axis + 2) % 3];
                covered[axis] = float(d.masks.count(axis)) * sample * alpha;
            }
            shape.law = law_of(seen, outline, covered);
            glm::vec3 kept;
            for (int axis = 0; axis < 3; ++axis) {
                const float opacity = std::min(covered[axis] / outline[axis], 1 - 0.5f * sample / outline[axis]);
                const float fitting = area_of(opacity, shape.law) * outline[axis];
                constexpr float prior = 4 * sample;
                kept[axis] = std::min((fitting + prior) / (seen[axis] + prior), 1.25f);
                if (shape.law == AreaLaw::coherent && opacity > 0.9f) kept[axis] = std::max(kept[axis], 1.0f);
            }
            std::array<float, 6> t = sums.tensor;
            for (float& v : t) v *= per_unit * area;
            const float cauchy = 0.5f * area / mean_area(root_of(t));
            const std::array<int, 6> row{0, 1, 2, 1, 2, 2}, column{0, 0, 0, 1, 1, 2};
            for (std::size_t i = 0; i < 6; ++i) t[i] *= cauchy * cauchy * kept[row[i]] * kept[column[i]];
            shape.root = root_of(t);
            if (options.closed_surfaces) shape.facing = sums.normal * per_unit * kept;
            if (luminance(shape.rgb) > 0) shape.tone = sums.tone * (per_unit / luminance(shape.rgb)) * kept;
        }

        /// That which tells best what the masks saw, where there is enough to tell.
        static AreaLaw law_of(glm::vec3 seen, glm::vec3 outline, glm::vec3 covered) {
            AreaLaw best = AreaLaw::independent;
            float least = std::numeric_limits<float>::infinity();
            for (const AreaLaw law : {AreaLaw::independent, AreaLaw::mixed, AreaLaw::coherent}) {
                float sum = 0;
                for (int axis = 0; axis < 3; ++axis) {
                    const float off =
                        1 - transmitted(1, seen[axis] / outline[axis], law) - covered[axis] / outline[axis];
                    sum += outline[axis] * off * off;
                }
                if (sum < least) {
                    least = sum;
                    best = law;
                }
            }
            return best;
        }

        /// What leaves 1 - opacity by a law.
        static float area_of(float opacity, AreaLaw law) {
            switch (law) {
                case AreaLaw::coherent:
                    return opacity;
                case AreaLaw::mixed:
                    return -2 * std::log(1 - 0.5f * opacity);
                case AreaLaw::independent:
                    return -std::log(1 - opacity);
            }
            return opacity;
        }

        /// Cholesky: L L^T of a tensor that may be singular.
        static std::array<float, 6> root_of(const std::array<float, 6>& t) {
            std::array<float, 6> l{};
            l[0] = std::sqrt(std::max(t[0], 0.0f));
            if (l[0] > 0) l[1] = t[1] / l[0], l[2] = t[2] / l[0];
            // A pivot that is rounding is none.
            const auto pivot = [](float rest, float of) { return rest > 1e-5f * of ? std::sqrt(rest) : 0.0f; };
            l[3] = pivot(t[3] - l[1] * l[1], t[3]);
            if (l[3] > 0) l[4] = (t[4] - l[2] * l[1]) / l[3];
            l[5] = pivot(t[5] - l[2] * l[2] - l[4] * l[4], t[5]);
            return l;
        }

        /// Over all directions.
        static float mean_area(const std::array<float, 6>& root) {
            constexpr int count = 64;
            static const auto directions = [] {
                std::array<glm::vec3, count> all;
                for (int i = 0; i < count; ++i) {
                    const float z = (float(i) + 0.5f) / count, r = std::sqrt(1 - z * z);
                    const float turn = 2.39996323f * float(i);
                    all[std::size_t(i)] = {r * std::cos(turn), r * std::sin(turn), z};
                }
                return all;
            }();
            TensorShape shape;
            shape.root = root;
            float sum = 0;
            for (const glm::vec3 w : directions) {
                const glm::vec3 u = shape.seen_from(w);
                sum += std::sqrt(glm::dot(u, u));
            }
            return sum * (1.0f / count);
        }
    };
};

}  // namespace farfield
