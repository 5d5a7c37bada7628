// What is charted: series of points for gnuplot to draw, from rows.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "pareto.hpp"
#include "row.hpp"

namespace farfield::bench {

struct Series {
    std::string label;                          ///< series of one label look alike but for their samples
    std::vector<std::array<double, 4>> points;  ///< x, y, and from where to where the bar through it goes
    double samples = 1;                         ///< a pixel, of the first point
};

/// Both axes are logarithmic.
struct Panel {
    std::string x_label, y_label;
    char bars = 'x';  ///< along which axis
    std::vector<Series> series;
    std::vector<ChartPoint> front{};  ///< the Pareto front of all that was measured, shown or not; empty: not marked
};

struct Chart {
    std::string name;  ///< fit for file names
    std::string scene, title;
    std::vector<Panel> panels;  ///< at least one, none without points
};

/// More cannot be told apart; the page shows the rest.
inline constexpr std::size_t most_lines = 6;

/// Time against error and memory against error for each scene and view; time against number of primitives for each
/// series: exact, the peer and what is fastest at exact's own error (RMSE; else over most primitives), with the Pareto
/// front at most so many lines. Rows that lack one of the two, or where one is not above 0, are left out: no place on
/// such axes.
std::vector<Chart> charts_of(const std::vector<Row>& rows);

}  // namespace farfield::bench
