// What the command line asks for.
#pragma once

#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace farfield::bench {

/// What cannot be: one line for stderr, exit status 2.
struct UsageError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

struct Options {
    std::vector<std::string> scenes;    ///< time against error
    std::vector<std::string> growth;    ///< time against number of primitives
    std::vector<std::string> variants;  ///< `exact` is measured in any case
    std::vector<double> distances;      ///< in radii
    double angle_degrees = 30;          ///< off the front, about the up axis
    std::vector<double> tolerances_px;
    std::vector<int> samples;  ///< a pixel, of variants; exact is a curve of its own
    int repetitions = 0;
    int size_px = 0;  ///< of the pictures, which are square
    bool is_quick = false;
    std::filesystem::path directory;                ///< where everything goes
    std::optional<std::filesystem::path> from_csv;  ///< measure nothing, draw this again
};

/// None if the answer is all that was asked for: help, lists. Throws UsageError.
std::optional<Options> parse_options(int argc, const char* const* argv, std::string& answer);

}  // namespace farfield::bench
