// The randomized sample tree of Klein, Krokowski, Fischer, Wand, Wanka, Meyer auf der Heide: The Randomized Sample
// Tree: A Data Structure for Interactive Walkthroughs in Externally Stored Virtual Environments, VRST 2002.
//
// Inner cells hold samples of the polygons in them, so that a frame refines by adding: it draws what every cell on its
// way holds, and where it stops, the rest of that cell by a stand-in of another approximation. The stand-in is made
// from all that lies in the cell, and drawn as much fainter as a part of it has been drawn with the cells above.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>

#include "farfield/approximation.hpp"
#include "farfield/approximation/area_splat.hpp"
#include "farfield/approximation/sample_set/sample_size.hpp"
#include "farfield/geometry/area_law.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield {

/// `Inner` is what a cell is drawn by where a frame stops: AreaSplat is the paper's color of a cell (section 4.4),
/// OpacityTensor one that knows directions.
template <Approximation Inner = AreaSplat>
requires(Inner::facts.stands_in && !Inner::facts.has_pool) struct SampleSet {
    Inner inner{};
    /// Theorem 1's constant: 13.8 has a cell wrong with a probability of 1e-6. sample_constant() gives it for a
    /// probability of a correct image.
    float c = 13.8f;
    std::uint32_t seed = 0;
    /// Where the tolerance is at most this, a cell that a frame stops at has its sample drawn too, before what stands
    /// for the rest (section 4.2), by renderers of more than 4 samples a pixel; beyond it, not (4.5: splats of i
    /// pixels, faster and less accurate). 0: never.
    float samples_up_to_px = 1;
    /// Cells that hold more area than this, in squares of their side, are drawn without their sample. More than one
    /// sheet lies in them, and a sample shows the hidden ones through the gaps of the one in front (figure 5); a single
    /// one has at most the square root of 3.
    float most_areas_for_sample = 1.75f;

    using stand_in_draft = typename Inner::stand_in_draft;
    struct stand_in_data {
        typename Inner::stand_in_data inner;
        std::uint16_t left = 65535, sample = 0;  ///< SampledCell's, of 65535
        std::uint32_t packed = 0;                ///< no bit-fields, which cannot be stored

        /// `all`: few more than it, which are drawn too.
        std::uint32_t sample_size() const { return packed & 0x7fffffffu; }
        bool is_in_children() const { return packed >> 31 != 0; }  ///< SampledCell's
    };
    static constexpr ApproximationFacts facts{
        .accepts = Assignment::unique,
        .needs_polygons = true,
        .needs_ordering = Inner::facts.needs_ordering,
        .stands_in = true,
        .merges_octants = Inner::facts.merges_octants,
        .bounds_error = Inner::facts.bounds_error,
        .samples_primitives = true,
        .file_tag = Inner::facts.file_tag == 0 ? 0u : 0x53530002u ^ Inner::facts.file_tag};

    const char* wrong_option() const {
        if (const char* why = detail::wrong_option(inner)) return why;
        if (!(c > 0 && c <= 1000)) return "SampleSet: c must lie above 0 and at most at 1000";
        if (!(most_areas_for_sample >= 0)) return "SampleSet: most_areas_for_sample must be 0 or more";
        return samples_up_to_px >= 0 ? nullptr : "SampleSet: samples_up_to_px must be 0 or more";
    }

    float sample_key(std::uint32_t index, double area) const { return detail::race_key(index, seed, area); }
    std::uint32_t sample_size(double areas_per_side) const { return farfield::sample_size(areas_per_side, double(c)); }

    bool merges_children() const requires(Inner::facts.merges_octants) { return inner.merges_children(); }
    template <class Contents, OrthographicSampler Sampler>
    stand_in_draft sample(const Cell& cell, Contents&& contents, Sampler& sampler) const {
        return inner.sample(cell, contents, sampler);
    }
    void merge(const Cell& cell, stand_in_draft& own, std::span<const ChildDraft<stand_in_draft>> children) const
        requires(Inner::facts.merges_octants) {
        inner.merge(cell, own, children);
    }
    stand_in_data finish(const Cell& cell, const stand_in_draft& d) const { return {inner.finish(cell, d)}; }
    stand_in_data sampled(const stand_in_data& data, SampledCell cell) const {
        const auto part = [](float f) { return std::uint16_t(f * 65535 + 0.5f); };
        stand_in_data out{data.inner, part(cell.left), 0, cell.is_in_children ? 0x80000000u : 0u};
        if (cell.areas_per_side > most_areas_for_sample) return out;
        out.sample = part(cell.sample);
        // A deposit is about as much work as eight triangles (TriangleCount).
        const bool pays = cell.fixed != 0 || cell.items > cell.sample_size + 8;
        out.packed |= pays ? cell.sample_size & all : all;
        return out;
    }

    /// What a split adds for each child: a surface fills four of a cell's eight, and the cell takes a sample from them,
    /// after which a child must hold more than its stand-in costs, or it goes again. Cells of fewer were three of four
    /// that a build made of a chessboard, and kept none of.
    Work expected_work() const {
        Work work = inner.expected_work();
        work.triangles += 0.25f * c;
        return work;
    }
    Work work(const stand_in_data& data) const { return detail::work_of_stand_in(inner, data.inner); }
    bool is_sound(const stand_in_data& data) const {
        if (data.sample > data.left) return false;
        if constexpr (requires { inner.is_sound(data.inner); }) return inner.is_sound(data.inner);
        return true;
    }

    /// With samples it is about the cell's projected bounding box (section 4.2), whose sides are 1.5 of the cell's on
    /// average over directions; splats are as large as cells.
    float error_px(const stand_in_data& data, const Cell& cell, const LocalView& view) const {
        const bool with_sample = !leaves_out_samples(view, view.splat_limit_px);
        return inner.error_px(data.inner, cell, view) * (with_sample ? 1.5f : 1.0f);
    }
    float least_error_px(const Cell& cell, unsigned levels, const LocalView& view) const
        requires(Inner::facts.bounds_error) {
        return inner.least_error_px(cell, levels, view);
    }

    // Samples that are left out: see frame/left_out_samples.hpp.

    /// Where a sample of the picture is half a pixel or more, polygons smaller than a pixel are noise, and cost more.
    bool leaves_out_samples(const LocalView& view, float splat_limit_px) const {
        return !(draws_samples(view) && splat_limit_px < 1);
    }
    bool is_in_children(const stand_in_data& data) const { return data.is_in_children(); }
    /// In parts of 65535.
    float left(const stand_in_data& data) const { return float(data.left); }
    /// A sample is drawn evenly from all that lies in a cell: cells above have drawn as much of what lies in a part.
    stand_in_data with_more_left(const stand_in_data& data, float more) const {
        stand_in_data out = data;
        out.left = std::uint16_t(std::clamp(float(data.left) + more + 0.5f, 0.0f, 65535.0f));
        out.sample = std::min(data.sample, out.left);
        return out;
    }

    template <class Sink>
    void draw_stand_in(const stand_in_data& data, const Cell& cell, const LocalView& view, Sink&& sink) const {
        const bool with_sample = !leaves_out_samples(view, sink.splat_limit_px) && data.sample_size() != 0;
        if (with_sample) sink(OwnRun{data.sample_size()});
        if (with_sample && data.sample_size() == all) return;
        const unsigned left = with_sample ? data.left - data.sample : data.left;
        if (left == 0) return;
        const Rest<std::remove_reference_t<Sink>> rest{sink, sink.splat_limit_px, 1 - float(left) / 65535};
        if constexpr (knows_rest) {
            inner.draw_stand_in(inner.rest_of(data.inner, rest.drawn), cell, view, rest);
        } else {
            inner.draw_stand_in(data.inner, cell, view, rest);
        }
    }

    ContentsBox contents_box(const stand_in_data& data, const Cell& cell, const Box& reach, const LocalView& view) const
        requires(detail::TellsContentsBox<Inner>) {
        return inner.contents_box(data.inner, cell, reach, view);
    }

    // Many at once: see DrawsPlaced in approximation.hpp.

    static constexpr std::size_t words_placed = [] {
        if constexpr (detail::DrawsPlaced<Inner>) return Inner::words_placed + 1;
        return std::size_t(0);
    }();
    /// Not those that are drawn with samples.
    bool places(const LocalView& view, float splat_limit_px) const { return leaves_out_samples(view, splat_limit_px); }
    void place(const stand_in_data& data, const Cell& cell, std::uint32_t* words) const
        requires(detail::DrawsPlaced<Inner>) {
        inner.place(data.inner, cell, words);
        words[Inner::words_placed * detail::placed_stride] = data.left;
    }
    template <class Sink>
    void draw_placed(const std::uint32_t* words, std::size_t count, const LocalView& view, Sink&& sink) const
        requires(detail::DrawsPlaced<Inner>) {
        const std::uint32_t* const left = words + Inner::words_placed * detail::placed_stride;
        inner.draw_placed(words, count, view, [&](const Splat& splat, std::size_t i) {
            if (left[i] == 0) return;
            Rest<std::remove_reference_t<Sink>>{sink, 0, 1 - float(left[i]) / 65535}(splat);
        });
    }

    template <class Sink>
    void polygons(const stand_in_data& data, const Cell& cell, Sink&& sink) const {
        // Whoever takes them has not been given what lies above.
        detail::stand_in_polygons(inner, data.inner, std::span<const detail::NoPool>(), cell, sink);
    }

  private:
    static constexpr std::uint32_t all = std::numeric_limits<std::uint32_t>::max() >> 1;  ///< that lies below the cell

    bool draws_samples(const LocalView& view) const { return view.tolerance_px <= samples_up_to_px; }

    /// An Inner may change its data itself, for a part of its areas that has been drawn.
    static constexpr bool knows_rest = requires(const Inner& i, const typename Inner::stand_in_data& data) {
        { i.rest_of(data, 0.0f) } -> std::same_as<typename Inner::stand_in_data>;
    };

    /// Sends on what is left of something of which a part of the areas is drawn already: if all would cover `a`, and
    /// the part covers x of that, the rest has to cover (a - x) / (1 - x) of what x leaves. Opaque things stay opaque.
    template <class Sink>
    struct Rest {
        Sink& sink;
        float splat_limit_px;
        float drawn;

        float factor(float a, AreaLaw law) const {
            if (knows_rest || !(drawn > 0) || !(a > 0)) return 1;
            const float x = opacity_of_part(a, drawn, law);
            return x < 1 ? std::max(a - x, 0.0f) / ((1 - x) * a) : 1.0f;
        }
        void operator()(Face face) const {
            const float a = float(face.rgba.a) / 255, f = factor(a, law_of_opacity(a));
            const auto fainter = [&](std::uint8_t v) { return std::uint8_t(float(v) * f + 0.5f); };
            face.rgba = {fainter(face.rgba.r), fainter(face.rgba.g), fainter(face.rgba.b), fainter(face.rgba.a)};
            if (face.rgba.a != 0) sink(face);
        }
        void operator()(Splat splat) const {
            const AreaLaw law = AreaLaw(splat.rgb.a);
            splat.opacity = std::min(splat.opacity * factor(splat.opacity, law), 1.0f);  // rounding
            sink(splat);
        }
        void operator()(OwnRun run) const { sink(run); }
    };
};

}  // namespace farfield
