#include "opengl/context.hpp"

#include <epoxy/egl.h>

#include <stdexcept>
#include <utility>

#include "opengl/gl.hpp"

namespace farfield::opengl {
namespace {

constexpr std::size_t most_messages = 16;

void GLAPIENTRY on_message(GLenum, GLenum type, GLuint, GLenum, GLsizei length, const GLchar* text, const void* log) {
    if (type != GL_DEBUG_TYPE_ERROR) return;
    static_cast<ErrorLog*>(const_cast<void*>(log))->add(std::string(text, std::size_t(length)));
}

[[noreturn]] void refuse(int major, int minor, const std::string& found) {
    throw std::runtime_error("OpenGL " + std::to_string(major) + "." + std::to_string(minor) + " core wanted, " +
                             found + " found");
}

std::string version_found(int version) {
    const GLubyte* const renderer = glGetString(GL_RENDERER);
    return std::to_string(version / 10) + "." + std::to_string(version % 10) +
           (renderer == nullptr ? "" : " (" + std::string(reinterpret_cast<const char*>(renderer)) + ")");
}

EGLDisplay initialized(EGLDisplay display) {
    return display != EGL_NO_DISPLAY && eglInitialize(display, nullptr, nullptr) ? display : EGL_NO_DISPLAY;
}

EGLDisplay open_display() {
    if (epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_base")) {
        if (epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless")) {
            const EGLDisplay display =
                initialized(eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr));
            if (display != EGL_NO_DISPLAY) return display;
        }
        if (epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_device") &&
            epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_device_enumeration")) {
            EGLDeviceEXT device{};
            EGLint count = 0;
            if (eglQueryDevicesEXT(1, &device, &count) && count > 0) {
                const EGLDisplay display =
                    initialized(eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, device, nullptr));
                if (display != EGL_NO_DISPLAY) return display;
            }
        }
    }
    return initialized(eglGetDisplay(EGL_DEFAULT_DISPLAY));
}

EGLContext create_context(EGLDisplay display, int major, int minor, bool debug) {
    const EGLint wanted[] = {EGL_CONTEXT_MAJOR_VERSION,
                             major,
                             EGL_CONTEXT_MINOR_VERSION,
                             minor,
                             EGL_CONTEXT_OPENGL_PROFILE_MASK,
                             EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                             EGL_CONTEXT_OPENGL_DEBUG,
                             debug ? EGL_TRUE : EGL_FALSE,
                             EGL_NONE};
    return eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, wanted);
}

}  // namespace

void require_opengl() {
    const int version = epoxy_gl_version();
    if (!epoxy_is_desktop_gl() || version < 45) refuse(4, 5, version_found(version));
    GLint profile = 0;
    glGetIntegerv(GL_CONTEXT_PROFILE_MASK, &profile);
    if ((profile & GL_CONTEXT_CORE_PROFILE_BIT) == 0) refuse(4, 5, "no core profile of " + version_found(version));
}

std::string describe_opengl() {
    const auto text = [](GLenum what) {
        const GLubyte* const bytes = glGetString(what);
        return bytes == nullptr ? std::string("?") : std::string(reinterpret_cast<const char*>(bytes));
    };
    return text(GL_RENDERER) + ", OpenGL " + text(GL_VERSION);
}

ErrorLog::ErrorLog() {
    glEnable(GL_DEBUG_OUTPUT);
    glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
    glDebugMessageCallback(&on_message, this);
}
ErrorLog::~ErrorLog() {
    glDebugMessageCallback(nullptr, nullptr);
    glDisable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
    glDisable(GL_DEBUG_OUTPUT);
}
void ErrorLog::add(std::string message) {
    ++count_;
    if (messages_.size() < most_messages) messages_.push_back(std::move(message));
}

struct HeadlessContext::Handles {
    EGLDisplay display = EGL_NO_DISPLAY;
    EGLContext context = EGL_NO_CONTEXT;

    ~Handles() {
        if (display == EGL_NO_DISPLAY) return;
        if (context == EGL_NO_CONTEXT) return;
        if (eglGetCurrentContext() == context) eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        eglDestroyContext(display, context);
        // Not eglTerminate: others may have the same display.
    }
};

HeadlessContext::HeadlessContext(const HeadlessOptions& options) : handles_(std::make_unique<Handles>()) {
    Handles& h = *handles_;
    h.display = open_display();
    if (h.display == EGL_NO_DISPLAY) throw std::runtime_error("OpenGL 4.5 core wanted, and there is no EGL display");
    if (!eglBindAPI(EGL_OPENGL_API)) refuse(options.major, options.minor, "only OpenGL ES");
    h.context = create_context(h.display, options.major, options.minor, options.debug);
    if (h.context == EGL_NO_CONTEXT) {
        // To tell what there is instead.
        h.context = create_context(h.display, 3, 2, false);
        if (h.context == EGL_NO_CONTEXT) refuse(options.major, options.minor, "none");
        make_current();
        refuse(options.major, options.minor, version_found(epoxy_gl_version()));
    }
    make_current();
    require_opengl();
}
HeadlessContext::~HeadlessContext() = default;

void HeadlessContext::make_current() {
    if (!eglMakeCurrent(handles_->display, EGL_NO_SURFACE, EGL_NO_SURFACE, handles_->context))
        throw std::runtime_error("OpenGL without a surface is not possible here");
}

}  // namespace farfield::opengl
