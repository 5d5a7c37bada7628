#include "shared_pictures.hpp"

#include <epoxy/gl.h>
// After the loader's header, which says so.
#include <GLFW/glfw3.h>

#include <algorithm>
#include <string>

#ifdef FARFIELD_HAS_OPENGL
#include "scenes/renderers/opengl_renderer.hpp"
#endif
#include "window.hpp"

namespace viewer {
namespace {

GLFWwindow* window_of(void* context) {
    return static_cast<GLFWwindow*>(context);
}

constexpr const char* vertex_text = R"(#version 450 core
void main() { gl_Position = vec4(4 * (gl_VertexID & 1) - 1, 4 * (gl_VertexID >> 1) - 1, 0, 1); }
)";
// Rounded as report::over_background rounds.
constexpr const char* fragment_text = R"(#version 450 core
layout(binding = 0) uniform sampler2D picture;
layout(location = 0) uniform ivec3 top;
layout(location = 1) uniform ivec3 bottom;
layout(location = 2) uniform int height;
layout(location = 0) out vec4 color;
void main() {
    int y = int(gl_FragCoord.y), last = max(height - 1, 1);
    ivec3 back = (top * (last - y) + bottom * y + last / 2) / last;
    ivec4 front = ivec4(texelFetch(picture, ivec2(gl_FragCoord.xy), 0) * 255 + 0.5);
    ivec3 over = min(front.rgb + (back * (255 - front.a) + 127) / 255, 255);
    color = vec4(vec3(over) / 255, 1);
}
)";

GLuint compiled(GLenum kind, const char* text) {
    const GLuint shader = glCreateShader(kind);
    glShaderSource(shader, 1, &text, nullptr);
    glCompileShader(shader);
    return shader;
}

}  // namespace

/// The last of its holders may be on either thread: both contexts know its texture.
struct SharedPictures::Kept : SharedPicture {
    Kept() = default;
    ~Kept() { glDeleteTextures(1, &name); }
    Kept(const Kept&) = delete;
    Kept& operator=(const Kept&) = delete;

    void resize(glm::ivec2 wanted) {
        if (wanted == size) return;
        glDeleteTextures(1, &name);
        glCreateTextures(GL_TEXTURE_2D, 1, &name);
        glTextureStorage2D(name, 1, GL_RGBA8, wanted.x, wanted.y);
        glTextureParameteri(name, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
        glTextureParameteri(name, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
        glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
        size = wanted;
    }
};

/// What a context has for itself.
struct SharedPictures::Painter {
    GLuint program = glCreateProgram(), array = 0, framebuffer = 0;

    Painter() {
        const GLuint vertex = compiled(GL_VERTEX_SHADER, vertex_text);
        const GLuint fragment = compiled(GL_FRAGMENT_SHADER, fragment_text);
        glAttachShader(program, vertex);
        glAttachShader(program, fragment);
        glLinkProgram(program);
        glDeleteShader(vertex);
        glDeleteShader(fragment);
        glCreateVertexArrays(1, &array);
        glCreateFramebuffers(1, &framebuffer);
    }
    ~Painter() {
        glDeleteFramebuffers(1, &framebuffer);
        glDeleteVertexArrays(1, &array);
        glDeleteProgram(program);
    }
    Painter(const Painter&) = delete;
    Painter& operator=(const Painter&) = delete;

    void draw(GLuint picture, const Kept& to, const farfield::report::Background& background) const {
        glNamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT0, to.name, 0);
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
        glViewport(0, 0, to.size.x, to.size.y);
        glDisable(GL_DEPTH_TEST);
        glDisable(GL_BLEND);
        glUseProgram(program);
        const auto [top, bottom] = background;
        glUniform3i(0, top.r, top.g, top.b);
        glUniform3i(1, bottom.r, bottom.g, bottom.b);
        glUniform1i(2, to.size.y);
        glBindTextureUnit(0, picture);
        glBindVertexArray(array);
        glDrawArrays(GL_TRIANGLES, 0, 3);
        glBindVertexArray(0);
        glBindTextureUnit(0, 0);
        glUseProgram(0);
        glBindFramebuffer(GL_FRAMEBUFFER, 0);
        glFinish();  // the window's context need not wait for this one
    }
};

SharedPictures::SharedPictures(Window& window) : context_(window.make_sharing_context()) {}

SharedPictures::~SharedPictures() {
    if (context_ != nullptr) glfwDestroyWindow(window_of(context_));
}

SharesPictures SharedPictures::hooks() {
    if (context_ == nullptr) return {};
    return {[this] { begin(); }, [this] { end(); },
            [this](unsigned texture, glm::ivec2 size, const farfield::report::Background& background) {
                return keep(texture, size, background);
            }};
}

void SharedPictures::begin() {
#ifdef FARFIELD_HAS_OPENGL
    glfwMakeContextCurrent(window_of(context_));
    is_current_ = glfwGetCurrentContext() != nullptr;
    if (is_current_) farfield::scenes::adopt_opengl_context();
#endif
}

void SharedPictures::end() {
    if (!is_current_) return;
    kept_.clear();
    painter_.reset();
    glfwMakeContextCurrent(nullptr);
}

SharedPicturePtr SharedPictures::keep(unsigned texture, glm::ivec2 size,
                                      const farfield::report::Background& background) {
    if (!is_current_) return nullptr;
    if (!painter_) painter_ = std::make_unique<Painter>();
    auto free = std::find_if(kept_.begin(), kept_.end(), [](const auto& k) { return k.use_count() == 1; });
    if (free == kept_.end()) free = kept_.insert(free, std::make_shared<Kept>());
    (*free)->resize(size);
    painter_->draw(texture, **free, background);
    return *free;
}

}  // namespace viewer
