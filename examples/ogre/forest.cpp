#include "forest.hpp"

#include <OgreEntity.h>
#include <OgreHardwareBufferManager.h>
#include <OgreLodConfig.h>
#include <OgreMeshLodGenerator.h>
#include <OgreMeshManager.h>
#include <OgrePixelCountLodStrategy.h>
#include <OgreStaticGeometry.h>
#include <OgreSubMesh.h>

#include <cmath>

#include "material.hpp"

namespace far_ogre {
namespace {

constexpr const char* vertex_shader = R"(#version 150
uniform mat4 to_clip;
in vec4 vertex;
in vec4 colour;
out vec4 shade;
void main() {
    gl_Position = to_clip * vertex;
    shade = colour;
}
)";
constexpr const char* fragment_shader = R"(#version 150
in vec4 shade;
out vec4 color;
void main() { color = shade; }
)";

struct Vertex {
    glm::vec3 place;
    farfield::Rgba8 color;
};

Ogre::Vector3 vector(const glm::dvec3& p) {
    return {Ogre::Real(p.x), Ogre::Real(p.y), Ogre::Real(p.z)};
}
Ogre::Quaternion turned(double angle) {
    return {Ogre::Radian(Ogre::Real(angle)), Ogre::Vector3::UNIT_Y};
}

}  // namespace

Ogre::MeshPtr mesh_of(const std::string& name, const farfield::engines::Mesh& mesh) {
    const Ogre::MeshPtr made = Ogre::MeshManager::getSingleton().createManual(name, Ogre::RGN_DEFAULT);
    auto& buffers = Ogre::HardwareBufferManager::getSingleton();
    Ogre::SubMesh& sub_mesh = *made->createSubMesh();
    sub_mesh.useSharedVertices = false;
    sub_mesh.setMaterial(material_of("far_ogre/vertex colors", vertex_shader, fragment_shader));
    std::vector<Vertex> vertices;
    Ogre::AxisAlignedBox bounds;
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
        vertices.push_back({mesh.vertices[i], mesh.colors[i]});
        bounds.merge(vector(mesh.vertices[i]));
    }
    const auto vertex_buffer = buffers.createVertexBuffer(sizeof(Vertex), vertices.size(), Ogre::HBU_GPU_ONLY);
    vertex_buffer->writeData(0, sizeof(Vertex) * vertices.size(), vertices.data(), true);
    sub_mesh.vertexData = OGRE_NEW Ogre::VertexData;
    sub_mesh.vertexData->vertexCount = vertices.size();
    sub_mesh.vertexData->vertexBufferBinding->setBinding(0, vertex_buffer);
    sub_mesh.vertexData->vertexDeclaration->addElement(0, 0, Ogre::VET_FLOAT3, Ogre::VES_POSITION);
    sub_mesh.vertexData->vertexDeclaration->addElement(0, 12, Ogre::VET_UBYTE4_NORM, Ogre::VES_DIFFUSE);
    sub_mesh.indexData->indexBuffer =
        buffers.createIndexBuffer(Ogre::HardwareIndexBuffer::IT_32BIT, mesh.corners.size(), Ogre::HBU_GPU_ONLY);
    sub_mesh.indexData->indexBuffer->writeData(0, 4 * mesh.corners.size(), mesh.corners.data(), true);
    sub_mesh.indexData->indexCount = mesh.corners.size();
    made->_setBounds(bounds);
    made->_setBoundingSphereRadius(Ogre::Math::boundingRadiusFromAABB(bounds));
    made->load();
    return made;
}

Forest::Forest(const farfield::engines::Forest& forest)
    : trees_(forest.trees), ground_(mesh_of("ground", forest.ground)) {
    for (const auto& tree : forest.kinds) {
        kinds_.push_back(mesh_of("tree " + std::to_string(kinds_.size()), tree));
    }
}

void Forest::plain(Ogre::SceneManager& manager) const {
    add_ground(manager);
    add_trees(*manager.getRootSceneNode(), kinds_);
}

void Forest::with_levels(Ogre::SceneManager& manager) const {
    Ogre::MeshLodGenerator generator;
    std::vector<Ogre::MeshPtr> levels;
    for (const Ogre::MeshPtr& kind : kinds_) {
        Ogre::MeshPtr mesh = levels.emplace_back(kind->clone(kind->getName() + " in levels"));
        Ogre::LodConfig config(mesh, Ogre::AbsolutePixelCountLodStrategy::getSingletonPtr());
        config.advanced.useVertexNormals = false;
        for (const float least_px : {200.0f, 100.0f, 50.0f}) {
            const auto level = Ogre::Real(config.levels.size() + 1);
            config.createGeneratedLodLevel(Ogre::Math::PI / 4 * least_px * least_px, 1 - std::exp2(-level));
        }
        generator.generateLodLevels(config);
    }
    add_ground(manager);
    add_trees(*manager.getRootSceneNode(), levels);
}

void Forest::static_geometry(Ogre::SceneManager& manager) const {
    Ogre::StaticGeometry& all = *manager.createStaticGeometry("trees");
    all.setRegionDimensions(Ogre::Vector3(8 * Ogre::Real(farfield::engines::Forest::spacing_m)));
    std::vector<Ogre::Entity*> kinds;
    for (const Ogre::MeshPtr& kind : kinds_) kinds.push_back(manager.createEntity(kind));
    for (const auto& tree : trees_) {
        all.addEntity(kinds[tree.kind], vector(tree.at), turned(tree.turn), Ogre::Vector3(Ogre::Real(tree.size)));
    }
    all.build();
    add_ground(manager);
}

std::unique_ptr<FarField> Forest::far_field(Ogre::SceneManager& manager, float tolerance_px) const {
    Ogre::SceneNode& trees = *manager.createSceneNode("trees");  // in no scene: it is read, and not drawn
    add_trees(trees, kinds_);
    auto far_field = std::make_unique<FarField>(trees);
    far_field->tolerance_px = tolerance_px;
    manager.getRootSceneNode()->attachObject(far_field.get());
    add_ground(manager);
    return far_field;
}

void Forest::add_ground(Ogre::SceneManager& manager) const {
    manager.getRootSceneNode()->attachObject(manager.createEntity(ground_));
}

void Forest::add_trees(Ogre::SceneNode& below, const std::vector<Ogre::MeshPtr>& kinds) const {
    for (const auto& tree : trees_) {
        Ogre::SceneNode& node = *below.createChildSceneNode(vector(tree.at), turned(tree.turn));
        node.setScale(Ogre::Vector3(Ogre::Real(tree.size)));
        node.attachObject(below.getCreator()->createEntity(kinds[tree.kind]));
    }
}

}  // namespace far_ogre
