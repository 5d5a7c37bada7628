// K x K x K color cubes in each cell, kept as six lists of faces (Chamberlain et al. 1995, sections 4.2 and 6.2).
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "farfield/approximation.hpp"
#include "farfield/approximation/cell_faces.hpp"

namespace farfield {

/// "The same overall effect as a deeper octree, but results in less overhead ... the disadvantage of clustering is that
/// all cubes within a cluster will be drawn at the same size." A face takes six bytes: its place in the cluster and a
/// color. Only lists whose faces look at the viewer are read. Every cluster is made from the primitives themselves.
///
/// Along a side of the cell lie K cubes; where the cell is loose, the cluster grows with its bounds.
template <unsigned K>
requires(K >= 1 && K <= 16) struct ColorCubeCluster {
    /// Orthographic samples along a side of each small cube, 1 to 8. A cube's colors see what lies in its own slab.
    std::uint32_t samples = 2;
    /// Faces of which no more than this is covered are not kept: "small isolated details in the original scene are
    /// magnified to inappropriately large sizes" (1995, section 4.1).
    float coverage_threshold = 1.0f / 64;

    struct pool_element {
        std::uint16_t place;      ///< five bits each for x, y, z in the cluster
        std::uint8_t r, g, b, a;  ///< premultiplied
    };
    static_assert(sizeof(pool_element) == 6);
    struct stand_in_data {
        std::uint32_t first;                 ///< in the pool; the six lists follow one another
        std::array<std::uint16_t, 6> count;  ///< of faces that look to -x, +x, -y, +y, -z, +z
    };
    using stand_in_draft = std::array<std::vector<pool_element>, 6>;
    static constexpr ApproximationFacts facts{.needs_polygons = true,
                                              .stands_in = true,
                                              .has_pool = true,
                                              .bounds_error = true,
                                              .expects_error = true,
                                              .file_tag = 0x43430100u + K};

    const char* wrong_option() const {
        if (samples < 1 || samples > 8) return "ColorCubeCluster: samples must be from 1 to 8";
        return coverage_threshold >= 0 && coverage_threshold <= 1
                   ? nullptr
                   : "ColorCubeCluster: coverage_threshold must lie between 0 and 1";
    }

    template <class Contents, OrthographicSampler Sampler>
    stand_in_draft sample(const Cell& cell, Contents&& contents, Sampler& sampler) const {
        stand_in_draft faces;
        const unsigned cubes = cubes_a_side(cell);
        const SampleGrid grid{cell.bounds(), cubes * samples, cubes};
        thread_local std::vector<Rgba8> out;
        out.resize(grid.size());
        sampler.sample(grid, contents, std::span<Rgba8>(out));
        const float weight = 1.0f / float(samples * samples);
        for (unsigned side = 0; side < 6; ++side) {
            for (unsigned slab = 0; slab < cubes; ++slab) {
                for (unsigned v = 0; v < cubes; ++v) {
                    for (unsigned u = 0; u < cubes; ++u) {
                        glm::vec4 sum(0);
                        for (unsigned i = 0; i < samples * samples; ++i) {
                            const Rgba8 c =
                                out[grid.index(side, slab, v * samples + i / samples, u * samples + i % samples)];
                            sum += glm::vec4(float(c.r), float(c.g), float(c.b), float(c.a));
                        }
                        sum *= weight * (1.0f / 255);
                        if (sum.w <= coverage_threshold) continue;
                        std::array<unsigned, 3> place{};
                        place[side / 2] = slab;
                        place[(side / 2 + 1) % 3] = u;
                        place[(side / 2 + 2) % 3] = v;
                        const Rgba8 c = to_rgba8(sum);
                        faces[side].push_back(
                            {std::uint16_t(place[0] | place[1] << 5 | place[2] << 10), c.r, c.g, c.b, c.a});
                    }
                }
            }
        }
        return faces;
    }

    stand_in_data finish(const Cell&, const stand_in_draft& d, std::vector<pool_element>& pool) const {
        stand_in_data data{std::uint32_t(pool.size()), {}};
        for (unsigned side = 0; side < 6; ++side) {
            data.count[side] = std::uint16_t(d[side].size());
            pool.insert(pool.end(), d[side].begin(), d[side].end());
        }
        return data;
    }

    /// The work of a surface through the cell: K x K cubes, seen on one side or another.
    Work expected_work() const { return {.splats = float(K * K)}; }
    /// Half of the faces look at the viewer. Contents that no sample met must not vanish, so their stand-in is never
    /// worth it.
    Work work(const stand_in_data& data) const {
        float faces = 0;
        for (const std::uint16_t n : data.count) faces += float(n);
        if (faces == 0) return {.splats = std::numeric_limits<float>::infinity()};
        return {.splats = 0.5f * faces};
    }

    /// The projected side of one small cube.
    float error_px(const stand_in_data&, const Cell& cell, const LocalView& view) const {
        return view.pixels(cell.largest_side() / K, view.distance_to(cell));
    }
    float least_error_px(const Cell& cell, unsigned levels, const LocalView& view) const {
        return least_projected_side(cell, levels, view) / K;
    }

    /// Slabs hide one another as independent things do.
    float covered_part(const stand_in_data& data, std::span<const pool_element> pool, const Cell& cell,
                       const LocalView& view) const {
        const VisibleFaces faces(cell, view);
        constexpr float per_cube = 1.0f / float(K * K);  // of a side of the cell, however many lie beyond it
        std::array<float, 6> opacity{};
        std::size_t at = data.first;
        for (unsigned side = 0; side < 6; ++side) {
            unsigned sum = 0;
            for (const pool_element& e : pool.subspan(at, data.count[side])) sum += e.a;
            opacity[side] = float(sum) * per_cube * (1.0f / 255);
            at += data.count[side];
        }
        float areas = 0, outline = 0;
        for (std::size_t i = 0; i < std::size_t(faces.count); ++i) {
            areas += faces.projected[i] * opacity[faces.side[i]];
            outline += faces.projected[i];
        }
        // Contents that no sample met may take half of the room of one.
        const float unseen = 0.5f * per_cube / float(samples * samples);
        return outline > 0 ? std::max(areas / (outline + areas), unseen) : 1.0f;
    }
    /// Of a cube that is as large: the smaller cubes are made from fewer samples each, and gaps between them show.
    float expected_rmse(float side_px, float covered) const { return 0.6f * cube_rmse(side_px, covered); }

    /// Whether no list leaves the pool, as it might in a file.
    bool is_sound(const stand_in_data& data, std::span<const pool_element> pool) const {
        std::uint64_t end = data.first;
        for (const std::uint16_t n : data.count) end += n;
        return end <= pool.size();
    }

    template <class Sink>
    void polygons(const stand_in_data& data, std::span<const pool_element> pool, const Cell& cell, Sink&& sink) const {
        for (unsigned side = 0; side < 6; ++side) {
            for_faces(data, pool, cell, side,
                      [&](const Cell& cube, Rgba8 c) { emit_polygon(face_of(cube, side, c), sink); });
        }
    }

    template <class Sink>
    void draw_stand_in(const stand_in_data& data, std::span<const pool_element> pool, const Cell& cell,
                       const LocalView& view, Sink&& sink) const {
        const bool splats = is_small(cell.center, cell.largest_side() / K, view, sink.splat_limit_px);
        for (unsigned side = 0; side < 6; ++side) {
            for_faces(data, pool, cell, side, [&](const Cell& cube, Rgba8 c) {
                const glm::vec3 towards = view.towards_viewer(cube.center);
                const float along = side & 1 ? towards[int(side / 2)] : -towards[int(side / 2)];
                if (!(along > (view.is_perspective ? cube.half[int(side / 2)] : 0.0f))) return;
                if (!splats) return sink(face_of(cube, side, c));
                const float unit = length_unit(cube);
                const glm::vec3 half = cube.half * (1 / unit);
                const float footprint =
                    4 * half[(int(side / 2) + 1) % 3] * half[(int(side / 2) + 2) % 3] * along / length_of(towards);
                const glm::vec4 color(float(c.r), float(c.g), float(c.b), float(c.a));
                // Of a cube that is all but flat the area may vanish.
                if (c.a != 0 && footprint > 0) {
                    sink(splat_of(cube.center, footprint, unit, color * footprint, view));
                }
            });
        }
    }

  private:
    static unsigned cubes_a_side(const Cell& cell) {
        const float looseness = cell.half.x > 0 ? cell.bounds_half.x / cell.half.x : 1.0f;
        return unsigned(std::min(std::ceil(float(K) * looseness), 32.0f));
    }

    template <class F>
    static void for_faces(const stand_in_data& data, std::span<const pool_element> pool, const Cell& cell,
                          unsigned side, F&& f) {
        std::size_t first = data.first;
        for (unsigned s = 0; s < side; ++s) first += data.count[s];
        const float size = 1.0f / float(cubes_a_side(cell));
        Cell cube = cell;
        cube.half = cell.bounds_half * size;
        const glm::vec3 corner = cell.bounds_center - cell.bounds_half + cube.half;
        for (const pool_element& e : pool.subspan(first, data.count[side])) {
            const glm::vec3 place(float(e.place & 31), float(e.place >> 5 & 31), float(e.place >> 10 & 31));
            cube.center = corner + place * (2.0f * cube.half);
            f(std::as_const(cube), Rgba8{e.r, e.g, e.b, e.a});
        }
    }
};

}  // namespace farfield
