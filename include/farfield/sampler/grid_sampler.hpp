// The built-in sampler takes point samples on a grid, from each side of a box.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "farfield/geometry/box.hpp"
#include "farfield/geometry/length.hpp"
#include "farfield/geometry/light.hpp"
#include "farfield/geometry/polygon.hpp"
#include "farfield/sampler.hpp"

namespace farfield {

/// Samples lie at the centers of the grid's squares; vertices are snapped to 1/256 of a square, and shared edges are
/// covered once. The nearest polygon from each side wins; of two at one depth the first.
class GridSampler {
  public:
    std::optional<DirectionalLight> light;

    GridSampler() = default;
    GridSampler(const DirectionalLight& l)  // NOLINT(google-explicit-constructor): a light is all it needs
        : light(l) {}

    const char* wrong_option() const { return light ? wrong_light(*light) : nullptr; }

    /// The factor that the light gives to colors of the side with this normal (any length).
    float brightness(const Polygon& polygon, glm::vec3 facing_viewer) const {
        return brightness_of(light, polygon, facing_viewer);
    }

    template <class Visit>
    void sample(const SampleGrid& grid, Visit&& visit, std::span<Rgba8> out) {
        const unsigned met = sample_met(grid, visit, out);
        for (unsigned axis = 0; axis < 3; ++axis) {
            if ((met >> axis & 1) == 0) clear(grid, axis, out);
        }
    }
    /// The same, but for the sides along axes that no polygon may be seen along, which are left as they are. Returns a
    /// bit for each of the others. What is flat is seen along one axis, and its cell has few polygons.
    template <class Visit>
    unsigned sample_met(const SampleGrid& grid, Visit&& visit, std::span<Rgba8> out) {
        met_ = 0;
        depth_.resize(grid.size());
        const glm::vec3 size = grid.box.size();
        for (int axis = 0; axis < 3; ++axis) {
            steps_per_unit_[axis] = size[axis] > 0 ? float(grid.n) * 256 / size[axis] : 0.0f;
        }
        visit([&](const Polygon& polygon) {
            const bool one_color = polygon.colors.size() < polygon.vertices.size();
            for (std::size_t i = 2; i < polygon.vertices.size(); ++i) {
                const std::size_t corner[3] = {0, i - 1, i};
                Corners corners;
                for (unsigned c = 0; c < 3; ++c) {
                    corners.position[c] = polygon.vertices[corner[c]];
                    corners.color[c] = polygon.colors[one_color ? 0 : corner[c]];
                }
                corners.one_color =
                    one_color || (corners.color[0] == corners.color[1] && corners.color[0] == corners.color[2]);
                corners.is_lit = polygon.is_lit;
                add(grid, corners, out);
            }
        });
        return met_;
    }

  private:
    struct Corners {
        glm::vec3 position[3];
        Rgba8 color[3];
        bool one_color, is_lit;
        std::int32_t at[3][3];  ///< [axis][corner], 1/256 square from the lower corner of the box
        int first[3], last[3];  ///< by axis, of the samples inside the bounding box
    };

    void add(const SampleGrid& grid, Corners& c, std::span<Rgba8> out) {
        // Adding 1.5 * 2^23 rounds, exactly below 2^22; triangles thousands of squares large are clamped there, which
        // bends their edges far outside the box.
        constexpr float rounder = 12582912.0f, reach = 0x1p21f;
        bool products_fit_32_bits = true;
        for (int axis = 0; axis < 3; ++axis) {
            std::int32_t* at = c.at[axis];
            for (int i = 0; i < 3; ++i) {
                const float s = (c.position[i][axis] - grid.box.lower[axis]) * steps_per_unit_[axis];
                at[i] = std::bit_cast<std::int32_t>(glm::clamp(s, -reach, reach) + rounder) - 0x4b400000;
                products_fit_32_bits = products_fit_32_bits && -0x2000 < at[i] && at[i] < 0x2000;
            }
            c.first[axis] = std::max((std::min(std::min(at[0], at[1]), at[2]) + 127) >> 8, 0);
            c.last[axis] = std::min((std::max(std::max(at[0], at[1]), at[2]) - 128) >> 8, int(grid.n) - 1);
        }
        for (int axis = 0; axis < 3; ++axis) {
            const int u = (axis + 1) % 3, v = (axis + 2) % 3;
            if (c.first[u] > c.last[u] || c.first[v] > c.last[v]) continue;  // holds no sample: most do not
            products_fit_32_bits ? scan<std::int32_t>(grid, axis, c, out) : scan<std::int64_t>(grid, axis, c, out);
        }
    }

    /// Int must hold twice the area of a triangle: 2^28 where coordinates stay below 2^13.
    template <class Int>
    void scan(const SampleGrid& grid, int a, const Corners& c, std::span<Rgba8> out) {
        const int ua = (a + 1) % 3, va = (a + 2) % 3;
        const std::int32_t *u = c.at[ua], *v = c.at[va];
        Int doubled_area = Int(u[1] - u[0]) * (v[2] - v[0]) - Int(u[2] - u[0]) * (v[1] - v[0]);
        if (doubled_area == 0) return;
        if ((met_ >> a & 1) == 0) {
            met_ |= 1u << a;
            clear(grid, unsigned(a), out);
        }
        // Counter-clockwise about the axis: the front looks along it.
        const bool front_looks_up = doubled_area > 0;
        const int k[3] = {0, front_looks_up ? 1 : 2, front_looks_up ? 2 : 1};
        if (!front_looks_up) doubled_area = -doubled_area;

        Int edge[3], by_u[3], by_v[3];
        for (int i = 0; i < 3; ++i) {
            const int from = k[(i + 1) % 3], to = k[(i + 2) % 3];
            const Int du = u[to] - u[from], dv = v[to] - v[from];
            // A sample on an edge belongs to one of the two triangles that share it.
            const Int bias = (dv < 0 || (dv == 0 && du > 0)) ? 0 : -1;
            edge[i] =
                du * (Int(c.first[va]) * 256 + 128 - v[from]) - dv * (Int(c.first[ua]) * 256 + 128 - u[from]) + bias;
            by_u[i] = -dv * 256;
            by_v[i] = du * 256;
        }
        const float depth[3] = {c.position[k[0]][a], c.position[k[1]][a], c.position[k[2]][a]};
        const float lowest = std::min(std::min(depth[0], depth[1]), depth[2]);
        const float highest = std::max(std::max(depth[0], depth[1]), depth[2]);
        const float lower = grid.box.lower[a], upper = grid.box.upper[a];
        // In a box without extent everything is in the first slab.
        const float quotient = float(grid.slabs) / (upper - lower),
                    slabs_per_unit = std::isfinite(quotient) ? quotient : 0;
        const float inverse_area = 1.0f / float(doubled_area);
        const float by_e1 = (depth[1] - depth[0]) * inverse_area, by_e2 = (depth[2] - depth[0]) * inverse_area;
        float brightness[2] = {1, 1};  // as seen from below and from above
        const bool takes_light = light && !c.is_lit;
        if (takes_light) light_sides(c, front_looks_up, brightness);
        const bool plain = c.one_color && !takes_light;
        const std::size_t squares = std::size_t(grid.n) * grid.n;
        for (int sv = c.first[va]; sv <= c.last[va]; ++sv) {
            Int e0 = edge[0], e1 = edge[1], e2 = edge[2];
            const std::size_t row = grid.index(unsigned(2 * a), 0, unsigned(sv), 0);
            for (int su = c.first[ua]; su <= c.last[ua]; ++su, e0 += by_u[0], e1 += by_u[1], e2 += by_u[2]) {
                if ((e0 | e1 | e2) < 0) continue;
                const float d = glm::clamp(depth[0] + float(e1) * by_e1 + float(e2) * by_e2, lowest, highest);
                if (d < lower || d > upper) continue;
                Rgba8 below = c.color[0], above = c.color[0];
                if (!plain) {
                    Rgba8 color = c.color[0];
                    if (!c.one_color) {
                        const float w1 = float(e1) * inverse_area, w2 = float(e2) * inverse_area;
                        color = to_rgba8(to_vec4(c.color[k[0]]) * (1 - w1 - w2) + to_vec4(c.color[k[1]]) * w1 +
                                         to_vec4(c.color[k[2]]) * w2);
                    }
                    below = scaled(color, brightness[0]);
                    above = scaled(color, brightness[1]);
                }
                unsigned slab = 0;
                if (grid.slabs > 1) {
                    slab = unsigned(glm::clamp((d - lower) * slabs_per_unit, 0.0f, float(grid.slabs - 1)));
                }
                const std::size_t at = row + slab * squares + std::size_t(su);
                keep(at, d, below, out);
                keep(at + grid.slabs * squares, -d, above, out);
            }
            for (int i = 0; i < 3; ++i) edge[i] += by_v[i];
        }
    }

    /// Both sides along an axis, which lie in a row.
    static void clear(const SampleGrid& grid, unsigned axis, std::span<Rgba8> out) {
        const std::size_t first = grid.index(2 * axis, 0, 0, 0), count = grid.size() / 3;
        std::fill_n(out.begin() + std::ptrdiff_t(first), count, Rgba8{0, 0, 0, 0});
    }

    void light_sides(const Corners& c, bool front_looks_up, float (&brightness)[2]) const {
        const glm::vec3 normal = normal_to(c.position[1] - c.position[0], c.position[2] - c.position[0]);
        brightness[front_looks_up ? 1 : 0] = light->brightness(normal);
        brightness[front_looks_up ? 0 : 1] = light->brightness(-normal);
    }

    void keep(std::size_t at, float depth, Rgba8 color, std::span<Rgba8> out) {
        if (color.a == 0 || (out[at].a != 0 && depth_[at] <= depth)) return;
        depth_[at] = depth;
        out[at] = color.a == 255 ? color : premultiplied(color);
    }

    glm::vec3 steps_per_unit_{0};
    std::vector<float> depth_;
    unsigned met_ = 0;  ///< axes that something has been sampled along, by bits
};

}  // namespace farfield
