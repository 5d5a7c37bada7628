// "Faster at equal error": an error is fixed, and the tolerance follows.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

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

/// Of one variant, the fastest row whose error is at most `bound`: of the largest tolerance that keeps it at each
/// number of samples. Chosen from what was measured, nothing lies between. Null if none keeps the bound.
inline const Row* fastest_within(const std::vector<const Row*>& rows, std::string_view variant, Row::Number Row::*error,
                                 double bound) {
    std::vector<const Row*> coarsest;  // at each number of samples
    for (const Row* row : rows) {
        if (row->variant != variant || !row->speedup || !(row->*error) || !(*(row->*error) <= bound)) continue;
        const auto same = std::find_if(coarsest.begin(), coarsest.end(),
                                       [&](const Row* other) { return other->samples == row->samples; });
        if (same == coarsest.end()) {
            coarsest.push_back(row);
        } else if (row->tolerance_px > (*same)->tolerance_px) {
            *same = row;
        }
    }
    const auto fastest = std::max_element(coarsest.begin(), coarsest.end(),
                                          [](const Row* a, const Row* b) { return *a->speedup < *b->speedup; });
    return fastest == coarsest.end() ? nullptr : *fastest;
}

/// What is gained over drawing everything, where both keep the bound: the times of one run, each against the exact
/// frame drawn right before it. None where one of them does not keep it.
inline Row::Number speedup_at_equal_error(const Row* variant, const Row* exact) {
    if (!variant || !exact || !variant->speedup || !exact->speedup || !(*exact->speedup > 0)) return std::nullopt;
    return *variant->speedup / *exact->speedup;
}

}  // namespace farfield::bench
