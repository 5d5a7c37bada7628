// How many samples a pixel, and which tolerance? Error has two sources: what stands in, and sampling. Many samples of
// coarse stand-ins may cost less than few of fine ones, or than exact geometry, at the same error; so pictures are
// measured at several numbers of samples, and of all that keep the error that is wanted the cheapest is taken.
//
// A renderer draws with one number of samples, which it is made with. Whoever draws asks before making one, or makes
// one for each and draws with the one that is chosen:
//
//     const auto choice = table.cheapest_for({.rmse = 0.03});
//     renderers.at(choice.samples) ... viewer.frame(choice.applied_to(view));
#pragma once

#include "farfield/settings.hpp"

#include <cmath>
#include <cstddef>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "farfield/fail.hpp"
#include "farfield/tuning/error_table.hpp"
#include "farfield/view.hpp"
#include "farfield/wanted_error.hpp"

namespace farfield {

/// What frames at one number of samples a pixel err by and cost.
struct ErrorsAtSamples {
    int samples = 1;
    double exact_cost = 1;  ///< of exact frames, in one unit for all numbers of samples
    ErrorTable table;
};

struct SampleChoice {
    int samples = 1;
    ToleranceChoice tolerance;
    double cost = 1;  ///< 1: that of exact at the fewest samples

    /// The view as it is to be drawn, by a renderer of so many samples.
    View applied_to(View view) const {
        view.tolerance_px = tolerance.trial.tolerance_px;
        view.wanted.samples = samples;
        return view;
    }
};

/// Tables by ascending number of samples. A value, as ErrorTable is.
class SampledErrorTable {
  public:
    /// Throws std::invalid_argument unless there is a table, samples ascend from 1 or more, and what exact frames cost
    /// is above 0 and finite.
    explicit SampledErrorTable(std::vector<ErrorsAtSamples> tables) : tables_(std::move(tables)) {
        if (const char* const why = obstacle(tables_)) {
            detail::fail<std::invalid_argument>(std::string("farfield::SampledErrorTable: ") + why);
        }
    }
    /// Of one number of samples.
    explicit SampledErrorTable(ErrorTable table, int samples = 1)
        : SampledErrorTable(std::vector<ErrorsAtSamples>{{samples, 1, std::move(table)}}) {}

    /// What keeps tables from being tables of several numbers of samples; null if nothing does.
    static const char* obstacle(std::span<const ErrorsAtSamples> tables) {
        bool good = !tables.empty();
        for (std::size_t i = 0; good && i < tables.size(); ++i) {
            good = tables[i].samples > (i > 0 ? tables[i - 1].samples : 0) && tables[i].exact_cost > 0 &&
                   std::isfinite(tables[i].exact_cost);
        }
        return good ? nullptr
                    : "there must be a table, numbers of samples must ascend from 1 or more, and costs of exact frames "
                      "be above 0 and finite";
    }

    std::span<const ErrorsAtSamples> tables() const { return tables_; }
    int fewest_samples() const { return tables_.front().samples; }

    /// What a renderer of so many samples chooses from. Throws std::invalid_argument if they were not measured.
    const ErrorTable& at(int samples) const {
        for (const ErrorsAtSamples& t : tables_) {
            if (t.samples == samples) return t.table;
        }
        detail::fail<std::invalid_argument>("farfield::SampledErrorTable: " + std::to_string(samples) +
                                            " samples a pixel were not measured");
    }

    /// Of what each number of samples chooses, the cheapest that keeps the error; of equals that of the fewest samples.
    /// Where none keeps it, exact at the samples where it errs least, and the reason says that the error cannot be had.
    /// No worse than point sampling means than exact at `wanted.samples`. Throws as at() and
    /// ErrorTable::tolerance_for().
    SampleChoice cheapest_for(WantedError wanted = {}) const {
        const double largest = wanted.rmse ? *wanted.rmse : at(wanted.samples).exact_rmse();
        const auto choice_of = [&](const ErrorsAtSamples& t) -> SampleChoice {
            const ToleranceChoice c = t.table.tolerance_for({.rmse = largest});
            return {t.samples, c, c.trial.cost * t.exact_cost / tables_.front().exact_cost};
        };
        const auto is_better = [](const SampleChoice& a, const SampleChoice& b) {
            const bool a_keeps = a.tolerance.keeps_error(), b_keeps = b.tolerance.keeps_error();
            if (a_keeps != b_keeps) return a_keeps;
            if (a_keeps) return a.cost < b.cost;
            return a.tolerance.trial.rmse < b.tolerance.trial.rmse;
        };
        SampleChoice best = choice_of(tables_.front());
        // Of nothing even times are not known: they are noise.
        if (best.tolerance.reason == ToleranceReason::nothing_tried) return best;
        for (const ErrorsAtSamples& t : tables_) {
            const SampleChoice choice = choice_of(t);
            if (is_better(choice, best)) best = choice;
        }
        return best;
    }

  private:
    std::vector<ErrorsAtSamples> tables_;
};

/// As measure_error_table(subject, ...), but `subject.draw(view, tolerance_px, samples)` draws with that many samples a
/// pixel, and all settings of a view are drawn in turns. Throws as SampledErrorTable and ErrorTable do.
template <class Subject>
SampledErrorTable measure_sampled_error_table(Subject& subject, std::span<const int> samples, std::size_t views,
                                              const ErrorTableOptions& options = {}) {
    const std::size_t rows = options.tolerances_px.size() + 1;
    const auto measured = detail::measured_in_turns(
        views, rows * samples.size(), options,
        [&](std::size_t view, std::size_t i) {
            const float tolerance_px = i % rows > 0 ? options.tolerances_px[i % rows - 1] : 0.0f;
            return subject.draw(view, tolerance_px, samples[i / rows]);
        },
        [&](std::size_t view) { return subject.error(view); });
    std::vector<ErrorsAtSamples> tables;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const double cost = measured.costs[i * rows];
        // Of what sees nothing nothing is known.
        tables.push_back({samples[i], cost > 0 ? cost : 1, detail::table_of(measured, i * rows, options)});
    }
    return SampledErrorTable(std::move(tables));
}

}  // namespace farfield
