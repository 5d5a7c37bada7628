// Where a camera has been: recorded by one program, flown again by another.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "farfield/camera.hpp"

namespace farfield::scenes {

struct CameraPath {
    struct Stop {
        double seconds = 0;  ///< since the path began; never less than the one before
        Camera camera;
    };
    std::vector<Stop> stops;

    bool is_empty() const { return stops.empty(); }
    double seconds() const { return stops.empty() ? 0 : stops.back().seconds; }
    /// Between two stops the camera moves and turns evenly; before the first and after the last it stands. There is at
    /// least one stop.
    Camera at(double seconds) const;
    /// So many cameras at even intervals, the first and the last stop among them.
    std::vector<Camera> cameras(int frames) const;
};

/// A file is JSON, for people to edit too:
///
///     {"camera_path": 1,
///      "views": [{"seconds": 0, "eye": [0, 1, 5], "forward": [0, 0, -1], "up": [0, 1, 0], "half_height": 0.577}, ...]}
///
/// Throws std::runtime_error, one line that names the file.
void write_camera_path(const CameraPath& path, const std::filesystem::path& file);

/// Throws std::runtime_error, one line that names the file and what is wrong in it: axes need not be of length 1 or at
/// right angles, but have to span a plane.
CameraPath read_camera_path(const std::filesystem::path& file);

}  // namespace farfield::scenes
