// Which variant should a scene be drawn with, and at which tolerance? advise() tries them. Beside this header,
// calibrate.hpp, error_table.hpp and measure_error_table.hpp look at a clock, and no others.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "farfield/approximation/exact.hpp"
#include "farfield/cost_model/measured_time.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/fail.hpp"
#include "farfield/measure/image_error.hpp"
#include "farfield/measure/projected_rect.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/tuning/measure_error_table.hpp"
#include "farfield/tuning/variants.hpp"
#include "farfield/viewer.hpp"

namespace farfield {

struct AdviceOptions {
    std::vector<float> tolerances_px{0.5f, 1, 2, 4, 8};
    std::vector<int> samples{1, 4};  ///< a pixel; more samples are another way to be more exact
    int reference_samples = 64;      ///< a pixel, of the pictures that others are compared with
    int repetitions = 7;             ///< how often each frame is timed
    ZBufferOptions renderer{};       ///< its samples are not used
    /// If set, frames are priced by their counts instead of timed, so that the advice is the same on any machine. A
    /// frame with n samples then costs n times as much, which is too much.
    std::optional<MeasuredTime> prices{};
};

/// One way to draw the scene. Errors are root mean square errors of colors in [0, 1] over the scene's projected
/// rectangle, for the worst of several views.
struct Trial {
    std::string variant;
    float tolerance_px = 0;
    int samples = 1;
    double cost = 0;  ///< mean over the views it is chosen by; 1: every primitive in the frustum at one sample
    double rmse_chosen_by = 0;
    double rmse_held_out = 0;
    std::size_t hierarchy_bytes = 0;

    bool keeps(double largest_rmse) const { return rmse_chosen_by <= largest_rmse && rmse_held_out <= largest_rmse; }
};

struct Advice {
    std::vector<Trial> trials;    ///< cheapest first; in the order of the list where they cost the same
    std::optional<Trial> chosen;  ///< none: no trial keeps the error on all views
};

namespace detail {

/// Views 0, 2, 4 and so on decide what is cheap; the others are held out.
inline bool is_held_out(std::size_t view) {
    return view % 2 != 0;
}

template <Primitive P>
class Adviser {
    using Clock = std::chrono::steady_clock;
    using ExactHierarchy = SpatialHierarchy<Octree, Exact, TriangleCount>;

  public:
    Adviser(std::span<const P> primitives, std::span<const View> views, const AdviceOptions& options)
        : primitives_(primitives),
          views_(views),
          options_(options),
          exact_(build<ExactHierarchy>(primitives)),
          exact_renderer_(with_samples(1)),
          exact_viewer_(exact_, primitives, exact_renderer_) {
        ZBufferRenderer renderer(with_samples(options.reference_samples));
        auto viewer = make_viewer(exact_, primitives, renderer);
        BoxD bounds = BoxD::empty();
        if (!exact_.bounds().is_empty()) {
            bounds = {glm::dvec3(exact_.bounds().lower) + exact_.origin(),
                      glm::dvec3(exact_.bounds().upper) + exact_.origin()};
        }
        for (const View& view : views) {
            viewer.frame(view);
            references_.push_back(renderer.image());
            rects_.push_back(projected_rect(bounds, view));
        }
    }

    template <class V>
    void add(const V& variant, std::vector<Trial>& trials) {
        const auto hierarchy = variant.build(primitives_);
        for (const int samples : options_.samples) {
            ZBufferRenderer renderer(with_samples(samples));
            auto viewer = make_viewer(hierarchy, primitives_, renderer);
            for (const float tolerance_px : options_.tolerances_px) {
                Trial trial{variant.name, tolerance_px, samples};
                trial.hierarchy_bytes = hierarchy.bytes();
                try_out(viewer, renderer, trial);
                trials.push_back(std::move(trial));
                if constexpr (!V::hierarchy_type::approximation_type::facts.stands_in) break;  // no tolerance matters
            }
        }
    }

  private:
    ZBufferOptions with_samples(int samples) const {
        ZBufferOptions o = options_.renderer;
        o.samples = samples;
        return o;
    }

    template <class AnyViewer>
    void try_out(AnyViewer& viewer, const ZBufferRenderer& renderer, Trial& trial) {
        std::size_t chosen_by = 0;
        for (std::size_t i = 0; i < views_.size(); ++i) {
            View view = views_[i];
            view.tolerance_px = trial.tolerance_px;
            const FrameStats stats = viewer.frame(view);
            const double error = rmse(renderer.image(), references_[i], rects_[i]);
            double& worst = is_held_out(i) ? trial.rmse_held_out : trial.rmse_chosen_by;
            worst = std::max(worst, error);
            if (is_held_out(i)) continue;
            ++chosen_by;
            trial.cost += options_.prices ? priced(stats, trial.samples, view) : timed(viewer, view);
        }
        trial.cost /= double(chosen_by);
    }

    double priced(const FrameStats& stats, int samples, const View& view) {
        const auto price = [&](const FrameStats& s) { return double(options_.prices->cost(work_of_frame(s))); };
        const double exact = price(exact_viewer_.frame(view));
        return exact > 0 ? price(stats) * samples / exact : 1;
    }

    /// Frames take turns, so that a change of clock rate meets both.
    template <class AnyViewer>
    double timed(AnyViewer& viewer, const View& view) {
        const auto seconds = [&](auto& v) {
            const auto start = Clock::now();
            v.frame(view);
            return std::chrono::duration<double>(Clock::now() - start).count();
        };
        std::vector<double> ratios;
        for (int i = 0; i < std::max(options_.repetitions, 1); ++i) {
            const double exact = seconds(exact_viewer_);
            ratios.push_back(seconds(viewer) / exact);
        }
        const auto middle = ratios.begin() + std::ptrdiff_t(ratios.size() / 2);
        std::nth_element(ratios.begin(), middle, ratios.end());
        return *middle;
    }

    std::span<const P> primitives_;
    std::span<const View> views_;
    const AdviceOptions& options_;
    ExactHierarchy exact_;
    ZBufferRenderer exact_renderer_;
    Viewer<ExactHierarchy, P, ZBufferRenderer> exact_viewer_;
    std::vector<Image> references_;
    std::vector<std::optional<PixelRect>> rects_;
};

}  // namespace detail

/// Tries every variant of a list (variants.hpp) with every tolerance and number of samples, and names the cheapest that
/// keeps the error on all views. The first, third and so on of the views decide what is cheap; the others check the
/// choice. The views' own tolerances are not used. Draws with the software z-buffer; one hierarchy exists at a time
/// beside the exact one. Costs are ratios of pairs of frames drawn one after the other.
///
/// Throws std::invalid_argument for fewer than two views, an error that is not above 0, or options without a tolerance
/// or a number of samples, and everything that build, viewers and renderers throw.
template <Primitive P, class... V>
Advice advise(std::span<const P> primitives, std::span<const View> views, double largest_rmse,
              const std::tuple<V...>& variants, const AdviceOptions& options = {}) {
    if (views.size() < 2) {
        detail::fail<std::invalid_argument>(
            "farfield::advise: needs two views at least, one to choose by and one held out");
    }
    if (!(largest_rmse > 0)) detail::fail<std::invalid_argument>("farfield::advise: the largest error must be above 0");
    if (options.tolerances_px.empty() || options.samples.empty()) {
        detail::fail<std::invalid_argument>(
            "farfield::advise: the options hold no tolerance or no number of samples to try");
    }
    detail::Adviser<P> adviser(primitives, views, options);
    Advice advice;
    for_each_variant(variants, [&](const auto& variant) { adviser.add(variant, advice.trials); });
    std::stable_sort(advice.trials.begin(), advice.trials.end(),
                     [](const Trial& a, const Trial& b) { return a.cost < b.cost; });
    const auto best =
        std::find_if(advice.trials.begin(), advice.trials.end(), [&](const Trial& t) { return t.keeps(largest_rmse); });
    if (best != advice.trials.end()) advice.chosen = *best;
    return advice;
}

}  // namespace farfield
