// One page with everything a run has left.
#pragma once

#include <filesystem>
#include <vector>

#include "charts.hpp"

namespace farfield::bench {

/// The errors at which speeds are compared.
inline constexpr double rmse_bound = 0.05;
inline constexpr double flip_bound = 0.1;

/// Writes index.html into the directory; shows what charts and pictures there are in it. Throws std::runtime_error
/// naming the file.
void write_html(const std::vector<Row>& rows, const std::vector<Chart>& charts, const std::filesystem::path& directory);

}  // namespace farfield::bench
