#include "../../bench/accuracy/chart/charts.cpp"

#include <algorithm>
#include <string>

#include "catch.hpp"

using namespace farfield::bench;

namespace {

Row measured(std::string chart, std::string variant, double samples, Row::Number tolerance_px, double speedup,
             double rmse) {
    Row row;
    row.chart = std::move(chart);
    row.scene = "tree";
    row.view = "7 radii";
    row.variant = std::move(variant);
    row.samples = samples;
    row.tolerance_px = tolerance_px;
    row.triangles = 100 * samples;
    row.speedup = speedup;
    row.time_ms = 10 / speedup;
    row.rmse = row.flip = rmse;
    return row;
}

/// Variants v0, v1, ... by rising speed, at two tolerances and two numbers of samples, and what they are compared with.
std::vector<Row> many() {
    std::vector<Row> rows;
    for (int v = 0; v < 9; ++v) {
        for (const double samples : {1.0, 4.0}) {
            for (const double tolerance_px : {1.0, 2.0}) {
                rows.push_back(measured("accuracy", "v" + std::to_string(v), samples, tolerance_px,
                                        (1.2 + v) * tolerance_px / samples, 0.04 * tolerance_px / samples));
            }
        }
    }
    for (const double samples : {1.0, 4.0, 16.0}) {
        rows.push_back(measured("accuracy", "exact", samples, {}, 1 / samples, 0.1 / samples));
        rows.push_back(measured("accuracy", "peer", samples, {}, 0.5 / samples, 0.1 / samples));
    }
    rows.push_back(measured("accuracy", "fast", 1, 8, 1000, 0.9));  // but it errs more than exact does
    return rows;
}

std::vector<std::string> labels(const Panel& panel) {
    std::vector<std::string> result;
    for (const Series& series : panel.series) result.push_back(series.label);
    return result;
}

using Labels = std::vector<std::string>;

}  // namespace

TEST_CASE("a chart has six lines: exact, the peer, what is fastest at exact's own error and the front") {
    const std::vector<Row> rows = many();
    const std::vector<Chart> charts = charts_of(rows);
    REQUIRE(charts.size() == 1);
    REQUIRE(charts[0].panels.size() == 2);
    for (const Panel& panel : charts[0].panels) {
        CHECK(labels(panel) == Labels{"exact", "peer", "v8", "v7", "v6"});
        CHECK(panel.series[0].points.size() == 3);
        CHECK(panel.series[2].points.size() == 2);  // those of one number of samples
    }
}

TEST_CASE("the front of a chart is that of all that was measured") {
    const std::vector<Row> rows = many();
    const Panel panel = charts_of(rows)[0].panels[0];
    std::vector<ChartPoint> points;
    for (const Row& row : rows) points.push_back({*row.time_ms, *row.rmse});
    const std::vector<std::size_t> front = pareto_front(points);
    REQUIRE(panel.front.size() == front.size());
    for (std::size_t i = 0; i < front.size(); ++i) {
        CHECK(panel.front[i].x == points[front[i]].x);
        CHECK(panel.front[i].y == points[front[i]].y);
    }
    CHECK(panel.front.front().x == 0.01);  // the one that no line shows
}

TEST_CASE("a chart of growth has six lines, what is extrapolated included") {
    std::vector<Row> rows;
    for (const double size : {1.0, 4.0}) {
        for (int v = 0; v < 9; ++v) {
            // The first are fast over few primitives.
            const double speedup = size == 1 ? 10 - v : 1.5 + v;
            rows.push_back(measured("growth", "v" + std::to_string(v), size, 1, speedup, 0));
        }
        rows.push_back(measured("growth", "exact", size, {}, 1, 0));
        rows.push_back(measured("growth", "peer", size, {}, 0.5, 0));
        if (size > 1) rows.back().note = "extrapolated from 100 triangles";
    }
    const std::vector<Chart> charts = charts_of(rows);
    REQUIRE(charts.size() == 1);
    CHECK(labels(charts[0].panels[0]) == Labels{"exact", "peer", "peer, extrapolated", "v8", "v7", "v6"});
    CHECK(charts[0].panels[0].front.empty());
}

TEST_CASE("a chart of few variants shows them all, those that never keep exact's error, too") {
    const std::vector<Row> rows{measured("accuracy", "bad", 1, 1, 2, 0.5),
                                measured("accuracy", "exact", 1, {}, 1, 0.1)};
    CHECK(labels(charts_of(rows)[0].panels[0]) == Labels{"exact", "bad"});
    CHECK(charts_of({}).empty());
}
