#include "charts.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

#include "summary.hpp"

namespace farfield::bench {
namespace {

using Field = Row::Number Row::*;

std::string file_name(std::string text) {
    for (char& c : text) {
        if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '-' && c != '.') c = '_';
    }
    return text;
}

/// A series for each variant and number of samples, in order of the rows.
class PanelMaker {
  public:
    PanelMaker(const std::vector<const Row*>& rows, Field x, Field y) : rows_(rows), x_(x), y_(y) {}

    Panel panel(std::string x_label, std::string y_label) const {
        Panel panel{std::move(x_label), std::move(y_label), 'x', true, {}};
        for (const std::string& variant : variant_names(rows_)) {
            std::map<double, Series> by_samples;
            for (const Row* row : sorted_rows(variant)) {
                // Without a tolerance the line is that of the numbers of samples.
                const double samples = row->samples.value_or(1), line = row->tolerance_px ? samples : 0;
                Series& series = by_samples.try_emplace(line, Series{variant, {}, samples}).first->second;
                add(*row, series);
            }
            for (auto& [samples, series] : by_samples) {
                if (!series.points.empty()) panel.series.push_back(std::move(series));
            }
        }
        return panel;
    }

  private:
    /// A line goes from the finest to the coarsest.
    std::vector<const Row*> sorted_rows(const std::string& variant) const {
        std::vector<const Row*> rows;
        std::copy_if(rows_.begin(), rows_.end(), std::back_inserter(rows),
                     [&](const Row* row) { return row->variant == variant; });
        std::stable_sort(rows.begin(), rows.end(), [](const Row* a, const Row* b) {
            return std::pair(b->samples, a->tolerance_px) < std::pair(a->samples, b->tolerance_px);
        });
        return rows;
    }

    void add(const Row& row, Series& series) const {
        const Row::Number &x = row.*x_, &y = row.*y_;
        if (!x || !y || !(*x > 0) || !(*y > 0) || !std::isfinite(*x) || !std::isfinite(*y)) return;
        double low = *x, high = *x;
        if (x_ == &Row::time_ms) {
            low = row.time_ms_first_quartile.value_or(low);
            high = row.time_ms_third_quartile.value_or(high);
        }
        series.points.push_back({*x, *y, low, high});
    }

    const std::vector<const Row*>& rows_;
    Field x_, y_;
};

void add_chart(std::vector<Chart>& charts, Chart chart) {
    std::erase_if(chart.panels, [](const Panel& panel) { return panel.series.empty(); });
    if (!chart.panels.empty()) charts.push_back(std::move(chart));
}

void add_accuracy(std::vector<Chart>& charts, const ViewGroup& group) {
    const std::string title = group.scene + " from " + group.view, name = file_name(group.scene + "_" + group.view);
    const auto panel = [&](Field x, Field y, const char* x_label, const char* y_label) {
        return PanelMaker(group.rows, x, y).panel(x_label, y_label);
    };
    add_chart(charts, {"time_" + name,
                       group.scene,
                       title + ": time against error",
                       {panel(&Row::time_ms, &Row::rmse, "milliseconds a frame", "RMSE"),
                        panel(&Row::time_ms, &Row::flip, "milliseconds a frame", "FLIP")}});
    add_chart(charts, {"memory_" + name,
                       group.scene,
                       title + ": memory against error",
                       {panel(&Row::hierarchy_bytes, &Row::rmse, "bytes of hierarchy", "RMSE"),
                        panel(&Row::touched_bytes, &Row::rmse, "bytes of it read in a frame", "RMSE")}});
}

void add_growth(std::vector<Chart>& charts, const ViewGroup& group) {
    Panel panel{"triangles", "milliseconds a frame", 'y', false, {}};
    for (const std::string& variant : variant_names(group.rows)) {
        Series measured{variant, {}, 1}, extrapolated{variant + ", extrapolated", {}, 1};
        for (const Row* row : group.rows) {
            if (row->variant != variant || !row->triangles || !row->time_ms || !(*row->time_ms > 0)) continue;
            const double y = *row->time_ms;
            (row->note.empty() ? measured : extrapolated)
                .points.push_back({*row->triangles, y, row->time_ms_first_quartile.value_or(y),
                                   row->time_ms_third_quartile.value_or(y)});
        }
        for (Series* series : {&measured, &extrapolated}) {
            if (!series->points.empty()) panel.series.push_back(std::move(*series));
        }
    }
    add_chart(charts, {"growth_" + file_name(group.scene + "_" + group.view),
                       group.scene,
                       group.scene + ", " + group.view + ": time against number of primitives",
                       {std::move(panel)}});
}

}  // namespace

std::vector<Chart> charts_of(const std::vector<Row>& rows) {
    std::vector<Chart> charts;
    for (const ViewGroup& group : by_view(rows, "accuracy")) add_accuracy(charts, group);
    for (const ViewGroup& group : by_view(rows, "growth")) add_growth(charts, group);
    return charts;
}

}  // namespace farfield::bench
