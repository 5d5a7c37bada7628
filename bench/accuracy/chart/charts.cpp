#include "charts.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

#include "pareto.hpp"
#include "pictures.hpp"
#include "summary.hpp"

namespace farfield::bench {
namespace {

using Field = Row::Number Row::*;

/// A variant at one number of samples; without a tolerance at all of them, which is 0.
using Line = std::pair<std::string, double>;

Line line_of(const Row& row) {
    return {row.variant, row.tolerance_px ? row.samples.value_or(1) : 0};
}

/// Of the variants, best first, with what they are compared with at the head.
std::vector<std::string> ranked(std::vector<std::string> variants, const std::map<std::string, double>& speedups) {
    const auto rank = [&](const std::string& variant) {
        const auto speedup = speedups.find(variant);
        const int kind = variant == "exact" ? 0 : variant == "peer" ? 1 : 2;
        return std::pair(kind, speedup == speedups.end() ? 0 : -speedup->second);
    };
    std::stable_sort(variants.begin(), variants.end(),
                     [&](const std::string& a, const std::string& b) { return rank(a) < rank(b); });
    return variants;
}

/// What is shown at a glance, a line a variant.
std::vector<Line> best_lines(const std::vector<const Row*>& rows) {
    std::map<std::string, double> speedups;
    std::map<std::string, Line> lines;
    for (const Row* row : rows) lines.try_emplace(row->variant, line_of(*row));
    for (const auto& [variant, line] : lines) {
        const EqualErrorChoice choice = at_equal_error(rows, variant, &Row::rmse);
        if (choice.is_exact()) continue;
        speedups[variant] = *choice.row->speedup;
        lines[variant] = line_of(*choice.row);
    }
    std::vector<Line> best;
    for (const std::string& variant : ranked(variant_names(rows), speedups)) {
        if (best.size() + 1 < most_lines) best.push_back(lines[variant]);  // one is the front's
    }
    return best;
}

/// A series for each of the lines.
class PanelMaker {
  public:
    PanelMaker(const std::vector<const Row*>& rows, const std::vector<Line>& lines, Field x, Field y)
        : rows_(rows), lines_(lines), x_(x), y_(y) {}

    Panel panel(std::string x_label, std::string y_label) const {
        Panel panel{std::move(x_label), std::move(y_label), 'x', {}};
        for (const Line& line : lines_) {
            Series series{line.first, {}, line.second};
            for (const Row* row : sorted_rows(line)) {
                if (series.points.empty()) series.samples = row->samples.value_or(1);
                add(*row, series);
            }
            if (!series.points.empty()) panel.series.push_back(std::move(series));
        }
        Series all;
        for (const Row* row : rows_) add(*row, all);
        std::vector<ChartPoint> points;
        for (const auto& point : all.points) points.push_back({point[0], point[1]});
        for (const std::size_t i : pareto_front(points)) panel.front.push_back(points[i]);
        return panel;
    }

  private:
    /// A line goes from the finest to the coarsest.
    std::vector<const Row*> sorted_rows(const Line& line) const {
        std::vector<const Row*> rows;
        std::copy_if(rows_.begin(), rows_.end(), std::back_inserter(rows),
                     [&](const Row* row) { return line_of(*row) == line; });
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
    const std::vector<Line>& lines_;
    Field x_, y_;
};

void add_chart(std::vector<Chart>& charts, Chart chart) {
    std::erase_if(chart.panels, [](const Panel& panel) { return panel.series.empty(); });
    if (!chart.panels.empty()) charts.push_back(std::move(chart));
}

void add_accuracy(std::vector<Chart>& charts, const ViewGroup& group) {
    const std::string title = group.scene + " from " + group.view, name = file_name(group.scene + "_" + group.view);
    const std::vector<Line> lines = best_lines(group.rows);
    const auto panel = [&](Field x, Field y, const char* x_label, const char* y_label) {
        return PanelMaker(group.rows, lines, x, y).panel(x_label, y_label);
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
    Panel panel{"triangles", "milliseconds a frame", 'y', {}};
    std::map<std::string, double> speedups;  // over most primitives, which are last
    for (const Row* row : group.rows) speedups[row->variant] = row->speedup.value_or(0);
    for (const std::string& variant : ranked(variant_names(group.rows), speedups)) {
        Series measured{variant, {}, 1}, extrapolated{variant + ", extrapolated", {}, 1};
        for (const Row* row : group.rows) {
            if (row->variant != variant || !row->triangles || !row->time_ms || !(*row->time_ms > 0)) continue;
            const double y = *row->time_ms;
            (row->note.empty() ? measured : extrapolated)
                .points.push_back({*row->triangles, y, row->time_ms_first_quartile.value_or(y),
                                   row->time_ms_third_quartile.value_or(y)});
        }
        for (Series* series : {&measured, &extrapolated}) {
            if (!series->points.empty() && panel.series.size() < most_lines) panel.series.push_back(std::move(*series));
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
