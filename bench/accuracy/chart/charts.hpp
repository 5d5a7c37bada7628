// What is charted: series of points for gnuplot to draw, from rows.
#pragma once

#include <array>
#include <string>
#include <vector>

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
    char bars = 'x';         ///< along which axis
    bool has_front = false;  ///< the Pareto front of all points is marked
    std::vector<Series> series;
};

struct Chart {
    std::string name;  ///< fit for file names
    std::string scene, title;
    std::vector<Panel> panels;  ///< at least one, none without points
};

/// Time against error and memory against error for each scene and view; time against number of primitives for each
/// series. Rows that lack one of the two, or where one is not above 0, are left out: no place on such axes.
std::vector<Chart> charts_of(const std::vector<Row>& rows);

}  // namespace farfield::bench
