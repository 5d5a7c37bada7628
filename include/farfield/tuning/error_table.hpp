// Which tolerance keeps the error that is wanted, and does it pay? A tolerance in pixels bounds how far a stand-in's
// outline is off; it does not say what the picture errs by, which depends on the scene and on the approximation. So the
// error is measured: a table of what pictures at a ladder of tolerances err by and cost, against exact geometry at many
// samples a pixel, answers for all frames that are like those it was measured on.
//
// Exact geometry at one sample a pixel errs, too: it aliases. An approximation that errs no more than that loses
// nothing, which is why point sampling is the default of what is wanted. A mean of squares forgives blur, though:
// where people look at the pictures, a ladder that ends at 4 px keeps stand-ins too small to be told apart.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "farfield/fail.hpp"
#include "farfield/wanted_error.hpp"

namespace farfield {

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
        if (const char* const why = obstacle(trials_, least_saving)) {
            detail::fail<std::invalid_argument>(std::string("farfield::ErrorTable: ") + why);
        }
    }
    /// What keeps such numbers from being a table; null if nothing does.
    static const char* obstacle(std::span<const ToleranceTrial> trials, double least_saving) {
        bool good = !trials.empty() && trials.front().tolerance_px == 0 && least_saving >= 0 && least_saving < 1;
        for (std::size_t i = 0; good && i < trials.size(); ++i) {
            const ToleranceTrial& t = trials[i];
            good = std::isfinite(t.tolerance_px) && t.rmse >= 0 && std::isfinite(t.rmse) && t.cost >= 0 &&
                   std::isfinite(t.cost) && (i == 0 || t.tolerance_px > trials[i - 1].tolerance_px);
        }
        return good ? nullptr
                    : "tolerances must ascend from 0, errors and costs be 0 or more, and the least saving from 0 to "
                      "below 1, all finite";
    }

    std::span<const ToleranceTrial> trials() const { return trials_; }
    double least_saving() const { return least_saving_; }
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

namespace detail {

/// What settings of a subject err by and cost over all views together.
struct MeasuredSettings {
    std::vector<SquaredError> errors;
    std::vector<double> costs;
};

/// draw(view, setting) draws and returns a cost, error(view) is that of what was drawn last. Settings of a view are
/// drawn in turns.
template <class Draw, class Error>
MeasuredSettings measured_in_turns(std::size_t views, std::size_t settings, const ErrorTableOptions& options,
                                   Draw&& draw, Error&& error) {
    using Clock = std::chrono::steady_clock;
    MeasuredSettings measured{std::vector<SquaredError>(settings), std::vector<double>(settings, 0)};
    for (std::size_t view = 0; view < views; ++view) {
        std::vector<double> least(settings, std::numeric_limits<double>::infinity()), spent(settings, 0);
        for (int round = 0; round < std::max(options.repetitions, 1); ++round) {
            for (std::size_t i = 0; i < settings; ++i) {
                if (round > 0 && spent[i] >= options.seconds) continue;
                const auto start = Clock::now();
                least[i] = std::min(least[i], draw(view, i));
                spent[i] += std::chrono::duration<double>(Clock::now() - start).count();
                if (round == 0) measured.errors[i] += error(view);
            }
        }
        for (std::size_t i = 0; i < settings; ++i) measured.costs[i] += least[i];
    }
    return measured;
}

/// Of as many settings as there are tolerances, exact before them, from the first of these on. Throws as ErrorTable.
inline ErrorTable table_of(const MeasuredSettings& measured, std::size_t first, const ErrorTableOptions& options) {
    std::vector<ToleranceTrial> trials;
    for (std::size_t i = 0; i <= options.tolerances_px.size(); ++i) {
        const SquaredError& error = measured.errors[first + i];
        const bool known = error.count > 0 && measured.costs[first] > 0;
        if (i > 0 && !known) break;
        trials.push_back({i > 0 ? options.tolerances_px[i - 1] : 0, error.root_mean(),
                          i > 0 ? measured.costs[first + i] / measured.costs[first] : 1});
    }
    return ErrorTable(std::move(trials), options.least_saving);
}

}  // namespace detail

/// Measures whatever draws: `subject.draw(view, tolerance_px)` draws the view of that number once, exactly at tolerance
/// 0, and returns what it costs (anything proportional to time); `subject.error(view)` is the SquaredError of what was
/// drawn last. Tolerances of a view are drawn in turns, so that a change of clock rate meets all. Without views, or
/// where these see nothing (a count of 0), only exact is in the table. Throws as ErrorTable does.
template <class Subject>
ErrorTable measure_error_table(Subject& subject, std::size_t views, const ErrorTableOptions& options = {}) {
    const auto measured = detail::measured_in_turns(
        views, options.tolerances_px.size() + 1, options,
        [&](std::size_t view, std::size_t i) {
            return subject.draw(view, i > 0 ? options.tolerances_px[i - 1] : 0.0f);
        },
        [&](std::size_t view) { return subject.error(view); });
    return detail::table_of(measured, 0, options);
}

}  // namespace farfield
