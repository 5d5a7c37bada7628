// Records where the camera goes, and takes it there again.
#pragma once

#include <optional>
#include <utility>

#include "scenes/camera_path.hpp"

namespace viewer {

class PathRecorder {
  public:
    bool is_recording() const { return mode_ == Mode::recording; }
    bool is_playing() const { return mode_ == Mode::playing; }
    const farfield::scenes::CameraPath& path() const { return path_; }

    void record() {
        path_ = {};
        mode_ = Mode::recording;
        seconds_ = 0;
    }
    /// From the beginning; nothing where there is no path.
    void play(farfield::scenes::CameraPath path) {
        path_ = std::move(path);
        mode_ = path_.is_empty() ? Mode::idle : Mode::playing;
        seconds_ = 0;
    }
    void stop() { mode_ = Mode::idle; }

    /// Time goes on. While recording it remembers the camera, unless it stands since the last time; while playing it
    /// gives the camera to show, and stops after the last.
    std::optional<farfield::Camera> advance(double seconds, const farfield::Camera& camera) {
        if (mode_ == Mode::recording) {
            const bool stands = !path_.is_empty() && is_same(path_.stops.back().camera, camera);
            // Where it stood for a while it must not be taken for slow.
            if (stands && stood_) path_.stops.pop_back();
            stood_ = stands;
            path_.stops.push_back({seconds_, camera});
            seconds_ += seconds;
        } else if (mode_ == Mode::playing) {
            const farfield::Camera shown = path_.at(seconds_);
            if (seconds_ >= path_.seconds()) stop();
            seconds_ += seconds;
            return shown;
        }
        return std::nullopt;
    }

  private:
    enum class Mode { idle, recording, playing };

    static bool is_same(const farfield::Camera& a, const farfield::Camera& b) {
        return a.eye == b.eye && a.forward == b.forward && a.up == b.up && a.half_height == b.half_height;
    }

    farfield::scenes::CameraPath path_;
    Mode mode_ = Mode::idle;
    double seconds_ = 0;
    bool stood_ = false;
};

}  // namespace viewer
