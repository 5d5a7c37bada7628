#include "window.hpp"

#include <epoxy/gl.h>
// After the loader's header, which says so.
#include <GLFW/glfw3.h>
#include <imgui.h>
#include <imgui_impl_glfw.h>
#include <imgui_impl_opengl3.h>

#include <algorithm>
#include <cstddef>
#include <utility>

namespace viewer {

static_assert(int(Key::escape) == GLFW_KEY_ESCAPE && int(Key::f1) == GLFW_KEY_F1 && int(Key::space) == GLFW_KEY_SPACE &&
              int(Key::left_bracket) == GLFW_KEY_LEFT_BRACKET && int('A') == GLFW_KEY_A);

struct Window::Parts {
    GLFWwindow* window = nullptr;
    std::vector<Event> events{};
    std::vector<std::string> gl_errors{};
    std::string glfw_error{};
    /// As the last event had it: where the mouse is by now is not where it was when a button went down.
    glm::dvec2 cursor{0.0};
    bool has_widgets = false;

    ~Parts() {
        if (has_widgets) {
            ImGui_ImplOpenGL3_Shutdown();
            ImGui_ImplGlfw_Shutdown();
            ImGui::DestroyContext();
        }
        if (window != nullptr) glfwDestroyWindow(window);
        glfwTerminate();
    }

    Event event(Event::Kind kind, int mods) {
        Event e{.kind = kind};
        e.shift = (mods & GLFW_MOD_SHIFT) != 0;
        e.control = (mods & GLFW_MOD_CONTROL) != 0;
        e.at = cursor;
        return e;
    }
};

namespace {

std::string last_glfw_error() {
    const char* text = nullptr;
    glfwGetError(&text);
    return text != nullptr ? text : "GLFW does not say why";
}

void GLAPIENTRY on_gl_message(GLenum, GLenum type, GLuint, GLenum, GLsizei, const GLchar* message, const void* errors) {
    if (type != GL_DEBUG_TYPE_ERROR) return;
    auto& list = *static_cast<std::vector<std::string>*>(const_cast<void*>(errors));
    if (list.size() < 100) list.emplace_back(message);
}

}  // namespace

Window::Window(glm::ivec2 size, const std::string& title) : parts_(std::make_unique<Parts>()) {
    if (glfwInit() == GLFW_FALSE) throw NoWindow("there is no display to open a window on: " + last_glfw_error());
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_DEBUG_CONTEXT, GLFW_TRUE);
    parts_->window = glfwCreateWindow(size.x, size.y, title.c_str(), nullptr, nullptr);
    if (parts_->window == nullptr) {
        throw NoWindow("this needs OpenGL 4.5, core profile, which cannot be had here: " + last_glfw_error());
    }
    GLFWwindow* const window = parts_->window;
    glfwMakeContextCurrent(window);
    glfwSwapInterval(1);
    glEnable(GL_DEBUG_OUTPUT);
    glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
    glDebugMessageCallback(on_gl_message, &parts_->gl_errors);

    glfwSetWindowUserPointer(window, parts_.get());
    static constexpr auto parts = [](GLFWwindow* w) { return static_cast<Parts*>(glfwGetWindowUserPointer(w)); };
    glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int, int action, int mods) {
        if (action == GLFW_REPEAT) return;
        Event e = parts(w)->event(action == GLFW_PRESS ? Event::Kind::key_down : Event::Kind::key_up, mods);
        e.key = Key(key);
        parts(w)->events.push_back(e);
    });
    glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int button, int action, int mods) {
        if (button > GLFW_MOUSE_BUTTON_MIDDLE) return;
        Event e = parts(w)->event(action == GLFW_PRESS ? Event::Kind::button_down : Event::Kind::button_up, mods);
        e.button = Button(button);
        parts(w)->events.push_back(e);
    });
    glfwSetCursorPosCallback(window, [](GLFWwindow* w, double x, double y) {
        parts(w)->cursor = {x, y};
        parts(w)->events.push_back({.kind = Event::Kind::move, .at = {x, y}});
    });
    glfwSetScrollCallback(window, [](GLFWwindow* w, double, double steps) {
        Event e = parts(w)->event(Event::Kind::wheel, 0);
        e.steps = steps;
        parts(w)->events.push_back(e);
    });
    glfwSetDropCallback(window, [](GLFWwindow* w, int count, const char** files) {
        for (int i = 0; i < count; ++i) parts(w)->events.push_back({.kind = Event::Kind::drop, .file = files[i]});
    });

    IMGUI_CHECKVERSION();
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr;  // nothing is left in the directory
    ImGui::StyleColorsDark();
    ImGui::GetStyle().WindowRounding = 4;
    ImGui_ImplGlfw_InitForOpenGL(window, true);  // it calls the callbacks above
    ImGui_ImplOpenGL3_Init("#version 450 core");
    parts_->has_widgets = true;
}

Window::~Window() = default;

void Window::set_title(const std::string& title) {
    glfwSetWindowTitle(parts_->window, title.c_str());
}

bool Window::should_close() const {
    return glfwWindowShouldClose(parts_->window) != 0;
}

glm::dvec2 Window::size() const {
    glm::ivec2 size;
    glfwGetWindowSize(parts_->window, &size.x, &size.y);
    return glm::dvec2(std::max(size.x, 1), std::max(size.y, 1));
}

glm::ivec2 Window::pixels() const {
    glm::ivec2 size;
    glfwGetFramebufferSize(parts_->window, &size.x, &size.y);
    return {std::max(size.x, 1), std::max(size.y, 1)};
}

void Window::wait(double seconds) {
    if (seconds > 0) {
        glfwWaitEventsTimeout(seconds);
    } else {
        glfwPollEvents();
    }
}

void Window::wake() {
    glfwPostEmptyEvent();
}

void Window::begin_frame() {
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
}

std::vector<Event> Window::events() {
    const ImGuiIO& io = ImGui::GetIO();
    std::vector<Event> events = std::exchange(parts_->events, {});
    const auto is_taken = [&](const Event& e) {
        // What ends reaches everybody: a drag may end over a widget.
        if (e.kind == Event::Kind::button_down || e.kind == Event::Kind::wheel) return io.WantCaptureMouse;
        if (e.kind == Event::Kind::key_down) return io.WantTextInput;
        return false;
    };
    events.erase(std::remove_if(events.begin(), events.end(), is_taken), events.end());
    return events;
}

glm::dvec2 Window::cursor() const {
    return parts_->cursor;
}

void Window::end_frame() {
    ImGui::Render();
    const glm::ivec2 size = pixels();
    glViewport(0, 0, size.x, size.y);
    glClearColor(0.1f, 0.1f, 0.12f, 1);
    glClear(GL_COLOR_BUFFER_BIT);
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

farfield::Image Window::read_back() const {
    const glm::ivec2 size = pixels();
    farfield::Image upside_down(size.x, size.y), image(size.x, size.y);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, size.x, size.y, GL_RGBA, GL_UNSIGNED_BYTE, upside_down.pixels().data());
    for (int y = 0; y < size.y; ++y) {
        for (int x = 0; x < size.x; ++x) {
            image.at(x, y) = upside_down.at(x, size.y - 1 - y);
            image.at(x, y).a = 255;
        }
    }
    return image;
}

void Window::show() {
    glfwSwapBuffers(parts_->window);
}

void* Window::make_sharing_context() {
    glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
    glfwWindowHint(GLFW_OPENGL_DEBUG_CONTEXT, GLFW_FALSE);
    GLFWwindow* const sharing = glfwCreateWindow(16, 16, "", nullptr, parts_->window);
    glfwWindowHint(GLFW_VISIBLE, GLFW_TRUE);
    return sharing;
}

const std::vector<std::string>& Window::gl_errors() const {
    return parts_->gl_errors;
}

std::string Window::gl_name() const {
    const auto* const name = glGetString(GL_RENDERER);
    return name != nullptr ? reinterpret_cast<const char*>(name) : "";
}

}  // namespace viewer
