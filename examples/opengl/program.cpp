#include "opengl/program.hpp"

#include <initializer_list>
#include <stdexcept>

namespace farfield::opengl {
namespace {

struct Compiled {
    GLuint name;
    Compiled(GLenum kind, const std::string& text) : name(glCreateShader(kind)) {
        const char* const source = text.c_str();
        glShaderSource(name, 1, &source, nullptr);
        glCompileShader(name);
        GLint good = 0;
        glGetShaderiv(name, GL_COMPILE_STATUS, &good);
        if (good != 0) return;
        char log[1024] = "";
        glGetShaderInfoLog(name, sizeof log, nullptr, log);
        glDeleteShader(name);
        throw std::runtime_error("OpenGL does not compile a shader: " + std::string(log));
    }
    ~Compiled() { glDeleteShader(name); }
    Compiled(const Compiled&) = delete;
    Compiled& operator=(const Compiled&) = delete;
};

Program linked(std::initializer_list<const Compiled*> parts) {
    Program made(GL_NONE);
    for (const Compiled* part : parts) glAttachShader(made.name(), part->name);
    glLinkProgram(made.name());
    for (const Compiled* part : parts) glDetachShader(made.name(), part->name);
    GLint good = 0;
    glGetProgramiv(made.name(), GL_LINK_STATUS, &good);
    if (good != 0) return made;
    char log[1024] = "";
    glGetProgramInfoLog(made.name(), sizeof log, nullptr, log);
    throw std::runtime_error("OpenGL does not link a program: " + std::string(log));
}

}  // namespace

Program make_program(const std::string& vertex_text, const std::string& fragment_text) {
    const Compiled vertex(GL_VERTEX_SHADER, vertex_text), fragment(GL_FRAGMENT_SHADER, fragment_text);
    return linked({&vertex, &fragment});
}
Program make_compute_program(const std::string& text) {
    const Compiled compute(GL_COMPUTE_SHADER, text);
    return linked({&compute});
}

}  // namespace farfield::opengl
