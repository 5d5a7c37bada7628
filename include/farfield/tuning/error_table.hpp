// Which tolerance keeps the error that is wanted, and does it pay? A tolerance in pixels bounds how far a stand-in's
// outline is off; it does not say what the picture errs by, which depends on the scene and on the approximation. So the
// error is measured: a table of what pictures at a ladder of tolerances err by and cost, against exact geometry at many
// samples a pixel, answers for all frames that are like those it was measured on.
//
// Exact geometry at one sample a pixel errs, too: it aliases. An approximation that errs no more than that loses
// nothing, which is why point sampling is the default of what is wanted.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "farfield/cost_model/measured_time.hpp"
#include "farfield/fail.hpp"
#include "farfield/geometry/box.hpp"
#include "farfield/image.hpp"
#include "farfield/primitive.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/view.hpp"
#include "farfield/viewer.hpp"

namespace farfield {

/// The largest error that a picture may have.
struct WantedError {
    /// A root mean square error as ToleranceTrial's. None: no worse than point sampling, which is what exact geometry
    /// errs by at as many samples a pixel.
    std::optional<double> rmse{};
};

/// What frames at one tolerance err by and cost.
struct ToleranceTrial {
    float tolerance_px = 0;  ///< 0: exact
    double rmse = 0;         ///< of channels in [0, 1], over the pixels that the objects take in all views together
    double cost = 1;         ///< of all views together; 1: exact's
};

enum class ToleranceReason : std::uint8_t {
    pays,           ///< the tolerance keeps the wanted error and costs less than exact
    only_way,       ///< it keeps the wanted error and costs no less than exact, which does not keep it
    nothing_pays,   ///< exact: tolerances keep the wanted error, but none costs less
    nothing_keeps,  ///< exact: it keeps the wanted error, and no tolerance does
    cannot_be_had,  ///< exact: it errs more than is wanted, and so does every tolerance
    nothing_tried,  ///< exact: there was nothing to see, so nothing is known
};

struct ToleranceChoice {
    ToleranceTrial trial;  ///< what to expect
    ToleranceReason reason = ToleranceReason::nothing_tried;

    bool is_exact() const { return !(trial.tolerance_px > 0); }
    bool keeps_error() const { return reason != ToleranceReason::cannot_be_had; }
};

/// Trials by ascending tolerance, exact first. A value: whoever measures otherwise than this header does may make one.
class ErrorTable {
  public:
    /// `least_saving`: a tolerance pays if it costs less than exact by this part, below which times are noise. Throws
    /// std::invalid_argument unless tolerances ascend from 0, and errors and costs are 0 or more and finite.
    explicit ErrorTable(std::vector<ToleranceTrial> trials, double least_saving = 0.05)
        : trials_(std::move(trials)), least_saving_(least_saving) {
        bool good = !trials_.empty() && trials_.front().tolerance_px == 0 && least_saving >= 0 && least_saving < 1;
        for (std::size_t i = 0; good && i < trials_.size(); ++i) {
            const ToleranceTrial& t = trials_[i];
            good = std::isfinite(t.tolerance_px) && t.rmse >= 0 && std::isfinite(t.rmse) && t.cost >= 0 &&
                   std::isfinite(t.cost) && (i == 0 || t.tolerance_px > trials_[i - 1].tolerance_px);
        }
        if (!good) {
            detail::fail<std::invalid_argument>(
                "farfield::ErrorTable: tolerances must ascend from 0, errors and costs be 0 or more and finite, and "
                "the "
                "least saving be from 0 to below 1");
        }
    }

    std::span<const ToleranceTrial> trials() const { return trials_; }
    /// What point sampling errs by.
    double exact_rmse() const { return trials_.front().rmse; }

    /// The largest tolerance that pays, of those that keep the error together with all between them and the one that
    /// errs least, so that a coarse one that is right by luck is not taken. Exact where none pays. The less error is
    /// wanted, the smaller the tolerance of trials that pay, and the less the largest error up to it: those that keep a
    /// smaller error are among those that keep a larger one. Throws std::invalid_argument for an error below 0.
    ToleranceChoice tolerance_for(WantedError wanted = {}) const {
        const double largest = wanted.rmse.value_or(exact_rmse());
        if (!(largest >= 0)) detail::fail<std::invalid_argument>("farfield::ErrorTable: wanted errors are 0 or more");
        const auto least = std::min_element(trials_.begin(), trials_.end(),
                                            [](const auto& a, const auto& b) { return a.rmse < b.rmse; });
        const auto end = std::find_if_not(least, trials_.end(), [&](const auto& t) { return t.rmse <= largest; });
        if (least == end) return {trials_.front(), ToleranceReason::cannot_be_had};
        for (auto t = end; t != least;) {
            if (pays(*--t)) return {*t, ToleranceReason::pays};
        }
        if (exact_rmse() > largest) return {*(end - 1), ToleranceReason::only_way};
        if (trials_.size() == 1) return {trials_.front(), ToleranceReason::nothing_tried};
        const bool exact_alone = end - 1 == trials_.begin();
        return {trials_.front(), exact_alone ? ToleranceReason::nothing_keeps : ToleranceReason::nothing_pays};
    }

  private:
    bool pays(const ToleranceTrial& t) const { return t.tolerance_px > 0 && t.cost <= 1 - least_saving_; }

    std::vector<ToleranceTrial> trials_;
    double least_saving_;
};

/// Factors of the square root of 2, beginning with the first and ending with the last at most.
inline std::vector<float> tolerance_ladder(float first_px, float last_px) {
    std::vector<float> ladder;
    for (int half_octave = 0;; ++half_octave) {
        const float step = std::ldexp(half_octave % 2 != 0 ? std::numbers::sqrt2_v<float> : 1.0f, half_octave / 2);
        if (!(first_px > 0 && first_px * step <= last_px && std::isfinite(step))) return ladder;
        ladder.push_back(first_px * step);
    }
}

struct ErrorTableOptions {
    std::vector<float> tolerances_px = tolerance_ladder(0.25f, 16);  ///< above 0, ascending; exact is tried, too
    int repetitions = 5;         ///< of each frame at most: the least of its costs counts, for others were interrupted
    double seconds = 0.25;       ///< a frame that took as long in all is not repeated
    double least_saving = 0.05;  ///< as ErrorTable's
    /// If set, frames are priced by their counts instead of timed, so that the table is the same on any machine.
    std::optional<MeasuredTime> prices{};
    /// Of the pictures that others are compared with. Light and culling must be those of the renderer.
    ZBufferOptions reference{.samples = 64};
};

/// Squares summed over so many things, as pixels. Sums of several views may be added.
struct SquaredError {
    double sum = 0, count = 0;

    SquaredError& operator+=(const SquaredError& other) {
        sum += other.sum;
        count += other.count;
        return *this;
    }
    double root_mean() const { return count > 0 ? std::sqrt(sum / count) : 0; }
};

/// Measures whatever draws: `subject.draw(view, tolerance_px)` draws the view of that number once, exactly at tolerance
/// 0, and returns what it costs (anything proportional to time); `subject.error(view)` is the SquaredError of what was
/// drawn last. Tolerances of a view are drawn in turns, so that a change of clock rate meets all. Without views, or
/// where these see nothing (a count of 0), only exact is in the table. Throws as ErrorTable does.
template <class Subject>
ErrorTable measure_error_table(Subject& subject, std::size_t views, const ErrorTableOptions& options = {}) {
    using Clock = std::chrono::steady_clock;
    std::vector<float> tolerances{0};
    tolerances.insert(tolerances.end(), options.tolerances_px.begin(), options.tolerances_px.end());
    std::vector<SquaredError> errors(tolerances.size());
    std::vector<double> costs(tolerances.size(), 0);
    for (std::size_t view = 0; view < views; ++view) {
        std::vector<double> least(tolerances.size(), std::numeric_limits<double>::infinity());
        std::vector<double> spent(tolerances.size(), 0);
        for (int round = 0; round < std::max(options.repetitions, 1); ++round) {
            for (std::size_t i = 0; i < tolerances.size(); ++i) {
                if (round > 0 && spent[i] >= options.seconds) continue;
                const auto start = Clock::now();
                least[i] = std::min(least[i], subject.draw(view, tolerances[i]));
                spent[i] += std::chrono::duration<double>(Clock::now() - start).count();
                if (round == 0) errors[i] += subject.error(view);
            }
        }
        for (std::size_t i = 0; i < tolerances.size(); ++i) costs[i] += least[i];
    }
    std::vector<ToleranceTrial> trials;
    for (std::size_t i = 0; i < tolerances.size(); ++i) {
        const bool known = errors[i].count > 0 && costs[0] > 0;
        if (i > 0 && !known) break;
        trials.push_back({tolerances[i], errors[i].root_mean(), i > 0 ? costs[i] / costs[0] : 1});
    }
    return ErrorTable(std::move(trials), options.least_saving);
}

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
                     const ErrorTableOptions& options)
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
                               std::span<const View> views = {}, const ErrorTableOptions& options = {}) {
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
