// An engine's own mesh as primitives: its vertices stay where they are.
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "farfield/approximation/color_cube.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/viewer.hpp"
#include "opengl/setting.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

struct Mesh {
    std::vector<opengl::Vertex> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    opengl::MeshVertices on_gpu;
};

/// A triangle of a mesh.
struct MeshFace {
    const Mesh* mesh;
    std::uint32_t triangle;

    const opengl::Vertex& corner(std::size_t i) const { return mesh->vertices[mesh->triangles[triangle][i]]; }
    Box bounds() const { return bounds_of({corner(0).position, corner(1).position, corner(2).position}); }
    template <class Sink>
    void polygons(Sink&& sink) const {
        const std::array vertices{corner(0).position, corner(1).position, corner(2).position};
        const std::array colors{corner(0).color, corner(1).color, corner(2).color};
        sink(Polygon{vertices, colors});
    }
    opengl::MeshVertices gl_vertices() const { return mesh->on_gpu; }
    std::array<std::uint32_t, 3> gl_indices() const { return mesh->triangles[triangle]; }
};
static_assert(opengl::MeshTriangle<MeshFace> && !opengl::MeshTriangle<Triangle>);

Mesh wavy_grid(std::uint32_t side) {
    Mesh mesh;
    for (std::uint32_t y = 0; y <= side; ++y) {
        for (std::uint32_t x = 0; x <= side; ++x) {
            const float u = 2 * float(x) / float(side) - 1, v = 2 * float(y) / float(side) - 1;
            mesh.vertices.push_back({{u, 0.2f * std::sin(5 * u) * std::cos(4 * v), v},
                                     {std::uint8_t(x * 255 / side), std::uint8_t(y * 255 / side), 99, 255}});
        }
    }
    for (std::uint32_t y = 0; y < side; ++y) {
        for (std::uint32_t x = 0; x < side; ++x) {
            const std::uint32_t a = y * (side + 1) + x, b = a + side + 1;
            mesh.triangles.push_back({a, b, a + 1});
            mesh.triangles.push_back({a + 1, b, b + 1});
        }
    }
    return mesh;
}

template <class P>
Image picture(const std::vector<P>& primitives, std::size_t& bytes) {
    const auto hierarchy = build<SpatialHierarchy<Octree, ColorCube, TriangleCount>>(primitives);
    opengl::GlRenderer renderer({.samples = 4});
    auto viewer = make_viewer(hierarchy, primitives, renderer);
    viewer.frame(looking({0.5, 1.5, 2}, {}, 100, 2));
    bytes = renderer.uploaded_bytes();
    return renderer.image();
}

}  // namespace

TEST_CASE("a mesh's vertices are not copied to be drawn", "[opengl]") {
    OpenGl gl;
    if (!gl) return;
    {
        Mesh mesh = wavy_grid(64);
        const opengl::Buffer buffer = opengl::make_buffer();
        glNamedBufferStorage(buffer.name(), GLsizeiptr(mesh.vertices.size() * sizeof(opengl::Vertex)),
                             mesh.vertices.data(), 0);
        mesh.on_gpu.buffer = buffer.name();
        std::vector<MeshFace> faces;
        std::vector<VertexColoredTriangle> copies;
        for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
            faces.push_back({&mesh, i});
            VertexColoredTriangle t;
            for (std::size_t c = 0; c < 3; ++c) {
                t.vertices[c] = faces.back().corner(c).position;
                t.rgba[c] = faces.back().corner(c).color;
            }
            copies.push_back(t);
        }
        std::size_t bytes = 0, bytes_of_copies = 0;
        const Image indexed = picture(faces, bytes);
        CHECK(mean_difference(indexed, picture(copies, bytes_of_copies)) <= 1e-4);
        CHECK(bytes == 12 * faces.size());
        CHECK(bytes_of_copies == 48 * faces.size());
    }
    gl.check_clean();
}

TEST_CASE("triangles of two meshes are refused in one source", "[opengl]") {
    OpenGl gl;
    if (!gl) return;
    {
        Mesh one = wavy_grid(2), other = wavy_grid(2);
        one.on_gpu.buffer = 1;
        other.on_gpu.buffer = 2;
        const std::vector<MeshFace> faces{{&one, 0}, {&other, 0}};
        opengl::GlRenderer renderer;
        CHECK_THROWS_AS(renderer.upload(Source<MeshFace>{faces, {}, 2}), std::invalid_argument);
    }
    gl.check_clean();
}
