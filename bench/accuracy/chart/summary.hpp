// "At equal error": an error is wanted, and what is drawn follows.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "farfield/tuning/error_table.hpp"
#include "row.hpp"

namespace farfield::bench {

/// All that is drawn of one scene from one place.
struct ViewGroup {
    std::string scene, view;
    std::vector<const Row*> rows;  ///< point into what was grouped
};

/// Rows of a chart (`accuracy` or `growth`) by scene and view, in order of appearance.
inline std::vector<ViewGroup> by_view(const std::vector<Row>& rows, std::string_view chart) {
    std::vector<ViewGroup> groups;
    for (const Row& row : rows) {
        if (row.chart != chart) continue;
        auto group = std::find_if(groups.begin(), groups.end(),
                                  [&](const ViewGroup& g) { return g.scene == row.scene && g.view == row.view; });
        if (group == groups.end()) group = groups.insert(groups.end(), ViewGroup{row.scene, row.view, {}});
        group->rows.push_back(&row);
    }
    return groups;
}

inline std::vector<std::string> variant_names(const std::vector<const Row*>& rows) {
    std::vector<std::string> names;
    for (const Row* row : rows) {
        if (std::find(names.begin(), names.end(), row->variant) == names.end()) names.push_back(row->variant);
    }
    return names;
}

/// Has what an error table is made of.
inline bool is_comparable(const Row& row, Row::Number Row::*error) {
    const Row::Number& e = row.*error;
    return e && *e >= 0 && std::isfinite(*e) && row.speedup && *row.speedup > 0 && std::isfinite(*row.speedup);
}

/// Exact with the fewest samples that keep the bound, noise may make more of them look faster; without a bound at one
/// sample a pixel. Null if there is none.
inline const Row* exact_within(const std::vector<const Row*>& rows, Row::Number Row::*error,
                               std::optional<double> bound) {
    const Row* exact = nullptr;
    for (const Row* row : rows) {
        if (row->variant != "exact" || !is_comparable(*row, error)) continue;
        if (bound ? !(*(row->*error) <= *bound) : row->samples != 1) continue;
        if (!exact || row->samples < exact->samples) exact = row;
    }
    return exact;
}

/// What is drawn where an error is wanted of a variant.
struct EqualErrorChoice {
    const Row* row = nullptr;  ///< of the variant, or exact at one sample a pixel; null: neither keeps the error
    ToleranceReason reason = ToleranceReason::nothing_tried;

    bool is_exact() const { return reason != ToleranceReason::pays && reason != ToleranceReason::only_way; }
};

/// By ErrorTable::tolerance_for, as the programs choose, at the number of samples where that is fastest: chosen from
/// what was measured, nothing lies between. Without `wanted`: no worse than exact at one sample a pixel.
inline EqualErrorChoice at_equal_error(const std::vector<const Row*>& rows, std::string_view variant,
                                       Row::Number Row::*error, std::optional<double> wanted = std::nullopt) {
    const Row* const exact = exact_within(rows, error, std::nullopt);
    if (!exact) return {};
    std::vector<const Row*> ours;
    for (const Row* row : rows) {
        if (row->variant == variant && is_comparable(*row, error)) ours.push_back(row);
    }
    std::stable_sort(ours.begin(), ours.end(), [](const Row* a, const Row* b) {
        return a->samples != b->samples ? a->samples < b->samples : a->tolerance_px < b->tolerance_px;
    });
    EqualErrorChoice best;
    for (auto first = ours.begin(); first != ours.end();) {
        const auto last =
            std::find_if(first, ours.end(), [&](const Row* row) { return row->samples != (*first)->samples; });
        // Tolerances only order the table, and what takes none has a place in it, too: trials are numbered.
        std::vector<ToleranceTrial> trials{{0, *(exact->*error), 1}};
        for (auto row = first; row != last; ++row) {
            trials.push_back({float(trials.size()), *((*row)->*error), 1 / *(*row)->speedup});
        }
        const ToleranceChoice choice = ErrorTable(std::move(trials)).tolerance_for({wanted});
        const EqualErrorChoice here{
            choice.is_exact() ? (choice.keeps_error() ? exact : nullptr) : first[int(choice.trial.tolerance_px) - 1],
            choice.reason};
        const bool is_better = best.is_exact() && (!here.is_exact() || here.reason < best.reason);
        if (is_better || (!best.is_exact() && !here.is_exact() && *here.row->speedup > *best.row->speedup)) best = here;
        first = last;
    }
    return best;
}

}  // namespace farfield::bench
