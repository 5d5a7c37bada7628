// Brings window, camera, scene and pictures together: one turn of its loop is one frame of the window.
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <future>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "builder.hpp"
#include "controls.hpp"
#include "drawer.hpp"
#include "history.hpp"
#include "look.hpp"
#include "navigator.hpp"
#include "panels.hpp"
#include "path_recorder.hpp"
#include "resolution.hpp"
#include "script_player.hpp"
#include "shared_pictures.hpp"
#include "texture.hpp"
#include "window.hpp"

namespace viewer {

struct Options {
    std::string scene = "island";
    glm::ivec2 size{1280, 720};
    std::size_t cache_mib = 256;                        ///< for pages
    std::vector<std::vector<std::string>> choices;      ///< as choose() takes them
    std::optional<std::filesystem::path> script, path;  ///< to be played
};

class Application final : private ScriptHost {
  public:
    /// Throws NoWindow, and std::runtime_error for a script or a path that cannot be read.
    explicit Application(const Options& options);

    /// Until the window is closed, or the script ends it. Throws std::runtime_error, one line, where the first scene
    /// cannot be opened, a line of the script cannot be done, or OpenGL found something wrong.
    void run();

  private:
    // What a script acts on.
    bool is_settled() const override;
    bool is_playing() const override { return recorder_.is_playing(); }
    void send(const Event& event) override;
    void set(std::span<const std::string> words) override { choose(words); }
    void take_screenshot(const std::filesystem::path& file) override { screenshot_ = file; }
    void begin_recording(const std::filesystem::path& file) override;
    void end_recording() override;
    void play(const std::filesystem::path& file) override;
    void quit() override { is_over_ = true; }

    void choose(std::span<const std::string> words);
    void take_news();
    void show(std::shared_ptr<const Stage> stage);
    void build_what_is_missing();
    void advance(double seconds);
    void play_or_stop();
    void record_or_stop();
    std::optional<Order> wanted_order() const;
    std::vector<farfield::View> views_like(const farfield::View& view) const;
    void order();
    void take_drawn();
    bool gets_better(const Drawn& drawn);
    void paint();
    void paint_lines(glm::dvec2 size);
    void do_clicked(const Clicked& clicked);
    void pick(glm::dvec2 at);
    farfield::View view(glm::ivec2 pixels) const;
    BuiltPtr built(std::size_t variant) const { return variant < built_.size() ? built_[variant] : nullptr; }
    bool is_moving() const;
    std::filesystem::path new_file(const std::string& what, const std::string& extension) const;
    Shown shown() const;

    using Clock = std::chrono::steady_clock;

    Options options_;
    Window window_;
    Look look_;
    Navigator navigator_;
    Controls controls_{look_, navigator_};
    PathRecorder recorder_;
    std::filesystem::path recording_;  ///< where what is recorded goes
    std::optional<ScriptPlayer> script_;

    std::shared_ptr<const Stage> stage_;
    std::vector<BuiltPtr> built_;             ///< null: not yet
    std::vector<bool> failed_;                ///< to build
    std::optional<std::size_t> being_built_;  ///< while the builder is busy
    std::string message_, notice_;            ///< what went wrong, and what went well
    bool is_over_ = false, has_opened_ = false;

    Resolution resolution_;
    std::optional<Order> last_order_;
    std::size_t orders_ = 0;
    bool is_refining_ = false;  ///< a view that stands gets better from frame to frame
    int unchanged_ = 0;         ///< frames since it did
    Clock::time_point moved_at_{};
    std::optional<farfield::Camera> camera_;  ///< of the last frame
    std::optional<Drawn> drawn_;
    Texture variant_, exact_, difference_;
    History frame_ms_, errors_;

    std::future<std::optional<farfield::scenes::PickedInScene>> picking_;
    std::optional<farfield::scenes::PickedInScene> picked_;
    std::optional<std::filesystem::path> screenshot_;

    SharedPictures shared_{window_};
    // Last, so that they end first: they wake the window.
    Builder builder_{Window::wake};
    Drawer drawer_{Window::wake, shared_.hooks()};
};

}  // namespace viewer
