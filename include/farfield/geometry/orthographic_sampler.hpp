// Looking at a part of a scene through the six sides of a box: what colors of cells are made from.
//
// "A color-cube is created by rendering its list of associated primitives to the screen, using an orthographic
// projection through each of its six faces" (Chamberlain et al. 1996, section 4). A user's renderer can do that by
// modeling OrthographicSampler; GridSampler is the one built in.
#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "farfield/geometry/box.hpp"
#include "farfield/geometry/light.hpp"
#include "farfield/geometry/polygon.hpp"

namespace farfield {

/// n x n point samples through each side of a box. With more than one slab the box is cut into as many slices along
/// the viewing axis, each seen by itself.
struct SampleGrid {
    Box box;
    unsigned n = 4;
    unsigned slabs = 1;

    /// Samples lie at [side][slab][v][u]: side 0..5 is seen from -x, +x, -y, +y, -z, +z; u and v run along the two axes
    /// after the side's own, in cyclic order, upwards from the lower corner; slabs run upwards too.
    std::size_t size() const { return std::size_t(6) * slabs * n * n; }
    std::size_t index(unsigned side, unsigned slab, unsigned v, unsigned u) const {
        return ((std::size_t(side) * slabs + slab) * n + v) * n + u;
    }
};

namespace archetype {
struct VisitPolygons {
    template <class Sink>
    void operator()(Sink&& sink) const {
        sink(Polygon{});
    }
};
}  // namespace archetype

/// sample(grid, visit, out): `visit(sink)` calls sink(Polygon) for every polygon that may touch the box; parts outside
/// the box are not seen. `out` has grid.size() elements and gets premultiplied colors, all zero where nothing is seen.
/// Copyable, for every build thread has one of its own; equal input must give equal output.
template <class S>
concept OrthographicSampler = std::copyable<S> &&
    requires(S& s, const SampleGrid& grid, archetype::VisitPolygons visit, std::span<Rgba8> out) {
    s.sample(grid, visit, out);
};

/// Point samples at the centers of the grid's squares, vertices snapped to 1/256 of a square, shared edges covered
/// once. The nearest polygon from each side wins; of two at one depth the first.
class GridSampler {
  public:
    std::optional<DirectionalLight> light;

    GridSampler() = default;
    explicit GridSampler(const DirectionalLight& l) : light(l) {}

    template <class Visit>
    void sample(const SampleGrid& grid, Visit&& visit, std::span<Rgba8> out) {
        std::fill(out.begin(), out.end(), Rgba8{0, 0, 0, 0});
        depth_.resize(grid.size());
        visit([&](const Polygon& polygon) {
            const bool one_color = polygon.colors.size() < polygon.vertices.size();
            for (std::size_t i = 2; i < polygon.vertices.size(); ++i) {
                const std::size_t corner[3] = {0, i - 1, i};
                Corner corners[3];
                for (int c = 0; c < 3; ++c) {
                    corners[c] = {polygon.vertices[corner[c]], polygon.colors[one_color ? 0 : corner[c]]};
                }
                for (unsigned axis = 0; axis < 3; ++axis) scan(grid, axis, corners, one_color, out);
            }
        });
    }

  private:
    struct Corner {
        glm::vec3 position;
        Rgba8 color;
    };
    struct Snapped {
        std::int64_t u, v;
    };

    static std::int64_t snapped(float p, float lower, float squares_per_unit) {
        const float s = (p - lower) * squares_per_unit * 256.0f;
        constexpr float reach = 0x1p30f;  // products of two stay below 2^62
        return std::int64_t(std::floor(glm::clamp(s, -reach, reach) + 0.5f));
    }

    void scan(const SampleGrid& grid, unsigned axis, const Corner (&corners)[3], bool one_color, std::span<Rgba8> out) {
        const int a = int(axis), ua = (a + 1) % 3, va = (a + 2) % 3;
        const glm::vec3 size = grid.box.size();
        if (!(size[ua] > 0 && size[va] > 0)) return;
        const float n = float(grid.n);
        Snapped p[3];
        float depth[3];
        for (int i = 0; i < 3; ++i) {
            p[i] = {snapped(corners[i].position[ua], grid.box.lower[ua], n / size[ua]),
                    snapped(corners[i].position[va], grid.box.lower[va], n / size[va])};
            depth[i] = corners[i].position[a];
        }
        const auto range = [&](std::int64_t Snapped::*c, int& first, int& last) {
            const auto [low, high] = std::minmax({p[0].*c, p[1].*c, p[2].*c});
            first = int(std::max<std::int64_t>((low + 127) >> 8, 0));
            last = int(std::min<std::int64_t>((high - 128) >> 8, std::int64_t(grid.n) - 1));
        };
        int u0, u1, v0, v1;
        range(&Snapped::u, u0, u1);
        range(&Snapped::v, v0, v1);
        if (u0 > u1 || v0 > v1) return;  // no sample in the bounding box: most triangles of a large cell
        std::int64_t doubled_area = (p[1].u - p[0].u) * (p[2].v - p[0].v) - (p[2].u - p[0].u) * (p[1].v - p[0].v);
        if (doubled_area == 0) return;

        // Counter-clockwise about the axis: the front looks along it.
        const bool front_looks_up = doubled_area > 0;
        int order[3] = {0, 1, 2};
        if (!front_looks_up) {
            std::swap(order[1], order[2]);
            doubled_area = -doubled_area;
        }
        float brightness[2] = {1, 1};  // seen from below, from above
        if (light) {
            const glm::vec3 normal =
                glm::cross(corners[1].position - corners[0].position, corners[2].position - corners[0].position);
            brightness[front_looks_up ? 1 : 0] = light->brightness(normal);
            brightness[front_looks_up ? 0 : 1] = light->brightness(-normal);
        }
        const auto edge = [&](int from, int to, std::int64_t u, std::int64_t v) {
            const Snapped& f = p[order[from]];
            const Snapped& t = p[order[to]];
            const std::int64_t du = t.u - f.u, dv = t.v - f.v;
            // A sample on an edge belongs to one of the two triangles that share it.
            const std::int64_t bias = (dv < 0 || (dv == 0 && du > 0)) ? 0 : -1;
            return du * (v - f.v) - dv * (u - f.u) + bias;
        };
        const auto [low_depth, high_depth] = std::minmax({depth[0], depth[1], depth[2]});
        for (int v = v0; v <= v1; ++v) {
            for (int u = u0; u <= u1; ++u) {
                const std::int64_t su = std::int64_t(u) * 256 + 128, sv = std::int64_t(v) * 256 + 128;
                const std::int64_t e0 = edge(1, 2, su, sv), e1 = edge(2, 0, su, sv), e2 = edge(0, 1, su, sv);
                if ((e0 | e1 | e2) < 0) continue;
                const float inverse = 1.0f / float(doubled_area);
                const float w1 = float(e1) * inverse, w2 = float(e2) * inverse, w0 = 1.0f - w1 - w2;
                const float d = glm::clamp(w0 * depth[order[0]] + w1 * depth[order[1]] + w2 * depth[order[2]],
                                           low_depth, high_depth);
                if (d < grid.box.lower[a] || d > grid.box.upper[a]) continue;
                Rgba8 color = corners[0].color;
                if (!one_color) {
                    color = to_rgba8(to_vec4(corners[order[0]].color) * w0 + to_vec4(corners[order[1]].color) * w1 +
                                     to_vec4(corners[order[2]].color) * w2);
                }
                if (color.a == 0) continue;
                unsigned slab = 0;
                if (grid.slabs > 1) {
                    const float s = (d - grid.box.lower[a]) * (float(grid.slabs) / size[a]);
                    slab = unsigned(glm::clamp(s, 0.0f, float(grid.slabs - 1)));
                }
                keep(grid, 2 * axis, slab, unsigned(v), unsigned(u), d, scaled(color, brightness[0]), out);
                keep(grid, 2 * axis + 1, slab, unsigned(v), unsigned(u), -d, scaled(color, brightness[1]), out);
            }
        }
    }

    void keep(const SampleGrid& grid, unsigned side, unsigned slab, unsigned v, unsigned u, float depth, Rgba8 color,
              std::span<Rgba8> out) {
        const std::size_t i = grid.index(side, slab, v, u);
        if (out[i].a != 0 && depth_[i] <= depth) return;
        depth_[i] = depth;
        out[i] = color.a == 255 ? color : premultiplied(color);
    }
    static Rgba8 premultiplied(Rgba8 c) {
        const auto part = [&](std::uint8_t v) { return std::uint8_t((unsigned(v) * c.a + 127) / 255); };
        return {part(c.r), part(c.g), part(c.b), c.a};
    }

    std::vector<float> depth_;
};

}  // namespace farfield
