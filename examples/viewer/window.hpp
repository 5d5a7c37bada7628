// A window with an OpenGL 4.5 context and widgets in it; nobody else here knows GLFW.
#pragma once

#include <glm/vec2.hpp>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "farfield/image.hpp"
#include "input.hpp"

namespace viewer {

/// There is no display, or no OpenGL that is new enough: one line.
struct NoWindow : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// There is one at a time.
class Window {
  public:
    /// Throws NoWindow.
    Window(glm::ivec2 size, const std::string& title);
    ~Window();
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    void set_title(const std::string& title);
    bool should_close() const;
    glm::dvec2 size() const;  ///< in the units of the mouse
    glm::ivec2 pixels() const;

    /// Waits for events, or so many seconds.
    void wait(double seconds);
    /// Ends waiting; from any thread.
    static void wake();

    /// Widgets are made between begin_frame() and end_frame(), which draws them.
    void begin_frame();
    void end_frame();
    /// Those since the last time that widgets have not taken; after begin_frame().
    std::vector<Event> events();
    glm::dvec2 cursor() const;
    /// What end_frame() has drawn, before show().
    farfield::Image read_back() const;
    void show();

    /// GLFW's window, never shown, of a context that shares this one's textures and is current nowhere; null: the
    /// driver gives none. Whoever asks destroys it, on this thread.
    void* make_sharing_context();

    /// What OpenGL found wrong so far; empty: nothing.
    const std::vector<std::string>& gl_errors() const;
    /// Who draws, as OpenGL names it.
    std::string gl_name() const;

  private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

}  // namespace viewer
