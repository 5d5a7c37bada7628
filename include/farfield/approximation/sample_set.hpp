// The randomized sample tree of Klein, Krokowski, Fischer, Wand, Wanka, Meyer auf der Heide: The Randomized Sample
// Tree: A Data Structure for Interactive Walkthroughs in Externally Stored Virtual Environments, VRST 2002.
//
// Inner cells hold samples of the polygons in them, so that a frame refines by adding: it draws what every cell on its
// way holds, and where it stops, the rest of that cell by a stand-in of another approximation. The stand-in is made
// from all that lies in the cell, and drawn as much fainter as a part of it has been drawn with the cells above.
#pragma once

#include "farfield/settings.hpp"

#include <concepts>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <type_traits>

#include "farfield/approximation.hpp"
#include "farfield/approximation/area_splat.hpp"
#include "farfield/approximation/sample_set/sample_size.hpp"
#include "farfield/geometry/length.hpp"
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
    /// Whether a cell's sample is drawn too where a frame stops, before what stands for the rest: true is section 4.2,
    /// the more accurate where there is more than one sample a pixel, false sections 4.4 and 4.5, up to four times
    /// faster.
    bool draws_own_run = false;

    using stand_in_draft = typename Inner::stand_in_draft;
    struct stand_in_data {
        typename Inner::stand_in_data inner;
        float rest = 1;               ///< the part of the cell's areas that `inner` has to stand for
        std::uint32_t own_items = 0;  ///< drawn with it; 0: the own run is not
    };
    static constexpr ApproximationFacts facts{
        .accepts = Assignment::unique,
        .needs_polygons = true,
        .needs_ordering = Inner::facts.needs_ordering,
        .stands_in = true,
        .merges_octants = Inner::facts.merges_octants,
        .bounds_error = Inner::facts.bounds_error,
        .samples_primitives = true,
        .file_tag = Inner::facts.file_tag == 0 ? 0u : 0x53530001u ^ Inner::facts.file_tag};

    const char* wrong_option() const {
        if (const char* why = detail::wrong_option(inner)) return why;
        return c > 0 && c <= 1000 ? nullptr : "SampleSet: c must lie above 0 and at most at 1000";
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
        stand_in_data out{data.inner, cell.left, 0};
        if (draws_own_run) {
            out.rest = cell.left - cell.own;
            out.own_items = cell.own_items;
        }
        if constexpr (knows_rest) out.inner = inner.rest_of(data.inner, 1 - out.rest);
        return out;
    }

    /// A surface fills four of a cell's eight children, and its sample is drawn with all of them.
    Work expected_work() const {
        Work work = inner.expected_work();
        work.triangles += 0.25f * c;
        return work;
    }
    Work work(const stand_in_data& data) const {
        Work work = detail::work_of_stand_in(inner, data.inner);
        work.triangles += float(data.own_items);
        return work;
    }
    bool is_sound(const stand_in_data& data) const {
        if (!(data.rest >= 0 && data.rest <= 1)) return false;
        if constexpr (requires { inner.is_sound(data.inner); }) return inner.is_sound(data.inner);
        return true;
    }

    float error_px(const stand_in_data& data, const Cell& cell, const LocalView& view) const {
        return inner.error_px(data.inner, cell, view);
    }
    float least_error_px(const Cell& cell, unsigned levels, const LocalView& view) const
        requires(Inner::facts.bounds_error) {
        return inner.least_error_px(cell, levels, view);
    }

    template <class Sink>
    void draw_stand_in(const stand_in_data& data, const Cell& cell, const LocalView& view, Sink&& sink) const {
        if (data.own_items != 0) sink(OwnRun{});
        if (!(data.rest > 0)) return;
        Rest<std::remove_reference_t<Sink>> rest{sink, sink.splat_limit_px, 1 - data.rest, view};
        if (data.own_items != 0) rest.put_behind(cell);
        inner.draw_stand_in(data.inner, cell, view, rest);
    }

    template <class Sink>
    void polygons(const stand_in_data& data, const Cell& cell, Sink&& sink) const {
        // Whoever takes them has not been given what lies above.
        detail::stand_in_polygons(inner, data.inner, std::span<const detail::NoPool>(), cell, sink);
    }

  private:
    /// An Inner may change its data itself, for a part of its areas that has been drawn.
    static constexpr bool knows_rest = requires(const Inner& i, const typename Inner::stand_in_data& data) {
        { i.rest_of(data, 0.0f) } -> std::same_as<typename Inner::stand_in_data>;
    };

    /// Sends on what is left of something of which a part is drawn already: if all would cover `a`, and the part drawn
    /// covers its share of that, x, the rest has to cover (a - x) / (1 - x) of what x leaves. Opaque things stay
    /// opaque.
    template <class Sink>
    struct Rest {
        Sink& sink;
        float splat_limit_px;
        float drawn;
        const LocalView& view;
        float back = 0;    ///< moved away from the viewer by that, in a parallel view
        float larger = 1;  ///< seen from the eye, in perspective

        /// The own run shows what is there, and the rest fills gaps: it must not hide it.
        void put_behind(const Cell& cell) {
            const float by = 0.5f * cell.largest_side();
            if (view.is_perspective) {
                const float distance = length_of(cell.center - view.eye);
                if (distance > by) larger = 1 + by / distance;
            } else {
                back = by;
            }
        }
        glm::vec3 moved(glm::vec3 p) const {
            return view.is_perspective ? view.eye + (p - view.eye) * larger : p + view.forward * back;
        }
        float factor(float a) const {
            if constexpr (knows_rest) return 1;
            const float left = 1 - a * drawn;
            return left > 0 ? (1 - drawn) / left : 1.0f;
        }
        void operator()(Face face) const {
            const float f = factor(float(face.rgba.a) / 255);
            const auto fainter = [&](std::uint8_t v) { return std::uint8_t(float(v) * f + 0.5f); };
            face.rgba = {fainter(face.rgba.r), fainter(face.rgba.g), fainter(face.rgba.b), fainter(face.rgba.a)};
            face.lower = moved(face.lower);
            face.upper = moved(face.upper);
            sink(face);
        }
        void operator()(Splat splat) const {
            splat.opacity *= factor(splat.opacity);
            splat.center = moved(splat.center);
            splat.size *= larger;
            sink(splat);
        }
        void operator()(OwnRun run) const { sink(run); }
    };
};

}  // namespace farfield
