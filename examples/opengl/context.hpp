// What a context must have, what it says about itself, and one without a window.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace farfield::opengl {

/// Throws std::runtime_error, one line that tells what was found, unless the current context is OpenGL 4.5 core or
/// newer.
void require_opengl();

/// The current context's renderer and version.
std::string describe_opengl();

/// Listens to the current context's errors while it lives; the first few are kept. One at a time in a context. (Errors
/// are told by GL_KHR_debug, in the call that makes them; glGetError tells them too.)
class ErrorLog {
  public:
    ErrorLog();
    ~ErrorLog();
    ErrorLog(const ErrorLog&) = delete;
    ErrorLog& operator=(const ErrorLog&) = delete;

    std::size_t count() const { return count_; }
    const std::vector<std::string>& messages() const { return messages_; }

    /// For the callback.
    void add(std::string message);

  private:
    std::size_t count_ = 0;
    std::vector<std::string> messages_;
};

struct HeadlessOptions {
    int major = 4, minor = 5;  ///< what is asked for, at least 4.5
    bool debug = false;        ///< a debug context: slower, and says more
};

/// A context without a window or a surface: of Mesa's surfaceless platform, else of the first device, else of the
/// default display. It is current in the thread that makes it until it goes.
class HeadlessContext {
  public:
    /// Throws std::runtime_error, one line, where there is no such context.
    explicit HeadlessContext(const HeadlessOptions& options = {});
    ~HeadlessContext();
    HeadlessContext(const HeadlessContext&) = delete;
    HeadlessContext& operator=(const HeadlessContext&) = delete;

    void make_current();

  private:
    struct Handles;
    std::unique_ptr<Handles> handles_;
};

}  // namespace farfield::opengl
