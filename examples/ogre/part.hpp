// Triangles of an Ogre::SubMesh as a source of primitives (farfield/primitive_source.hpp), which reads them where they
// lie, in the mesh's own buffers.
#pragma once

#include <OgreHardwareBuffer.h>
#include <OgreMaterial.h>
#include <OgreMesh.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/gtc/type_ptr.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <map>

#include "farfield/primitive_source.hpp"

namespace far_ogre {

inline glm::dmat4 to_glm(const Ogre::TransformBaseReal& m) {
    return glm::dmat4(glm::transpose(glm::make_mat4(m[0])));
}

/// Buffers that are open for reading, each once. The engine may draw from none of them until they are closed.
class OpenBuffers {
  public:
    OpenBuffers() = default;
    OpenBuffers(const OpenBuffers&) = delete;
    OpenBuffers& operator=(const OpenBuffers&) = delete;
    ~OpenBuffers() { close(); }

    const std::byte* open(const Ogre::HardwareBufferPtr& buffer) {
        const auto known = opened_.find(buffer);
        if (known != opened_.end()) return known->second;
        return opened_[buffer] = static_cast<const std::byte*>(buffer->lock(Ogre::HardwareBuffer::HBL_READ_ONLY));
    }
    void close() {
        for (const auto& [buffer, memory] : opened_) buffer->unlock();
        opened_.clear();
    }

  private:
    std::map<Ogre::HardwareBufferPtr, const std::byte*> opened_;
};

/// Something of each vertex, or of each index.
struct Elements {
    const std::byte* first = nullptr;
    std::size_t stride = 0;

    template <class T>
    T at(std::size_t i) const {
        T value;
        std::memcpy(&value, first + stride * i, sizeof value);
        return value;
    }
};

/// A sub-mesh in a material, placed in a body by any affine map: vertices are read and drawn through it. Its triangles
/// are read when hierarchies are built and buffers of indices made, while buffers are open, and not afterwards.
struct Part {
    Ogre::MeshPtr mesh;
    Ogre::MaterialPtr material;
    Ogre::VertexData* vertex_data = nullptr;
    glm::dmat4 to_body{1};
    Elements places, colors, indices;  ///< colors: white where there are none; indices: none, or of 2 or 4 bytes
    std::uint32_t triangles = 0;

    std::array<std::uint32_t, 3> corners(std::uint32_t triangle) const {
        std::array<std::uint32_t, 3> found{3 * triangle, 3 * triangle + 1, 3 * triangle + 2};
        for (std::uint32_t& i : found) {
            if (indices.stride != 0)
                i = indices.stride == 2 ? indices.at<std::uint16_t>(i) : indices.at<std::uint32_t>(i);
        }
        return found;
    }
    glm::dvec3 vertex_at(std::uint32_t i) const { return to_body * glm::dvec4(glm::dvec3(places.at<glm::vec3>(i)), 1); }
    farfield::Rgba8 color_at(std::uint32_t i) const {
        const auto c = colors.first == nullptr ? farfield::Rgba8{255, 255, 255} : colors.at<farfield::Rgba8>(i);
        return {c.r, c.g, c.b, 255};
    }

    std::size_t primitive_count() const { return triangles; }
    farfield::BoxD bounds(std::uint32_t triangle) const {
        farfield::BoxD box = farfield::BoxD::empty();
        for (const std::uint32_t i : corners(triangle)) box.add(vertex_at(i));
        return box;
    }
    template <class Sink>
    void polygons(std::uint32_t triangle, Sink&& sink) const {
        const auto [a, b, c] = corners(triangle);
        const std::array<glm::dvec3, 3> vertices{vertex_at(a), vertex_at(b), vertex_at(c)};
        const std::array<farfield::Rgba8, 3> vertex_colors{color_at(a), color_at(b), color_at(c)};
        sink(farfield::PolygonD{vertices, vertex_colors});
    }
};

}  // namespace far_ogre
