// Triangles on the GPU: a source's primitives in the hierarchy's order, so that a run is one range of vertices.
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "farfield/drawables.hpp"
#include "farfield/geometry/box.hpp"
#include "farfield/geometry/polygon.hpp"
#include "farfield/primitive.hpp"
#include "opengl/objects.hpp"

namespace farfield::opengl {

struct Vertex {
    glm::vec3 position;
    Rgba8 color;
};
struct TriangleVertices {
    std::array<Vertex, 3> corner;
};
static_assert(sizeof(TriangleVertices) == 48);

/// Vertices that an engine has on the GPU already, and keeps there while sources of them are uploaded.
struct MeshVertices {
    GLuint buffer = 0;
    GLintptr first = 0;  ///< byte of the first vertex
    GLsizei stride = 16;
    GLuint position_offset = 0;  ///< three floats, in the user's coordinates
    GLuint color_offset = 12;    ///< four bytes, not premultiplied
    bool is_opaque = true;       ///< all colors are
    friend bool operator==(const MeshVertices&, const MeshVertices&) = default;
};

/// A primitive that is a triangle of such a mesh: of its vertices nothing is copied, but an index buffer made in the
/// hierarchy's order. All primitives of a source must be of one mesh.
template <class P>
concept MeshTriangle = requires(const P& p) {
    { p.gl_vertices() } -> std::convertible_to<MeshVertices>;
    { p.gl_indices() } -> std::convertible_to<std::array<std::uint32_t, 3>>;
};

struct TriangleSource {
    Buffer own;  ///< vertices, or indices of a mesh
    MeshVertices vertices{};
    bool is_indexed = false;
    bool has_translucent = false;
    glm::vec3 origin{0};  ///< of the vertices' coordinates: add it to local ones
    std::uint32_t triangles = 0;
    Box box = Box::empty();                       ///< of all, in local coordinates
    std::vector<std::uint32_t> first_triangle{};  ///< by position, and the end; empty: each has one

    std::uint32_t first_of(std::uint32_t position) const {
        return first_triangle.empty() ? position : first_triangle[position];
    }
    std::size_t bytes() const {
        return triangles * (is_indexed ? std::size_t(12) : sizeof(TriangleVertices)) +
               first_triangle.capacity() * sizeof(std::uint32_t);
    }
};

/// Calls sink(TriangleVertices) with what a polygon fans out into.
template <class Sink>
void for_triangles_of(const Polygon& polygon, Sink&& sink) {
    const bool one_color = polygon.colors.size() < polygon.vertices.size();
    for_each_triangle(polygon.vertices.size(), [&](std::size_t a, std::size_t b, std::size_t c) {
        const auto vertex = [&](std::size_t i) {
            return Vertex{polygon.vertices[i], polygon.colors[one_color ? 0 : i]};
        };
        sink(TriangleVertices{{vertex(a), vertex(b), vertex(c)}});
    });
}

inline bool is_translucent(const TriangleVertices& t) {
    return (t.corner[0].color.a & t.corner[1].color.a & t.corner[2].color.a) != 255;
}

namespace detail {

/// A new buffer's memory, to be filled once and in order.
class MappedBuffer {
  public:
    explicit MappedBuffer(std::size_t bytes) : buffer_(make_buffer()) {
        if (bytes == 0) return;
        const auto size = GLsizeiptr(bytes);
        glNamedBufferStorage(buffer_.name(), size, nullptr, GL_MAP_WRITE_BIT);
        data_ = glMapNamedBufferRange(buffer_.name(), 0, size, GL_MAP_WRITE_BIT | GL_MAP_INVALIDATE_BUFFER_BIT);
        if (data_ == nullptr) throw std::runtime_error("OpenGL has no memory for " + std::to_string(bytes) + " bytes");
    }
    void* data() const { return data_; }
    Buffer finish() {
        if (data_ != nullptr) glUnmapNamedBuffer(buffer_.name());
        data_ = nullptr;
        return std::move(buffer_);
    }

  private:
    Buffer buffer_;
    void* data_ = nullptr;
};

template <class P>
TriangleSource upload_indices(const Source<P>& source) {
    TriangleSource out;
    out.is_indexed = true;
    out.origin = glm::vec3(source.origin);
    out.triangles = source.item_count;
    if (source.item_count == 0) return out;
    out.vertices = source[0].gl_vertices();
    out.has_translucent = !out.vertices.is_opaque;
    MappedBuffer indices(std::size_t(source.item_count) * 12);
    auto* to = static_cast<std::array<std::uint32_t, 3>*>(indices.data());
    for (std::uint32_t at = 0; at < source.item_count; ++at) {
        if (!(MeshVertices(source[at].gl_vertices()) == out.vertices))
            throw std::invalid_argument("GlRenderer: triangles of two meshes are in one source");
        to[at] = source[at].gl_indices();
        const Box box = local_bounds(source[at], source.origin);
        out.box = {glm::min(out.box.lower, box.lower), glm::max(out.box.upper, box.upper)};
    }
    out.own = indices.finish();
    return out;
}

}  // namespace detail

/// Sources that change have nothing that could be uploaded.
template <PrimitiveWithPolygons P>
TriangleSource upload_triangles(const Source<P>& source) {
    if (source.changes) return {};
    if constexpr (MeshTriangle<P>) {
        if (source.fragments.empty()) return detail::upload_indices(source);
    }
    TriangleSource out;
    bool one_each = true;
    out.first_triangle.reserve(std::size_t(source.item_count) + 1);
    for (std::uint32_t at = 0; at < source.item_count; ++at) {
        out.first_triangle.push_back(out.triangles);
        source.prefetch(at);
        source.polygons(at, [&](const Polygon& p) { out.triangles += std::uint32_t(p.vertices.size() - 2); });
        one_each = one_each && out.triangles == at + 1;
    }
    out.first_triangle.push_back(out.triangles);
    if (one_each) out.first_triangle = std::vector<std::uint32_t>();
    detail::MappedBuffer vertices(out.triangles * sizeof(TriangleVertices));
    auto* to = static_cast<TriangleVertices*>(vertices.data());
    for (std::uint32_t at = 0; at < source.item_count; ++at) {
        source.prefetch(at);
        source.polygons(at, [&](const Polygon& p) {
            for_triangles_of(p, [&](const TriangleVertices& t) {
                out.has_translucent = out.has_translucent || is_translucent(t);
                for (const Vertex& v : t.corner) out.box.add(v.position);
                *to++ = t;
            });
        });
    }
    out.own = vertices.finish();
    out.vertices.buffer = out.own.name();
    return out;
}

}  // namespace farfield::opengl
