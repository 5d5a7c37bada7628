#include "opengl_drawer.hpp"

#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <glm/mat4x4.hpp>
#include <stdexcept>
#include <vector>

namespace farfield::bench {
namespace {

std::string name;

/// The surfaceless platform of Mesa.
class Context {
  public:
    Context() {
        // Rasterize in this thread, unless somebody has said otherwise.
        setenv("LP_NUM_THREADS", "0", 0);
        display_ = eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
        if (display_ == EGL_NO_DISPLAY || !eglInitialize(display_, nullptr, nullptr) || !eglBindAPI(EGL_OPENGL_API)) {
            throw std::runtime_error("there is no EGL without a surface here");
        }
        const EGLint wanted[] = {
            EGL_CONTEXT_MAJOR_VERSION,           4,       EGL_CONTEXT_MINOR_VERSION, 5, EGL_CONTEXT_OPENGL_PROFILE_MASK,
            EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
        context_ = eglCreateContext(display_, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, wanted);
        if (context_ == EGL_NO_CONTEXT || !eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_)) {
            eglTerminate(display_);
            throw std::runtime_error("there is no OpenGL 4.5 here");
        }
        name = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
    }
    ~Context() {
        eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        eglDestroyContext(display_, context_);
        eglTerminate(display_);
    }
    Context(const Context&) = delete;
    Context& operator=(const Context&) = delete;

  private:
    EGLDisplay display_ = EGL_NO_DISPLAY;
    EGLContext context_ = EGL_NO_CONTEXT;
};

struct Vertex {
    glm::vec3 position;
    Rgba8 color;
};

/// Objects live as long as the context.
class OpenGlDrawer final : public Drawer {
  public:
    explicit OpenGlDrawer(std::span<const VertexColoredTriangle> triangles) {
        std::vector<Vertex> vertices;
        std::vector<std::uint32_t> corners;
        for (std::size_t i = 0; i + 1 < triangles.size(); i += 2) {
            const auto &one = triangles[i], &other = triangles[i + 1];
            const auto first = std::uint32_t(vertices.size());
            for (std::size_t c = 0; c < 3; ++c) vertices.push_back({one.vertices[c], one.rgba[c]});
            vertices.push_back({other.vertices[2], other.rgba[2]});
            for (const std::uint32_t c : {0u, 1u, 2u, 0u, 2u, 3u}) corners.push_back(first + c);
        }
        count_ = GLsizei(corners.size());
        GLuint buffers[2], array;
        glCreateBuffers(2, buffers);
        glNamedBufferStorage(buffers[0], GLsizeiptr(vertices.size() * sizeof(Vertex)), vertices.data(), 0);
        glNamedBufferStorage(buffers[1], GLsizeiptr(corners.size() * sizeof(std::uint32_t)), corners.data(), 0);
        glCreateVertexArrays(1, &array);
        glVertexArrayVertexBuffer(array, 0, buffers[0], 0, sizeof(Vertex));
        glVertexArrayElementBuffer(array, buffers[1]);
        glVertexArrayAttribFormat(array, 0, 3, GL_FLOAT, GL_FALSE, offsetof(Vertex, position));
        glVertexArrayAttribFormat(array, 1, 4, GL_UNSIGNED_BYTE, GL_TRUE, offsetof(Vertex, color));
        for (const GLuint attribute : {0u, 1u}) {
            glVertexArrayAttribBinding(array, attribute, 0);
            glEnableVertexArrayAttrib(array, attribute);
        }
        glBindVertexArray(array);
        glUseProgram(program());
        // Depth is near / distance, 0 at infinity.
        glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
        glEnable(GL_DEPTH_TEST);
        glDepthFunc(GL_GREATER);
    }

    FrameStats frame(const View& view) override {
        if (view.width != width_ || view.height != height_) resize(view.width, view.height);
        const Camera& c = view.camera;
        const float across = c.half_height * float(view.width) / float(view.height), near_depth = 0.01f;
        const glm::vec4 rows[4] = {row(c, c.right / across), row(c, c.up / c.half_height),
                                   glm::vec4(0, 0, 0, near_depth), row(c, c.forward)};
        glUniformMatrix4fv(0, 1, GL_TRUE, &rows[0].x);
        const GLfloat nothing[4] = {0, 0, 0, 0}, far_away = 0;
        glClearBufferfv(GL_COLOR, 0, nothing);
        glClearBufferfv(GL_DEPTH, 0, &far_away);
        glDrawElements(GL_TRIANGLES, count_, GL_UNSIGNED_INT, nullptr);
        glFinish();
        return {};
    }

    const Image& image() const override {
        std::vector<Rgba8> samples(64 * std::size_t(width_) * std::size_t(height_));
        glReadPixels(0, 0, 8 * width_, 8 * height_, GL_RGBA, GL_UNSIGNED_BYTE, samples.data());
        image_ = Image(width_, height_);
        for (int y = 0; y < height_; ++y) {
            for (int x = 0; x < width_; ++x) {
                unsigned sums[4] = {32, 32, 32, 32};
                for (int k = 0; k < 64; ++k) {
                    const int row_from_below = 8 * (height_ - y) - 1 - k / 8;
                    const Rgba8 s = samples[std::size_t(row_from_below * 8 * width_ + 8 * x + k % 8)];
                    sums[0] += s.r, sums[1] += s.g, sums[2] += s.b, sums[3] += s.a;
                }
                image_.at(x, y) = {std::uint8_t(sums[0] >> 6), std::uint8_t(sums[1] >> 6), std::uint8_t(sums[2] >> 6),
                                   std::uint8_t(sums[3] >> 6)};
            }
        }
        return image_;
    }

  private:
    static glm::vec4 row(const Camera& camera, glm::vec3 axis) {
        return glm::vec4(axis, -glm::dot(axis, glm::vec3(camera.eye)));
    }

    static GLuint program() {
        constexpr const char* vertex =
            "#version 450 core\n"
            "layout(location = 0) in vec3 position; layout(location = 1) in vec4 color;\n"
            "layout(location = 0) uniform mat4 to_clip; out vec4 seen;\n"
            "void main() { gl_Position = to_clip * vec4(position, 1); seen = color; }\n";
        constexpr const char* fragment =
            "#version 450 core\nin vec4 seen; out vec4 color;\nvoid main() { color = seen; }\n";
        const GLuint program = glCreateProgram();
        for (const auto& [kind, text] : {std::pair{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, fragment}}) {
            const GLuint shader = glCreateShader(GLenum(kind));
            glShaderSource(shader, 1, &text, nullptr);
            glCompileShader(shader);
            glAttachShader(program, shader);
        }
        glLinkProgram(program);
        GLint is_linked = 0;
        glGetProgramiv(program, GL_LINK_STATUS, &is_linked);
        if (is_linked == 0) throw std::runtime_error("OpenGL does not link two lines of shaders");
        return program;
    }

    void resize(int width, int height) {
        width_ = width;
        height_ = height;
        GLuint buffers[2], frame;
        glCreateRenderbuffers(2, buffers);
        glNamedRenderbufferStorage(buffers[0], GL_RGBA8, 8 * width, 8 * height);
        glNamedRenderbufferStorage(buffers[1], GL_DEPTH_COMPONENT32F, 8 * width, 8 * height);
        glCreateFramebuffers(1, &frame);
        glNamedFramebufferRenderbuffer(frame, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, buffers[0]);
        glNamedFramebufferRenderbuffer(frame, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, buffers[1]);
        glBindFramebuffer(GL_FRAMEBUFFER, frame);
        if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
            throw std::runtime_error("OpenGL has no picture of that size");
        }
        glViewport(0, 0, 8 * width, 8 * height);
    }

    Context context_;
    GLsizei count_ = 0;
    int width_ = 0, height_ = 0;
    mutable Image image_;
};

}  // namespace

std::unique_ptr<Drawer> opengl_drawer(std::span<const VertexColoredTriangle> pairs_of_triangles) {
    return std::make_unique<OpenGlDrawer>(pairs_of_triangles);
}

std::string opengl_name() {
    return name;
}

}  // namespace farfield::bench
