#include "scene.hpp"

#include <OgreSubEntity.h>
#include <OgreSubMesh.h>
#include <OgreTechnique.h>

#include <cmath>
#include <glm/gtc/matrix_inverse.hpp>
#include <stdexcept>
#include <string>

#include "farfield/build.hpp"
#include "farfield/executor.hpp"

namespace far_ogre {
namespace {

[[noreturn]] void refuse(const std::string& why) {
    throw std::invalid_argument(why);
}

bool is_finite(const glm::dvec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

void check(const Ogre::MaterialPtr& material) {
    material->load();
    const Ogre::Technique* technique = material->getBestTechnique();
    if (technique == nullptr || technique->getNumPasses() != 1) refuse("its material must have one pass");
    const Ogre::Pass& pass = *technique->getPass(0);
    if (pass.getNumTextureUnitStates() != 0) refuse("it has a texture, which stand-ins would lack");
    if (pass.getLightingEnabled()) refuse("it is lit, and stand-ins are not: bake the light into its colors");
    if (pass.isTransparent()) refuse("it is blended, which needs an order of its own");
}

}  // namespace

Scene::Scene(const Ogre::SceneNode& root) {
    const std::string name = "far_ogre: node '" + root.getName() + "': ";
    const glm::dmat4 from_world = glm::affineInverse(to_glm(root._getFullTransform()));
    for (int column = 0; column < 4; ++column) {
        if (!is_finite(from_world[column])) refuse(name + "its place has no inverse, so nothing lies relative to it");
    }
    read(root, from_world);
    try {
        hierarchy_ = farfield::build<Hierarchy>(placements_);
    } catch (const std::invalid_argument& error) {
        refuse(name + error.what());
    }
}

void Scene::read(const Ogre::SceneNode& node, const glm::dmat4& from_world) {
    for (const Ogre::MovableObject* object : node.getAttachedObjects()) {
        if (!object->getVisible()) continue;
        const auto name = [&] {
            return "far_ogre: node '" + node.getName() + "', " + object->getMovableType() + " '" + object->getName() +
                   "': ";
        };
        try {
            const auto* entity = dynamic_cast<const Ogre::Entity*>(object);
            if (entity == nullptr) refuse("it is no entity, whose triangles could be read");
            if (entity->hasSkeleton() || entity->hasVertexAnimation()) refuse("it is animated");
            for (Ogre::SubEntity* part : entity->getSubEntities()) {
                if (part->isVisible()) place(*part, from_world * to_glm(node._getFullTransform()));
            }
        } catch (const std::invalid_argument& error) {
            refuse(name() + error.what());
        } catch (const Ogre::Exception& error) {
            refuse(name() + error.getDescription());
        }
    }
    for (const Ogre::Node* child : node.getChildren()) {
        if (const auto* scene_node = dynamic_cast<const Ogre::SceneNode*>(child)) read(*scene_node, from_world);
    }
}

void Scene::place(Ogre::SubEntity& entity, const glm::dmat4& to_scene) {
    Body*& shared = shared_[{entity.getSubMesh(), entity.getMaterial().get()}];
    if (shared == nullptr) {
        const Part part = part_of(entity);
        if (part.triangles == 0) return;
        shared = &body_of(part);
    }
    Body* body = shared;
    farfield::Similarity placed;
    try {
        placed = farfield::Similarity(to_scene);
    } catch (const std::invalid_argument&) {
        Part stretched = shared->part;
        stretched.to_body = to_scene;
        body = &body_of(stretched);
    }
    placements_.push_back({&body->hierarchy, body->part, placed});
}

Part Scene::part_of(Ogre::SubEntity& entity) {
    const Ogre::SubMesh& sub_mesh = *entity.getSubMesh();
    check(entity.getMaterial());
    if (sub_mesh.operationType != Ogre::RenderOperation::OT_TRIANGLE_LIST) refuse("its primitives are not triangles");
    Part part;
    part.mesh = entity.getParent()->getMesh();
    part.material = entity.getMaterial();
    part.vertex_data = sub_mesh.useSharedVertices ? sub_mesh.parent->sharedVertexData : sub_mesh.vertexData;
    const Ogre::IndexData& indices = *sub_mesh.indexData;
    if (part.vertex_data == nullptr || part.vertex_data->vertexCount + indices.indexCount == 0) return part;
    const Ogre::VertexData& vertices = *part.vertex_data;
    const auto elements = [&](Ogre::VertexElementSemantic semantic, Ogre::VertexElementType type, const char* wanted) {
        const Ogre::VertexElement* element = vertices.vertexDeclaration->findElementBySemantic(semantic);
        if (element == nullptr) return Elements{};
        if (element->getType() != type) refuse(wanted);
        const Ogre::VertexBufferBinding& buffers = *vertices.vertexBufferBinding;
        if (!buffers.isBufferBound(element->getSource())) refuse("a buffer of its vertices is missing");
        const Ogre::HardwareVertexBufferSharedPtr buffer = buffers.getBuffer(element->getSource());
        const std::size_t stride = buffer->getVertexSize();
        if (vertices.vertexStart + std::size_t(vertices.vertexCount) > buffer->getNumVertices() ||
            element->getOffset() + element->getSize() > stride)
            refuse("a buffer of its vertices ends before they do");
        return Elements{buffers_.open(buffer) + stride * vertices.vertexStart + element->getOffset(), stride};
    };
    part.places = elements(Ogre::VES_POSITION, Ogre::VET_FLOAT3, "its vertices must be of three floats");
    part.colors = elements(Ogre::VES_DIFFUSE, Ogre::VET_UBYTE4_NORM, "its colors must be of four bytes");
    std::size_t corners = vertices.vertexCount;
    if (indices.indexCount != 0) {
        if (!indices.indexBuffer || indices.indexStart + indices.indexCount > indices.indexBuffer->getNumIndexes())
            refuse("a buffer of its indices is missing, or ends before they do");
        const std::size_t size = indices.indexBuffer->getIndexSize();
        part.indices = {buffers_.open(indices.indexBuffer) + size * indices.indexStart, size};
        corners = indices.indexCount;
    }
    part.triangles = std::uint32_t(corners / 3);
    for (std::uint32_t triangle = 0; triangle < part.triangles; ++triangle) {
        for (const std::uint32_t i : part.corners(triangle)) {
            if (i >= vertices.vertexCount) {
                refuse("an index is " + std::to_string(i) + ", of " + std::to_string(vertices.vertexCount) +
                       " vertices");
            }
        }
    }
    if (part.triangles != 0 && part.places.first == nullptr) refuse("its vertices have no places");
    return part;
}

Scene::Body& Scene::body_of(const Part& part) {
    for (std::uint32_t triangle = 0; triangle < part.triangles; ++triangle) {
        for (const std::uint32_t i : part.corners(triangle)) {
            if (!is_finite(part.vertex_at(i))) refuse("vertex " + std::to_string(i) + " is not finite");
        }
    }
    Body& body = bodies_.emplace_back(Body{part});
    body.hierarchy = farfield::build<Hierarchy>(body.part, {.executor = farfield::ThreadExecutor()});
    return body;
}

}  // namespace far_ogre
