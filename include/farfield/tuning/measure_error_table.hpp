// Measures an ErrorTable of a hierarchy: what its far field errs by and costs, in views that are given or chosen.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "farfield/cost_model/measured_time.hpp"
#include "farfield/geometry/box.hpp"
#include "farfield/image.hpp"
#include "farfield/primitive.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/tuning/error_table.hpp"
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

/// Frames of a viewer, against exact ones with many samples.
template <class H, class P, class R>
class ToleranceSubject {
  public:
    ToleranceSubject(const H& hierarchy, std::span<const P> primitives, R& renderer, std::span<const View> views,
                     const HierarchyErrorOptions& options)
        : renderer_(renderer), viewer_(hierarchy, primitives, renderer), views_(views), prices_(options.prices) {
        ZBufferRenderer finest(options.reference);
        Viewer<H, P, ZBufferRenderer> viewer(hierarchy, primitives, finest);
        for (View view : views) {
            view.tolerance_px = 0;
            viewer.frame(view);
            references_.push_back(finest.image());
        }
    }

    double draw(std::size_t i, float tolerance_px) {
        using Clock = std::chrono::steady_clock;
        View view = views_[i];
        view.tolerance_px = tolerance_px;
        const auto start = Clock::now();
        const FrameStats stats = viewer_.frame(view);
        if (!prices_) return std::chrono::duration<double>(Clock::now() - start).count();
        return double(prices_->cost(work_of_frame(stats)));
    }
    SquaredError error(std::size_t i) const { return object_error(renderer_.image(), references_[i]); }

  private:
    R& renderer_;
    Viewer<H, P, R> viewer_;
    std::span<const View> views_;
    std::optional<MeasuredTime> prices_;
    std::vector<Image> references_;
};

}  // namespace detail

/// Measures a hierarchy over its primitives, drawn with `renderer` at its own number of samples, in these views;
/// without any in views_around() its bounds. The views' own tolerances are not used. What is exact is the same
/// hierarchy at tolerance 0. Views that see little of the scene say little about it: give those that frames will be
/// like. Throws what viewers and renderers throw, and as ErrorTable does.
template <class H, Primitive P, class R>
ErrorTable measure_error_table(const H& hierarchy, std::span<const P> primitives, R& renderer,
                               std::span<const View> views = {}, const HierarchyErrorOptions& options = {}) {
    std::vector<View> around;
    if (views.empty() && !hierarchy.bounds().is_empty()) {
        around = views_around({glm::dvec3(hierarchy.bounds().lower) + hierarchy.origin(),
                               glm::dvec3(hierarchy.bounds().upper) + hierarchy.origin()});
        views = around;
    }
    detail::ToleranceSubject<H, P, R> subject(hierarchy, primitives, renderer, views, options);
    return measure_error_table(subject, views.size(), options);
}

}  // namespace farfield
