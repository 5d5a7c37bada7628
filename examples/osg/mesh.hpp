// Triangles of an osg::Geometry as primitives: handles that read the geometry's own arrays, which stay where they are.
#pragma once

#include <array>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <osg/Geometry>
#include <osg/Matrixd>
#include <vector>

#include "farfield/primitive.hpp"

namespace far_osg {

/// From the root down to the geometry: what is in force when it is drawn.
using States = std::vector<osg::ref_ptr<osg::StateSet>>;

/// A geometry, placed in a body: any affine map will do, as its vertices are read through it and drawn through it.
struct Mesh {
    osg::ref_ptr<const osg::Geometry> geometry;
    osg::Matrixd to_body;
    States states;
    std::uint32_t number = 0;  ///< in its body

    glm::dvec3 vertex(std::uint32_t i) const {
        const osg::Vec3d v = osg::Vec3d((*static_cast<const osg::Vec3Array*>(geometry->getVertexArray()))[i]) * to_body;
        return {v.x(), v.y(), v.z()};
    }
    /// As OSG draws it without lights; opaque.
    farfield::Rgba8 color(std::uint32_t i) const {
        const osg::Array* colors = geometry->getColorArray();
        if (colors == nullptr || colors->getNumElements() == 0) return {255, 255, 255, 255};
        if (colors->getBinding() == osg::Array::BIND_OVERALL) i = 0;
        if (colors->getType() == osg::Array::Vec4ubArrayType) {
            const osg::Vec4ub c = (*static_cast<const osg::Vec4ubArray*>(colors))[i];
            return {c.r(), c.g(), c.b(), 255};
        }
        const osg::Vec4f c = (*static_cast<const osg::Vec4Array*>(colors))[i];
        return farfield::to_rgba8(glm::vec4(c.r(), c.g(), c.b(), 1));
    }
};

struct MeshTriangle {
    const Mesh* mesh;
    std::array<std::uint32_t, 3> corners;

    farfield::BoxD bounds() const {
        farfield::BoxD box = farfield::BoxD::empty();
        for (const std::uint32_t i : corners) box.add(mesh->vertex(i));
        return box;
    }
    template <class Sink>
    void polygons(Sink&& sink) const {
        std::array<glm::dvec3, 3> vertices;
        std::array<farfield::Rgba8, 3> colors;
        for (std::size_t i = 0; i < 3; ++i) {
            vertices[i] = mesh->vertex(corners[i]);
            colors[i] = mesh->color(corners[i]);
        }
        sink(farfield::PolygonD{vertices, colors});
    }
    std::uint32_t key() const { return mesh->number; }  ///< so that a draw call is of one mesh (KeyedOrder)
};
static_assert(farfield::PrimitiveWithPolygons<MeshTriangle>);

}  // namespace far_osg
