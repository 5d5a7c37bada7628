// What the pictures of a chart are called, by those who write and those who show them.
#pragma once

#include <cctype>
#include <filesystem>
#include <string>

#include "csv.hpp"

namespace farfield::bench {

/// What is fit for file names and their addresses as it is.
inline std::string file_name(std::string text) {
    for (char& c : text) {
        if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '-' && c != '.') c = '_';
    }
    return text;
}

/// Relative to the chart's directory. `kind`: "", "_difference".
inline std::filesystem::path picture_file(const std::string& scene, const std::string& variant, const char* kind = "") {
    return std::filesystem::path("pictures") / (scene + "_" + variant + kind + ".png");
}
inline constexpr const char* reference_name = "reference";

/// A picture for each row of accuracy: the rectangle that the object takes. Beside the page, not in it: those of a
/// whole run are tens of megabytes, of which a reader sees a few.
inline const std::filesystem::path point_pictures = std::filesystem::path("pictures") / "points";

inline std::filesystem::path point_reference_file(const Row& row) {
    return point_pictures / file_name(row.scene + "_" + row.view + "_" + reference_name + ".png");
}
inline std::filesystem::path point_picture_file(const Row& row) {
    const std::string samples = csv_number(row.samples.value_or(1)),
                      tolerance = row.tolerance_px ? csv_number(*row.tolerance_px) : "none";
    return point_pictures /
           file_name(row.scene + "_" + row.view + "_" + row.variant + "_" + samples + "_" + tolerance + ".png");
}

}  // namespace farfield::bench
