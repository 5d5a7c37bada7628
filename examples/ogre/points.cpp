#include "points.hpp"

#include <OgreHardwareBufferManager.h>
#include <OgreTechnique.h>

#include <algorithm>
#include <cstddef>
#include <glm/geometric.hpp>

#include "material.hpp"

namespace far_ogre {
namespace {

constexpr const char* vertex_shader = R"(#version 150
uniform mat4 to_clip;
uniform mat4 projection;
uniform vec4 viewport_size;
in vec4 vertex;
in vec4 colour;
in vec3 uv0;
flat out vec2 half_size;
flat out float point_size;
flat out vec4 seen;
void main() {
    gl_Position = to_clip * vertex;
    half_size = 0.25 * uv0.xy * abs(vec2(projection[0][0], projection[1][1])) * viewport_size.xy / gl_Position.w;
    gl_PointSize = point_size = 2 * max(half_size.x, half_size.y) + 1;  // all pixels that it meets, if only in part
    seen = vec4(colour.rgb, uv0.z);
}
)";

constexpr const char* fragment_shader = R"(#version 150
flat in vec2 half_size;
flat in float point_size;
flat in vec4 seen;
out vec4 color;
void main() {
    vec2 from_middle = abs(gl_PointCoord - 0.5) * point_size;
    vec2 met = max(min(from_middle + 0.5, half_size) - max(from_middle - 0.5, -half_size), 0);
    color = vec4(seen.rgb, 1) * (seen.a * met.x * met.y);
}
)";

Ogre::MaterialPtr material() {
    const Ogre::MaterialPtr made = material_of("far_ogre/points", vertex_shader, fragment_shader);
    Ogre::Pass& pass = *made->getTechnique(0)->getPass(0);
    pass.setSceneBlending(Ogre::SBF_ONE, Ogre::SBF_ONE_MINUS_SOURCE_ALPHA);
    pass.setDepthWriteEnabled(false);
    const Ogre::GpuProgramParametersPtr parameters = pass.getVertexProgramParameters();
    parameters->setNamedAutoConstant("projection", Ogre::GpuProgramParameters::ACT_PROJECTION_MATRIX);
    parameters->setNamedAutoConstant("viewport_size", Ogre::GpuProgramParameters::ACT_VIEWPORT_SIZE);
    return made;
}

}  // namespace

Points::Points() {
    Ogre::VertexDeclaration& declaration = *vertices_.vertexDeclaration;
    declaration.addElement(0, offsetof(Point, place), Ogre::VET_FLOAT3, Ogre::VES_POSITION);
    declaration.addElement(0, offsetof(Point, size), Ogre::VET_FLOAT3, Ogre::VES_TEXTURE_COORDINATES);
    declaration.addElement(0, offsetof(Point, color), Ogre::VET_UBYTE4_NORM, Ogre::VES_DIFFUSE);
    piece_.material = material();
    piece_.operation.operationType = Ogre::RenderOperation::OT_POINT_LIST;
    piece_.operation.useIndexes = false;
    piece_.operation.vertexData = &vertices_;
}

void Points::add(std::span<const farfield::Splat> splats, const glm::dmat4& to_eye) {
    const auto scale = float(glm::length(to_eye[0]));
    for (const farfield::Splat& s : splats) {
        const glm::vec3 place(to_eye * glm::dvec4(s.center, 1));
        points_.push_back({place, s.size * scale, s.opacity, {s.rgb.r, s.rgb.g, s.rgb.b, 255}});
    }
}

Ogre::Renderable* Points::piece() {
    if (points_.empty()) return nullptr;
    std::reverse(points_.begin(), points_.end());
    Ogre::VertexBufferBinding& binding = *vertices_.vertexBufferBinding;
    if (!binding.isBufferBound(0) || binding.getBuffer(0)->getNumVertices() < points_.size()) {
        binding.setBinding(0, Ogre::HardwareBufferManager::getSingleton().createVertexBuffer(
                                  sizeof(Point), 2 * points_.size(), Ogre::HBU_CPU_TO_GPU));
    }
    vertices_.vertexCount = points_.size();
    binding.getBuffer(0)->writeData(0, sizeof(Point) * points_.size(), points_.data(), true);
    return &piece_;
}

}  // namespace far_ogre
