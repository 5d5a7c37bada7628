// OpenGL objects that go with their owner, counted while they live.
#pragma once

#include <array>
#include <cstddef>
#include <utility>

#include "opengl/gl.hpp"

namespace farfield::opengl {

enum class ObjectKind : unsigned char { buffer, texture, framebuffer, vertex_array, program, query };
inline constexpr std::size_t object_kinds = 6;

/// The objects of each kind that live in this program, in all contexts.
std::array<std::size_t, object_kinds> live_objects();

namespace detail {
GLuint create(ObjectKind kind, GLenum target);
void destroy(ObjectKind kind, GLuint name);
}  // namespace detail

/// It must be made and must go while its context is current.
template <ObjectKind kind>
class Object {
  public:
    Object() = default;
    /// `target` matters for textures and queries.
    explicit Object(GLenum target) : name_(detail::create(kind, target)) {}
    Object(Object&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
    Object& operator=(Object&& other) noexcept {
        std::swap(name_, other.name_);
        return *this;
    }
    ~Object() {
        if (name_ != 0) detail::destroy(kind, name_);
    }

    /// 0: there is none.
    GLuint name() const { return name_; }

  private:
    GLuint name_ = 0;
};

using Buffer = Object<ObjectKind::buffer>;
using Texture = Object<ObjectKind::texture>;
using Framebuffer = Object<ObjectKind::framebuffer>;
using VertexArray = Object<ObjectKind::vertex_array>;
using Program = Object<ObjectKind::program>;
using Query = Object<ObjectKind::query>;

inline Buffer make_buffer() {
    return Buffer(GL_NONE);
}
inline Framebuffer make_framebuffer() {
    return Framebuffer(GL_NONE);
}
inline VertexArray make_vertex_array() {
    return VertexArray(GL_NONE);
}

}  // namespace farfield::opengl
