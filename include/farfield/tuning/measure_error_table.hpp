// Measures an ErrorTable of a hierarchy: what its far field errs by and costs, in views that are given or chosen.
//
// One that lies in pages is measured with all that frames want in its cache: a table tells what it takes to draw them,
// not to read them.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <memory>
#include <numbers>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "farfield/cost_model/measured_time.hpp"
#include "farfield/fail.hpp"
#include "farfield/geometry/box.hpp"
#include "farfield/image.hpp"
#include "farfield/primitive.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/tuning/error_table.hpp"
#include "farfield/tuning/sampled_error_table.hpp"
#include "farfield/tuning/viewers_by_samples.hpp"
#include "farfield/view.hpp"
#include "farfield/viewer.hpp"

namespace farfield {

struct HierarchyErrorOptions : ErrorTableOptions {
    /// If set, frames are priced by their counts instead of timed, so that the table is the same on any machine.
    std::optional<MeasuredTime> prices{};
    /// Of the pictures that others are compared with. Light and culling must be those of the renderer.
    ZBufferOptions reference{.samples = 64};
};

/// Four views of a box from all around and from 2 to 16 of its radii, in turn: near enough to be worth drawing exactly,
/// and far enough to be nothing but stand-ins. None of a box that is empty or not finite.
inline std::vector<View> views_around(const BoxD& bounds, int width = 512, int height = 512) {
    std::vector<View> views;
    if (bounds.is_empty() || !bounds.is_finite()) return views;
    const glm::dvec3 directions[] = {{0.6, 0.3, 1}, {1, 0.5, -0.4}, {-0.8, 0.2, 0.7}, {-0.5, 1, -0.9}};
    const double radius = 0.5 * glm::length(bounds.size());
    const glm::dvec3 center = bounds.center(), away = glm::abs(center);
    // A point is seen from where its coordinates tell apart.
    const double unit = radius > 0 ? radius : std::max({1.0, 0x1p-20 * away.x, 0x1p-20 * away.y, 0x1p-20 * away.z});
    double distance = 2 * unit;
    for (const glm::dvec3& direction : directions) {
        const glm::dvec3 eye = center + glm::normalize(direction) * distance;
        views.push_back({.camera = Camera::perspective(eye, center, {0, 1, 0}, std::numbers::pi_v<float> / 3),
                         .width = width,
                         .height = height});
        distance *= 2;
    }
    return views;
}

namespace detail {

/// As far as frames are counted: images and texels have no renderer yet.
inline Work work_of_frame(const FrameStats& s) {
    return {.triangles = float(s.primitives),
            .faces = float(s.faces),
            .splats = float(s.splats),
            .cells = float(s.cells_visited),
            .runs = float(s.runs)};
}

/// Of channels in [0, 1], over the pixels that the reference covers: a picture that covers others errs there, too, but
/// does not dilute its error. Pictures are compared over black and over white, and the larger error counts: what is
/// itself black or white is seen over the other.
inline SquaredError object_error(const Image& picture, const Image& reference) {
    std::int64_t over_black = 0, over_white = 0, covered = 0;
    for (std::size_t i = 0; i < reference.pixels().size(); ++i) {
        const Rgba8 p = picture.pixels()[i], q = reference.pixels()[i];
        covered += q.a > 0;
        const int alpha = int(p.a) - int(q.a);
        for (const int d : {int(p.r) - int(q.r), int(p.g) - int(q.g), int(p.b) - int(q.b)}) {
            over_black += d * d;
            over_white += (d - alpha) * (d - alpha);
        }
    }
    return {double(std::max(over_black, over_white)) / (3.0 * 255 * 255), double(covered)};
}

/// What lies in pages is another copy, which waits for them.
template <class H>
HeldHierarchy<H> whole_hierarchy(const H& hierarchy) {
    if constexpr (PagedAtRunTime<H>) {
        H copy(hierarchy);
        copy.wait_for_pages(true);
        return copy;
    } else {
        return hierarchy;
    }
}
template <class H>
std::uint64_t pages_loaded([[maybe_unused]] const H& hierarchy) {
    if constexpr (PagedAtRunTime<H>) {
        return hierarchy.cache_stats().loads;
    } else {
        return 0;
    }
}
inline void demand_all_pages(const FrameStats& stats) {
    if (stats.cells_missing == 0) return;
    fail<std::runtime_error>(
        "farfield::measure_error_table: pages are missing: frames want more than their cache holds, or they cannot be "
        "read");
}

template <class H, class P>
std::vector<Image> reference_pictures(const H& hierarchy, std::span<const P> primitives, std::span<const View> views,
                                      const ZBufferOptions& options) {
    ZBufferRenderer finest(options);
    Viewer<H, P, ZBufferRenderer> viewer(hierarchy, primitives, finest);
    std::vector<Image> pictures;
    for (View view : views) {
        view.tolerance_px = 0;
        demand_all_pages(viewer.frame(view));
        pictures.push_back(finest.image());
    }
    return pictures;
}

/// Draws a view and returns what that costs; a frame that pages were loaded for is drawn again.
template <class H, class V>
double cost_of_frame(const H& hierarchy, V& viewer, View view, float tolerance_px,
                     const std::optional<MeasuredTime>& prices) {
    using Clock = std::chrono::steady_clock;
    constexpr int most_attempts = 4;
    view.tolerance_px = tolerance_px;
    double seconds = 0;
    FrameStats stats;
    for (int attempt = 0; attempt < most_attempts; ++attempt) {
        const std::uint64_t loads = pages_loaded(hierarchy);
        const auto start = Clock::now();
        stats = viewer.frame(view);
        seconds = std::chrono::duration<double>(Clock::now() - start).count();
        demand_all_pages(stats);
        if (pages_loaded(hierarchy) == loads) break;
    }
    return prices ? double(prices->cost(work_of_frame(stats))) : seconds;
}

/// Frames of a viewer, against exact ones with many samples.
template <class H, class P, class R>
class ToleranceSubject {
  public:
    ToleranceSubject(const H& hierarchy, std::span<const P> primitives, R& renderer, std::span<const View> views,
                     const HierarchyErrorOptions& options)
        : hierarchy_(whole_hierarchy(hierarchy)),
          renderer_(renderer),
          viewer_(hierarchy_, primitives, renderer),
          views_(views),
          prices_(options.prices),
          references_(reference_pictures(hierarchy_, primitives, views, options.reference)) {}

    double draw(std::size_t i, float tolerance_px) {
        return cost_of_frame(hierarchy_, viewer_, views_[i], tolerance_px, prices_);
    }
    SquaredError error(std::size_t i) const { return object_error(renderer_.image(), references_[i]); }

  private:
    HeldHierarchy<H> hierarchy_;
    R& renderer_;
    Viewer<H, P, R> viewer_;
    std::span<const View> views_;
    std::optional<MeasuredTime> prices_;
    std::vector<Image> references_;
};

/// As above, with a viewer for each number of samples. They share what renderers share.
template <class H, class P, class R>
class SampledSubject {
  public:
    template <class MakeRenderer>
    SampledSubject(const H& hierarchy, std::span<const P> primitives, std::span<const int> samples, MakeRenderer&& make,
                   std::span<const View> views, const HierarchyErrorOptions& options)
        : hierarchy_(whole_hierarchy(hierarchy)),
          views_(views),
          references_(reference_pictures(hierarchy_, primitives, views, options.reference)) {
        for (const int count : samples) all_.add(hierarchy_, primitives, count, make);
    }

    double draw(std::size_t i, float tolerance_px, int samples) {
        last_ = samples;
        View view = views_[i];
        view.wanted.samples = samples;
        return cost_of_frame(hierarchy_, *all_.at(last_).viewer, view, tolerance_px, std::nullopt);
    }
    SquaredError error(std::size_t i) const { return object_error(all_.at(last_).renderer->image(), references_[i]); }

  private:
    HeldHierarchy<H> hierarchy_;
    std::span<const View> views_;
    std::vector<Image> references_;
    ViewersBySamples<H, P, R> all_;
    int last_ = 0;
};

/// Those that hold a hierarchy, where none are given.
template <class H>
std::vector<View> views_or_around(const H& hierarchy, std::span<const View> views) {
    if (!views.empty() || hierarchy.bounds().is_empty()) return {views.begin(), views.end()};
    return views_around({glm::dvec3(hierarchy.bounds().lower) + hierarchy.origin(),
                         glm::dvec3(hierarchy.bounds().upper) + hierarchy.origin()});
}

}  // namespace detail

/// Measures a hierarchy over its primitives, drawn with `renderer` at its own number of samples, in these views;
/// without any in views_around() its bounds. The views' own tolerances are not used. What is exact is the same
/// hierarchy at tolerance 0. Views that see little of the scene say little about it: give those that frames will be
/// like. Primitives of one in pages are its `primitives()`; std::runtime_error is thrown where its cache does not hold
/// what a frame wants. Throws what viewers and renderers throw, and as ErrorTable does.
template <class H, Primitive P, class R>
ErrorTable measure_error_table(const H& hierarchy, std::span<const P> primitives, R& renderer,
                               std::span<const View> views = {}, const HierarchyErrorOptions& options = {}) {
    const std::vector<View> all = detail::views_or_around(hierarchy, views);
    detail::ToleranceSubject<H, P, R> subject(hierarchy, primitives, renderer, all, options);
    return measure_error_table(subject, all.size(), options);
}

/// As above at several numbers of samples, by clock: make_renderer(samples) returns a renderer that draws with so many,
/// all of them alike but for that. Views that wanted errors are drawn in have the samples set. Throws
/// std::invalid_argument for numbers that do not ascend from 1 or more, before anything is drawn, and where frames are
/// to be priced by their counts, which do not tell what samples cost.
template <class H, Primitive P, class MakeRenderer>
SampledErrorTable measure_sampled_error_table(const H& hierarchy, std::span<const P> primitives,
                                              std::span<const int> samples, MakeRenderer&& make_renderer,
                                              std::span<const View> views = {},
                                              const HierarchyErrorOptions& options = {}) {
    const auto refuse = [](const char* why) {
        detail::fail<std::invalid_argument>(std::string("farfield::measure_sampled_error_table: ") + why);
    };
    bool ascends = !samples.empty();
    for (std::size_t i = 0; i < samples.size(); ++i) ascends = ascends && samples[i] > (i > 0 ? samples[i - 1] : 0);
    if (!ascends) refuse("numbers of samples must ascend from 1 or more");
    if (options.prices) refuse("prices do not tell what samples cost");
    using R = std::remove_cvref_t<decltype(make_renderer(samples[0]))>;
    const std::vector<View> all = detail::views_or_around(hierarchy, views);
    detail::SampledSubject<H, P, R> subject(hierarchy, primitives, samples, make_renderer, all, options);
    return measure_sampled_error_table(subject, samples, all.size(), options);
}

}  // namespace farfield
