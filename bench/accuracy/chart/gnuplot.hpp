// Charts drawn with gnuplot, which is asked for pictures and not linked to.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "charts.hpp"

namespace farfield::bench {

/// Draws NAME.svg into the directory it is run in, from data of its own. Colors and lines of variants are the same in
/// all charts with the same `labels`: those of all series.
std::string gnuplot_script(const Chart& chart, const std::vector<std::string>& labels);

/// Relative to the chart's directory.
inline std::filesystem::path script_file(const Chart& chart) {
    return std::filesystem::path("charts") / (chart.name + ".gp");
}
inline std::filesystem::path svg_file(const Chart& chart) {
    return std::filesystem::path("charts") / (chart.name + ".svg");
}

/// Writes all scripts and runs them. Returns what to tell people, one line, if a chart could not be drawn: no gnuplot,
/// or one that fails; else nothing. Throws std::runtime_error where scripts cannot be written.
std::string draw_charts(const std::vector<Chart>& charts, const std::filesystem::path& directory);

}  // namespace farfield::bench
