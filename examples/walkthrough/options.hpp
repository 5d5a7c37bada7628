// What the command line says.
#pragma once

#include <cstddef>
#include <filesystem>
#include <glm/vec3.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "farfield/tuning/error_table.hpp"
#include "scenes/renderers/renderer_choice.hpp"

namespace walkthrough {

/// The user asked for what cannot be: one line, exit status 2.
struct UsageError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

struct Options {
    std::string scene = "tree";         ///< a name of the catalog, or a file
    int copies = 1;                     ///< of the scene, in rows
    std::optional<glm::vec3> up;        ///< of a file; none: y
    std::vector<std::string> variants;  ///< known names, each once, exact first
    /// Of the frames that are timed. It draws all variants but exact, which the z-buffer draws where it cannot.
    farfield::scenes::RendererKind renderer = farfield::scenes::RendererKind::z_buffer;
    int samples = 1;  ///< a pixel, of the frames that are timed
    /// More that a variant may be drawn with where that is cheaper at the error that is wanted, ascending.
    std::vector<int> more_samples;
    int threads = 1;                            ///< that draw a frame, exact's too
    int width = 640, height = 360;              ///< pixels
    int frames = 0;                             ///< above 0
    std::optional<double> distance;             ///< from the scene's center, in its radii; none: fly through
    std::optional<std::filesystem::path> path;  ///< of a camera, to be flown instead
    double angle_degrees = 0;                   ///< off the front, about the up axis
    /// What each variant's tolerance is chosen by. None: all have `tolerance_px`.
    std::optional<farfield::WantedError> error = farfield::WantedError{};
    bool error_is_asked = false;   ///< by the command line, so that something must choose
    bool measures_errors = false;  ///< of a file of pages, and puts into it what its tolerance is chosen by
    float tolerance_px = 1;
    std::optional<double> budget_ms;  ///< that a frame of a variant may take; exact's may take any
    std::size_t cache_mib = 256;      ///< for pages, of scenes that are larger than memory
    std::optional<std::filesystem::path> out_directory;
    std::optional<std::filesystem::path> json_file;
};

/// Nothing where the command line asked for help or a list, which is then in `answer`. Throws UsageError.
std::optional<Options> parse_options(int argc, const char* const* argv, std::string& answer);

}  // namespace walkthrough
