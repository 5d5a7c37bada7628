// What the pictures of a chart are called, by those who write and those who show them.
#pragma once

#include <filesystem>
#include <string>

namespace farfield::bench {

/// Relative to the chart's directory. `kind`: "", "_difference".
inline std::filesystem::path picture_file(const std::string& scene, const std::string& variant, const char* kind = "") {
    return std::filesystem::path("pictures") / (scene + "_" + variant + kind + ".png");
}
inline constexpr const char* reference_name = "reference";

}  // namespace farfield::bench
