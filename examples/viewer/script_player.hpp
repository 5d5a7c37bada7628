// Plays a script, a step a frame of the window.
#pragma once

#include <cstddef>
#include <deque>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "input.hpp"
#include "script.hpp"

namespace viewer {

/// What a script acts on.
class ScriptHost {
  public:
    virtual ~ScriptHost() = default;
    virtual bool is_settled() const = 0;  ///< nothing is being built or drawn
    virtual bool is_playing() const = 0;
    virtual void send(const Event& event) = 0;
    virtual void set(std::span<const std::string> words) = 0;
    virtual void take_screenshot(const std::filesystem::path& file) = 0;
    virtual void begin_recording(const std::filesystem::path& file) = 0;
    virtual void end_recording() = 0;
    virtual void play(const std::filesystem::path& file) = 0;
    virtual void quit() = 0;
};

class ScriptPlayer {
  public:
    /// So long is a frame: what a script does takes no account of the machine's pace.
    static constexpr double frame_seconds = 1.0 / 60;

    explicit ScriptPlayer(std::vector<ScriptLine> lines) : lines_(std::move(lines)) {}

    bool is_over() const { return next_ == lines_.size() && events_.empty() && waits_ == Wait::none; }
    /// Throws std::runtime_error that names the line where one cannot be done.
    void step(ScriptHost& host);

  private:
    enum class Wait { none, settled, played };
    void begin(const ScriptLine& line, ScriptHost& host);

    std::vector<ScriptLine> lines_;
    std::size_t next_ = 0;
    std::deque<Event> events_;  ///< yet to be sent, one a frame
    int pause_ = 0;             ///< frames until the next
    Wait waits_ = Wait::none;
};

}  // namespace viewer
