// A cube with a color and an opacity on each of its six faces (Chamberlain et al. 1996; their 1995 form is an option).
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
#include <optional>
#include <span>
#include <vector>

#include "farfield/approximation.hpp"
#include "farfield/approximation/cell_faces.hpp"
#include "farfield/approximation/color_cube/cube_lanes.hpp"
#include "farfield/approximation/placed/placed_splats.hpp"

namespace farfield {

/// Each cell is one cube of 24 bytes.
struct ColorCube {
    /// The source of inner cells' colors: their children (front four over back four, then the average), or primitives,
    /// as for leaves, "at the expense of some extra preprocessing time" (1996, section 4).
    enum class Inner : std::uint8_t { composited, direct };
    /// `blended`: alpha is the part of the face that is covered (1996). `thresholded`: faces of which more than
    /// coverage_threshold is covered are opaque and others are not drawn; coverages of front and back add up (1995,
    /// section 4.1).
    enum class Opacity : std::uint8_t { blended, thresholded };

    /// Orthographic samples along a side of the cell, 1 to 8. 0 takes projected areas instead, which cannot tell
    /// overlap from extent and so err towards covering too much.
    std::uint32_t samples = 4;
    Inner inner = Inner::composited;
    Opacity opacity = Opacity::blended;
    float coverage_threshold = 0.5f;
    /// Children are not kept where the colors of all quarters of faces, front over back, differ by at most this from
    /// the cell's own: cells as large as the tolerance are then drawn for cells of half that size. Below 0 all are
    /// kept.
    float redundancy_tolerance = 2.0f / 255;
    /// Whether primitives smaller than a sample are deposited by the law that faces' opacities suggest: far more
    /// accurate, but up to three times slower where a cell of a pixel holds but a few of them. (The papers draw them.)
    bool guesses_area_law = false;

    /// Premultiplied colors of the cell's faces. Alpha may exceed 1 where loose contents lie side by side beyond a
    /// face: a neighbor has that much less, and their parent is right again.
    using stand_in_draft = std::array<glm::vec4, 6>;
    using stand_in_data = std::array<Rgba8, 6>;  ///< premultiplied; sides -x, +x, -y, +y, -z, +z
    static constexpr ApproximationFacts facts{.needs_polygons = true,
                                              .stands_in = true,
                                              .merges_octants = true,
                                              .bounds_error = true,
                                              .expects_error = true,
                                              .compares = true,
                                              .provides_area_law = true,
                                              .file_tag = 0x43430003u};

    const char* wrong_option() const {
        if (samples > 8) return "ColorCube: samples must be at most 8";
        if (inner > Inner::direct || opacity > Opacity::thresholded) return "ColorCube: an option is not in its enum";
        if (!(coverage_threshold >= 0 && coverage_threshold <= 1))
            return "ColorCube: coverage_threshold must lie between 0 and 1";
        return std::isnan(redundancy_tolerance) ? "ColorCube: redundancy_tolerance must not be NaN" : nullptr;
    }

    bool merges_children() const { return inner == Inner::composited; }

    template <class Contents, OrthographicSampler Sampler>
    stand_in_draft sample(const Cell& cell, Contents&& contents, Sampler& sampler) const {
        return samples == 0 ? projected(cell, contents, sampler) : sampled(cell, contents, sampler);
    }

    void merge(const Cell&, stand_in_draft& own, std::span<const ChildDraft<stand_in_draft>> children) const {
        const auto octants = octants_of(children);
        for (unsigned side = 0; side < 6; ++side) {
            glm::vec4 sum(0);
            for (unsigned i = 0; i < 8; ++i) {
                if (is_front(i, side)) sum += quarter(octants, side, i);
            }
            // A node's own primitives lie among its children: neither is in front.
            const glm::vec4 inside = sum * 0.25f;
            own[side] = 0.5f * (over(own[side], inside) + over(inside, own[side]));
        }
    }

    bool reproduces(const Cell&, const stand_in_draft& own,
                    std::span<const ChildDraft<stand_in_draft>> children) const {
        const auto octants = octants_of(children);
        for (unsigned side = 0; side < 6; ++side) {
            for (unsigned i = 0; i < 8; ++i) {
                if (!is_front(i, side)) continue;
                const glm::vec4 off = glm::abs(quarter(octants, side, i) - own[side]);
                if (!(std::max({off.x, off.y, off.z, off.w}) <= redundancy_tolerance)) return false;
            }
        }
        return true;
    }

    stand_in_data finish(const Cell&, const stand_in_draft& d) const {
        stand_in_data data;
        for (unsigned side = 0; side < 6; ++side) {
            const glm::vec4 c = d[side] * (d[side].w > 1 ? 1 / d[side].w : 1.0f);
            if (opacity == Opacity::blended) {
                data[side] = to_rgba8(c);
            } else {
                data[side] = c.w > coverage_threshold ? to_rgba8(glm::vec4(glm::vec3(c) / c.w, 1)) : Rgba8{0, 0, 0, 0};
            }
        }
        return data;
    }

    Work expected_work() const { return {.splats = 1}; }
    Work work(const stand_in_data&) const { return expected_work(); }

    /// The projected side of the cell (1995, section 3.1: cell size / distance < epsilon).
    float error_px(const stand_in_data&, const Cell& cell, const LocalView& view) const {
        return view.pixels(cell.largest_side(), view.distance_to(cell));
    }
    float least_error_px(const Cell& cell, unsigned levels, const LocalView& view) const {
        return least_projected_side(cell, levels, view);
    }

    float covered_part(const stand_in_data& data, const Cell& cell, const LocalView& view) const {
        const VisibleFaces faces(cell, view);
        float covered = 0, outline = 0;
        for (std::size_t i = 0; i < std::size_t(faces.count); ++i) {
            covered += faces.projected[i] * (1.0f / 255) * float(data[faces.side[i]].a);
            outline += faces.projected[i];
        }
        // Contents that no sample met may take half of the room of one.
        const float unseen = 0.5f / float(samples == 0 ? 16 : samples * samples);
        return outline > covered ? std::max(covered / outline, unseen) : 1.0f;
    }
    float expected_rmse(float side_px, float covered) const { return cube_rmse(side_px, covered); }

    /// The law of the faces' mean opacity, weighted by itself: faces that see a surface on edge say nothing about it.
    std::optional<AreaLaw> area_law(const stand_in_data& data) const {
        if (!guesses_area_law) return {};
        unsigned sum = 0, squares = 0;
        for (const Rgba8 c : data) {
            sum += c.a;
            squares += unsigned(c.a) * c.a;
        }
        return law_of_opacity(float(squares) / (255.0f * float(std::max(sum, 1u))));
    }

    /// The six faces, colors not premultiplied.
    template <class Sink>
    void polygons(const stand_in_data& data, const Cell& cell, Sink&& sink) const {
        for (unsigned side = 0; side < 6; ++side) emit_polygon(face_of(cell, side, data[side]), sink);
    }

    /// Up to three faces or, for a cell too small to have a shape, one splat with their common area and color: visible
    /// faces of a convex body do not overlap, so their areas add up.
    template <class Sink>
    void draw_stand_in(const stand_in_data& data, const Cell& cell, const LocalView& view, Sink&& sink) const {
        const VisibleFaces faces(cell, view);
        if (!is_small(cell.center, cell.largest_side(), view, sink.splat_limit_px)) {
            for (int i = 0; i < faces.count; ++i) {
                const Rgba8 color = data[faces.side[std::size_t(i)]];
                if (color.a != 0) sink(face_of(cell, faces.side[std::size_t(i)], color));
            }
            return;
        }
        draw_splat(data, cell, faces, view, sink);
    }

    /// All that the contents of a cell may reach. They cover no more of it for that.
    ContentsBox contents_box(const stand_in_data& data, const Cell& cell, const Box& reach,
                             const LocalView& view) const {
        glm::vec4 sum(0);
        for (const Rgba8 c : data) sum += glm::vec4(float(c.r), float(c.g), float(c.b), float(c.a));
        const float covered = sum.w * (1.0f / (6 * 255));
        const glm::vec3 rgb = glm::min(glm::vec3(sum) * (255 / glm::max(sum.w, 1.0f)) + 0.5f, glm::vec3(255.0f));
        const glm::vec3 w = view.direction_towards_viewer(cell.center);
        const float unit = length_unit(cell), cells = outline_of(cell.half / unit, w);
        // Of an octant a square is drawn that is as large as its outline, and sticks out of that.
        const glm::vec3 octants = 0.5f * cell.half + 0.25f * unit * std::sqrt(cells);
        const glm::vec3 lower = glm::max(glm::min(reach.lower, cell.center - octants), cell.bounds().lower),
                        upper = glm::min(glm::max(reach.upper, cell.center + octants), cell.bounds().upper),
                        half = upper * 0.5f - lower * 0.5f;
        const float all = outline_of(half / unit, w);
        return {upper * 0.5f + lower * 0.5f, half, all > cells ? covered * (cells / all) : covered,
                Rgba8{std::uint8_t(rgb.x), std::uint8_t(rgb.y), std::uint8_t(rgb.z),
                      std::uint8_t(law_of_opacity(covered))}};
    }

    // Many at once: see DrawsPlaced in approximation.hpp.

    static constexpr std::size_t words_placed = PlacedCube::words;
    /// Not those that are drawn as faces.
    bool places(const Cell& cell, const LocalView& view, float splat_limit_px) const {
        return is_small(cell.center, cell.largest_side(), view, splat_limit_px);
    }
    void place(const stand_in_data& data, const Cell& cell, std::uint32_t* words) const {
        const auto put = [&](std::size_t i, auto word) {
            words[i * PlacedCube::stride] = std::bit_cast<std::uint32_t>(word);
        };
        for (int axis = 0; axis < 3; ++axis) {
            put(PlacedCube::center + std::size_t(axis), cell.center[axis]);
            put(PlacedCube::half + std::size_t(axis), cell.half[axis]);
        }
        for (std::size_t side = 0; side < 6; ++side) put(PlacedCube::colors + side, data[side]);
    }
    PlacedStandIns placed(const std::uint32_t* words, std::size_t count) const {
        static_assert(words_placed == PlacedStandIns{.kind = PlacedStandIns::Kind::cubes}.word_count());
        return {.kind = PlacedStandIns::Kind::cubes, .words = words, .count = count};
    }
    template <class Sink>
    void draw_placed(const std::uint32_t* words, std::size_t count, const LocalView& view, Sink&& sink) const {
        const auto fill = [&](auto splats_of, std::size_t first, std::size_t n, PlacedSplats& out) {
            return splats_of(words + first, n, view, out);
        };
        const auto one = [&](std::size_t i, auto&& to) {
            const auto word = [&](std::size_t at) { return words[at * PlacedCube::stride + i]; };
            Cell cell;
            stand_in_data data;
            for (int axis = 0; axis < 3; ++axis) {
                cell.center[axis] = std::bit_cast<float>(word(PlacedCube::center + std::size_t(axis)));
                cell.half[axis] = std::bit_cast<float>(word(PlacedCube::half + std::size_t(axis)));
            }
            for (std::size_t side = 0; side < 6; ++side) {
                data[side] = std::bit_cast<Rgba8>(word(PlacedCube::colors + side));
            }
            draw_splat(data, cell, VisibleFaces(cell, view), view, to);
        };
        detail::draw_placed(detail::cube_kernels, count, fill, one, sink);
    }

  private:
    template <class Sink>
    static void draw_splat(const stand_in_data& data, const Cell& cell, const VisibleFaces& faces,
                           const LocalView& view, Sink&& sink) {
        float footprint = 0;
        glm::vec4 sum(0);
        for (int i = 0; i < faces.count; ++i) {
            const Rgba8 c = data[faces.side[std::size_t(i)]];
            footprint += faces.projected[std::size_t(i)];
            sum += glm::vec4(float(c.r), float(c.g), float(c.b), float(c.a)) * faces.projected[std::size_t(i)];
        }
        if (sum.w > 0) sink(splat_of(cell.center, footprint, length_unit(cell), sum, view));
    }

    using Octants = std::array<const stand_in_draft*, 8>;
    static Octants octants_of(std::span<const ChildDraft<stand_in_draft>> children) {
        Octants octants{};
        for (const auto& c : children) octants[c.child] = c.draft;
        return octants;
    }
    static bool is_front(unsigned octant, unsigned side) { return (octant >> side / 2 & 1) == (side & 1); }
    /// The color seen through one of the front four octants.
    glm::vec4 quarter(const Octants& octants, unsigned side, unsigned front) const {
        const auto face = [&](unsigned i) { return octants[i] ? (*octants[i])[side] : glm::vec4(0); };
        return over(face(front), face(front ^ 1u << side / 2));
    }

    glm::vec4 over(glm::vec4 front, glm::vec4 back) const {
        if (opacity == Opacity::blended) return front + back * glm::max(0.0f, 1 - front.w);  // Porter and Duff 1984
        // "A variation on the over operation ... designed to prevent large opaque surfaces from becoming transparent
        // at coarser levels ... assuming that the front and back faces' coverage values have minimal overlap."
        const float seen = back.w > 0 ? glm::clamp((1 - front.w) / back.w, 0.0f, 1.0f) : 0.0f;
        return front + back * seen;
    }

    template <class Contents, class Sampler>
    stand_in_draft sampled(const Cell& cell, Contents&& contents, Sampler& sampler) const {
        // Contents that stick out of a loose cell are sampled too, or their mass would be lost: squares keep the size
        // they have on the cell's faces and the grid grows to the bounds.
        const Box bounds = cell.bounds();
        const float side = cell.largest_side();
        const float looseness = side > 0 ? bounds.largest_side() / side : 1.0f;
        SampleGrid grid{bounds, std::min(unsigned(std::ceil(float(samples) * looseness)), 16u), 1};
        thread_local std::vector<Rgba8> out;
        out.resize(grid.size());
        unsigned met = 7;  // axes that something is seen along
        if constexpr (requires { sampler.sample_met(grid, contents, std::span<Rgba8>(out)); }) {
            met = sampler.sample_met(grid, contents, std::span<Rgba8>(out));
        } else {
            sampler.sample(grid, contents, std::span<Rgba8>(out));
        }
        stand_in_draft d{};
        const std::size_t squares = std::size_t(grid.n) * grid.n;
        const float per_unit = 1 / length_unit(cell);
        const glm::vec3 square = bounds.size() * (per_unit / float(grid.n)), half = cell.half * per_unit;
        for (unsigned s = 0; s < 6; ++s) {
            if ((met >> s / 2 & 1) == 0) continue;
            const int u = int(s / 2 + 1) % 3, v = int(s / 2 + 2) % 3;
            // Two channels a word: 256 samples of 255 fill 16 bits.
            std::uint32_t red_blue = 0, green_alpha = 0;
            for (const Rgba8 sample : std::span<const Rgba8>(out).subspan(grid.index(s, 0, 0, 0), squares)) {
                const std::uint32_t c = std::bit_cast<std::uint32_t>(sample);
                red_blue += c & 0x00ff00ffu;
                green_alpha += c >> 8 & 0x00ff00ffu;
            }
            static_assert(std::endian::native == std::endian::little, "bytes of a color are taken apart");
            const std::array<std::uint32_t, 4> sum{red_blue & 0xffff, green_alpha & 0xffff, red_blue >> 16,
                                                   green_alpha >> 16};
            const float face = 4 * half[u] * half[v];
            if (sum[3] == 0 || !(face > 0)) continue;
            const glm::vec4 total = glm::vec4(float(sum[0]), float(sum[1]), float(sum[2]), float(sum[3])) *
                                    (square[u] * square[v] / (255 * face));
            d[s] = total;
        }
        return d;
    }

    template <class Contents, class Sampler>
    stand_in_draft projected(const Cell& cell, Contents&& contents, [[maybe_unused]] const Sampler& sampler) const {
        stand_in_draft d{};
        const float per_unit = 1 / length_unit(cell);
        const glm::vec3 half = cell.half * per_unit;
        contents([&](const Polygon& polygon) {
            const glm::vec3 doubled = doubled_area<float>(
                polygon.vertices.size(), [&](std::size_t i) { return polygon.vertices[i] * per_unit; });
            glm::vec4 color(0);
            for (const Rgba8 c : polygon.colors) color += to_vec4(c);
            color *= 1.0f / float(polygon.colors.size());
            const glm::vec4 premultiplied(glm::vec3(color) * color.w, color.w);
            for (int s = 0; s < 6; ++s) {
                const float face = 4 * half[(s / 2 + 1) % 3] * half[(s / 2 + 2) % 3];
                if (!(face > 0)) continue;
                glm::vec4 seen = premultiplied;
                if constexpr (LightsPolygons<Sampler>) {
                    const bool is_front = (doubled[s / 2] > 0) == (s % 2 == 1);
                    const float brightness = sampler.brightness(polygon, is_front ? doubled : -doubled);
                    seen = glm::vec4(glm::vec3(seen) * brightness, seen.w);
                }
                d[std::size_t(s)] += seen * (0.5f * std::abs(doubled[s / 2]) / face);
            }
        });
        return d;
    }
};

}  // namespace farfield
