// A cell as a tensor of its surfaces' areas: it tells how much of them is seen from any direction, as six faces cannot.
//
// Six opaque faces seen off their axes are too large ("the color-cube ... tends to be larger", Chamberlain et al. 1995,
// section 5), and tear apart where each is covered in part. The sums T = sum A n n^T over areas A with unit normals n
// give the projected area sqrt(W w^T T w) (W = sum A) towards a unit vector w: exactly for one flat piece, and rescaled
// to the mean of Cauchy's formula (W / 2 over all directions) within a few per cent for most others. It is the form of
// Heitz et al. 2015 ("SGGX"). Sums are merged by adding them; only stored tensors are rescaled.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "farfield/approximation.hpp"
#include "farfield/approximation/cell_faces.hpp"
#include "farfield/approximation/opacity_tensor/appearance.hpp"
#include "farfield/approximation/opacity_tensor/area_sums.hpp"
#include "farfield/approximation/opacity_tensor/fit.hpp"
#include "farfield/approximation/opacity_tensor/stored_tensor.hpp"
#include "farfield/approximation/placed/placed_splats.hpp"

namespace farfield {

/// Each cell is one tensor of 16 bytes, drawn as one deposit: an upright rectangle of the picture with an opacity.
struct OpacityTensor {
    /// True: surfaces are closed and counter-clockwise seen from outside. Back sides are not counted, as something
    /// hides them. Use it with a renderer that culls back faces.
    bool closed_surfaces = false;
    /// True: areas that hide one another within a cell are counted once. False is for experiments.
    bool counts_overlap = true;
    /// Factors of a sheet's opacity: rectangles meet only roughly, and a surplus in one place does not make up for a
    /// gap in another. Sheets smaller than a cell cover too much by the same factor. Closed surfaces need more, as no
    /// back sides close the gaps.
    float sheet_gain = 1.15f, closed_sheet_gain = 1.6f;

    using stand_in_draft = TensorSums;
    using stand_in_data = StoredTensor;
    static constexpr ApproximationFacts facts{.needs_polygons = true,
                                              .stands_in = true,
                                              .merges_octants = true,
                                              .bounds_error = true,
                                              .expects_error = true,
                                              .provides_area_law = true,
                                              .file_tag = 0x4f540002u};

    const char* wrong_option() const {
        for (const float gain : {sheet_gain, closed_sheet_gain}) {
            if (!(gain > 0 && std::isfinite(gain))) return "OpacityTensor: gains of sheets must be above 0 and finite";
        }
        return nullptr;
    }

    /// Children's masks nest in their parent's.
    bool merges_children() const { return true; }

    template <class Contents, OrthographicSampler Sampler>
    stand_in_draft sample(const Cell& cell, Contents&& contents, Sampler& sampler) const {
        stand_in_draft d;
        contents([&](const Polygon& polygon) { d.add(cell, polygon, closed_surfaces, sampler); });
        if constexpr (!LightsPolygons<Sampler>) {
            // Only pictures show this sampler's light.
            const SampleGrid grid{cell.bounds(), 4, 1};
            std::vector<Rgba8> out(grid.size());
            sampler.sample(grid, contents, std::span<Rgba8>(out));
            glm::vec4 sum(0);
            for (const Rgba8 c : out) sum += glm::vec4(float(c.r), float(c.g), float(c.b), float(c.a));
            if (sum.w > 0) d.sums.color = glm::vec3(sum) * (255 / sum.w * d.sums.area);
        }
        return d;
    }

    void merge(const Cell& cell, stand_in_draft& own, std::span<const ChildDraft<stand_in_draft>> children) const {
        const Box bounds = cell.bounds();
        const float ordinary = cell.to_ordinary();
        for (const auto& child : children) {
            const TensorSums draft = child.draft->scaled(ordinary / child.cell->to_ordinary());
            own.sums += draft.sums.about((cell.center - child.cell->center) * ordinary);
            own.contents.add(draft.contents);
            own.masks.add_child(bounds, draft.masks, child.cell->bounds());
        }
    }

    stand_in_data finish(const Cell& local_cell, const stand_in_draft& d) const {
        const Cell cell = local_cell.scaled(local_cell.to_ordinary());
        const TensorFit fit(d, cell, closed_surfaces);
        if (fit.is_empty()) return {};
        TensorShape s = fit.shape(counts_overlap);
        const TensorAppearance kept = appearance_of(StoredTensor::packed(s));
        s.error = fit.lost_part([&](glm::vec3 w) { return kept.seen_from(w).area; });
        return StoredTensor::packed(s);
    }

    Work expected_work() const { return {.splats = 1}; }
    /// Contents without an area must not vanish, so their stand-in is never worth it.
    Work work(const stand_in_data& data) const {
        if (data == StoredTensor{}) return {.splats = std::numeric_limits<float>::infinity()};
        return expected_work();
    }
    std::optional<AreaLaw> area_law(const stand_in_data& data) const { return data.area_law(); }
    bool is_sound(const stand_in_data& data) const { return data.is_sound(); }

    /// The projected side of the cell, since places within it are lost, and up to as much again for areas that are too
    /// large or too small, as its masks told when it was made. A child's error is never larger.
    float error_px(const stand_in_data& data, const Cell& cell, const LocalView& view) const {
        return view.pixels(cell.largest_side(), view.distance_to(cell)) * (1 + data.error());
    }
    float least_error_px(const Cell& cell, unsigned levels, const LocalView& view) const {
        return least_projected_side(cell, levels, view);
    }

    float covered_part(const stand_in_data& data, const Cell& cell, const LocalView& view) const {
        const TensorAppearance appearance = appearance_of(data);
        const glm::vec3 w = view.direction_towards_viewer(appearance.center_in(cell));
        const float area = appearance.seen_from(w).area, outline = outline_of(cell.half / tensor_unit(cell), w);
        // A sheet on edge is not nothing.
        return outline > area ? std::max(area / outline, 1.0f / 256) : 1.0f;
    }
    /// Below a pixel places do not matter, and areas are right to a fifth; above, what lies in the cell is spread over
    /// a rectangle.
    float expected_rmse(float side_px, float covered) const {
        return 0.8f * (std::sqrt(covered) * side_px + 0.25f * covered) / (side_px + 1);
    }

    /// One splat, or three faces that cross where the renderer has no splats.
    template <class Sink>
    void draw_stand_in(const stand_in_data& data, const Cell& cell, const LocalView& view, Sink&& sink) const {
        const TensorAppearance appearance = appearance_of(data);
        const glm::vec3 center = appearance.center_in(cell), towards = view.towards_viewer(center);
        if (!(sink.splat_limit_px > 0)) {
            for (int axis = 0; axis < 3; ++axis) {
                if (towards[axis] == 0) continue;  // edge-on
                const Face face = appearance.crossing_face(cell, axis, towards[axis] > 0);
                if (face.rgba.a != 0) sink(face);
            }
            return;
        }
        draw_splat(appearance, center, tensor_unit(cell), TensorAppearance::least_reach(cell), view, sink);
    }

    /// A box about the contents' centroid that is twice as large as their own holds them, wherever in them it is. Of
    /// what is strewn no more is known than the reach of all.
    ContentsBox contents_box(const stand_in_data& data, const Cell& cell, const Box& reach,
                             const LocalView& view) const {
        const TensorAppearance appearance = appearance_of(data);
        const bool is_known = appearance.shape.law == AreaLaw::coherent;
        const float unit = tensor_unit(cell);
        // And as steps of extents (a sixteenth) and centers (a sixty-fourth) have it.
        const glm::vec3 around = (is_known ? appearance.shape.extent * (17.0f / 16) + 3.0f / 128 : glm::vec3(1)) * unit,
                        middle = appearance.center_in(cell);
        const glm::vec3 from = glm::clamp(middle - around, reach.lower, reach.upper),
                        to = glm::clamp(middle + around, reach.lower, reach.upper);
        const glm::vec3 center = 0.5f * (from + to), half = 0.5f * (to - from),
                        w = view.direction_towards_viewer(center);
        const TensorAppearance::Seen seen = appearance.seen_from(w);
        const float outline = outline_of(half / unit, w);
        const glm::vec3 rgb = seen.rgb + 0.5f;
        return {
            center, half, outline > seen.area ? seen.area / outline : 1.0f,
            Rgba8{std::uint8_t(rgb.x), std::uint8_t(rgb.y), std::uint8_t(rgb.z), std::uint8_t(appearance.shape.law)}};
    }

    // Many at once: see DrawsPlaced in approximation.hpp.

    static constexpr std::size_t words_placed = PlacedTensor::words;
    void place(const stand_in_data& data, const Cell& cell, std::uint32_t* words) const {
        const auto put = [&](std::size_t i, std::uint32_t word) { words[i * PlacedTensor::stride] = word; };
        const auto put_number = [&](std::size_t i, float v) { put(i, std::bit_cast<std::uint32_t>(v)); };
        put(0, std::uint32_t(data.first));
        put(1, std::uint32_t(data.first >> 32));
        put(2, std::uint32_t(data.second));
        put(3, std::uint32_t(data.second >> 32));
        const glm::vec3 corner = cell.bounds_center - cell.bounds_half;
        put_number(PlacedTensor::x, corner.x);
        put_number(PlacedTensor::y, corner.y);
        put_number(PlacedTensor::z, corner.z);
        put_number(PlacedTensor::unit, tensor_unit(cell));
        put_number(PlacedTensor::reach, TensorAppearance::least_reach(cell));
        put_number(PlacedTensor::scale, data.scale());
    }
    PlacedStandIns placed(const std::uint32_t* words, std::size_t count) const {
        static_assert(words_placed == PlacedStandIns{.kind = PlacedStandIns::Kind::tensors}.word_count());
        const TensorOptions o = options();
        return {PlacedStandIns::Kind::tensors, o.closed_surfaces, o.counts_overlap, o.sheet_gain, words, count};
    }
    template <class Sink>
    void draw_placed(const std::uint32_t* words, std::size_t count, const LocalView& view, Sink&& sink) const {
        const TensorOptions options = this->options();
        const auto fill = [&](auto splats_of, std::size_t first, std::size_t n, PlacedSplats& out) {
            return splats_of(words + first, n, view, options, out);
        };
        const auto one = [&](std::size_t i, auto&& to) { draw_one_placed(words + i, view, to); };
        detail::draw_placed(detail::tensor_kernels, count, fill, one, sink);
    }

    /// Three rectangles that cross, as opaque as the contents are along their normals. Turned with an instance, their
    /// tensors add up as all others do, and masks see of them what they would see of the contents.
    template <class Sink>
    void polygons(const stand_in_data& data, const Cell& cell, Sink&& sink) const {
        const TensorAppearance appearance = appearance_of(data);
        const float gain = appearance.gain_of_crossing_faces();
        for (int axis = 0; axis < 3; ++axis) emit_polygon(appearance.crossing_face(cell, axis, true, gain), sink);
    }

  private:
    TensorOptions options() const {
        return {closed_surfaces, counts_overlap, closed_surfaces ? closed_sheet_gain : sheet_gain};
    }
    template <class Sink>
    void draw_splat(const TensorAppearance& appearance, glm::vec3 center, float unit, float least_reach,
                    const LocalView& view, Sink&& sink) const {
        const glm::vec3 towards = view.towards_viewer(center);
        const float length = length_of(towards);
        if (!(length > 0) || (view.is_perspective && !(view.depth(center) > 0))) return;
        const TensorAppearance::Seen seen = appearance.seen_from(towards / length);
        if (!(seen.area > 0)) return;
        const float area = seen.area * view.stretch(center);
        const glm::vec2 size = appearance.rectangle(center, view, area);
        const float part = area / (size.x * size.y);
        const AreaLaw law = appearance.shape.law;
        const bool gains = law == AreaLaw::coherent && appearance.reaches_across(unit, least_reach);
        const float gain = gains ? options().sheet_gain : 1.0f;
        const glm::vec3 rgb = seen.rgb + 0.5f;
        sink(Splat{center, size * unit, std::min(gain * part, 1.0f),
                   Rgba8{std::uint8_t(rgb.x), std::uint8_t(rgb.y), std::uint8_t(rgb.z), std::uint8_t(law)}});
    }

    template <class Sink>
    void draw_one_placed(const std::uint32_t* words, const LocalView& view, Sink&& sink) const {
        const auto word = [&](std::size_t i) { return words[i * PlacedTensor::stride]; };
        const auto number = [&](std::size_t i) { return std::bit_cast<float>(word(i)); };
        const StoredTensor data{word(0) | std::uint64_t(word(1)) << 32, word(2) | std::uint64_t(word(3)) << 32};
        const TensorAppearance appearance = appearance_of(data);
        const float unit = number(PlacedTensor::unit);
        const glm::vec3 corner(number(PlacedTensor::x), number(PlacedTensor::y), number(PlacedTensor::z));
        draw_splat(appearance, corner + appearance.shape.center * unit, unit, number(PlacedTensor::reach), view, sink);
    }

    TensorAppearance appearance_of(const stand_in_data& data) const {
        return {data.unpacked(), closed_surfaces, counts_overlap};
    }
};

}  // namespace farfield
