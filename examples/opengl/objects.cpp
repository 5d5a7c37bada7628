#include "opengl/objects.hpp"

#include <atomic>

namespace farfield::opengl {
namespace {

std::array<std::atomic<std::size_t>, object_kinds> counts{};

}  // namespace

std::array<std::size_t, object_kinds> live_objects() {
    std::array<std::size_t, object_kinds> live{};
    for (std::size_t i = 0; i < object_kinds; ++i) live[i] = counts[i];
    return live;
}

namespace detail {

GLuint create(ObjectKind kind, GLenum target) {
    GLuint name = 0;
    switch (kind) {
        case ObjectKind::buffer:
            glCreateBuffers(1, &name);
            break;
        case ObjectKind::texture:
            glCreateTextures(target, 1, &name);
            break;
        case ObjectKind::framebuffer:
            glCreateFramebuffers(1, &name);
            break;
        case ObjectKind::vertex_array:
            glCreateVertexArrays(1, &name);
            break;
        case ObjectKind::program:
            name = glCreateProgram();
            break;
        case ObjectKind::query:
            glCreateQueries(target, 1, &name);
            break;
    }
    if (name != 0) ++counts[std::size_t(kind)];
    return name;
}

void destroy(ObjectKind kind, GLuint name) {
    switch (kind) {
        case ObjectKind::buffer:
            glDeleteBuffers(1, &name);
            break;
        case ObjectKind::texture:
            glDeleteTextures(1, &name);
            break;
        case ObjectKind::framebuffer:
            glDeleteFramebuffers(1, &name);
            break;
        case ObjectKind::vertex_array:
            glDeleteVertexArrays(1, &name);
            break;
        case ObjectKind::program:
            glDeleteProgram(name);
            break;
        case ObjectKind::query:
            glDeleteQueries(1, &name);
            break;
    }
    --counts[std::size_t(kind)];
}

}  // namespace detail
}  // namespace farfield::opengl
