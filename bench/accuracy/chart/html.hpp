// One page with everything a run has left.
#pragma once

#include <filesystem>
#include <ostream>
#include <vector>

#include "charts.hpp"

namespace farfield::bench {

/// The errors at which speeds are compared.
inline constexpr double rmse_bound = 0.05;
inline constexpr double flip_bound = 0.1;

/// A page that needs no network and works from a file: the table at equal error, a plot that answers, the charts and
/// pictures that there are in the directory. The pictures lie beside the page.
void write_html(std::ostream& out, const std::vector<Row>& rows, const std::vector<Chart>& charts,
                const std::filesystem::path& directory);

/// Writes index.html into the directory. Throws std::runtime_error
/// naming the file.
void write_html(const std::vector<Row>& rows, const std::vector<Chart>& charts, const std::filesystem::path& directory);

}  // namespace farfield::bench
