// Pictures of the object against Ogre's own of the same scene, what is read of it, and what is refused by name.
#include "far_field.hpp"

#include <OgreBillboardSet.h>
#include <OgreEntity.h>
#include <OgreRoot.h>
#include <OgreSubEntity.h>
#include <OgreSubMesh.h>
#include <OgreTechnique.h>

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>

#include "catch.hpp"
#include "farfield/measure/flip.hpp"
#include "forest.hpp"
#include "stage.hpp"
#include "support/display.hpp"

using namespace far_ogre;
using farfield::test::Display;

namespace {

constexpr int width = 160, height = 120;

/// Ogre lives as long as the process, and on one display.
bool starts_unseen() {
    static const auto display = Display::open();
    if (!display) return false;
    start();
    return true;
}

/// A square of side 1 with a color at each corner.
Ogre::MeshPtr card() {
    static int number = 0;
    return mesh_of("card " + std::to_string(number++),
                   {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}},
                    {{255, 0, 0, 255}, {0, 255, 0, 255}, {0, 0, 255, 255}, {255, 255, 255, 255}},
                    {0, 1, 2, 0, 2, 3}});
}

/// Cards in nested nodes, of which the outer ones stretch and mirror.
void add_stretched(Ogre::SceneNode& below) {
    const Ogre::MeshPtr mesh = card();
    for (int i = 0; i < 12; ++i) {
        Ogre::SceneNode& outer =
            *below.createChildSceneNode(Ogre::Vector3(4.5f * float(i % 4), 5.0f * float(i / 4), float(-i)),
                                        Ogre::Quaternion(Ogre::Radian(0.3f * float(i)), Ogre::Vector3::UNIT_Y));
        outer.setScale(i % 5 == 0 ? 1.0f : -1.0f, 1 + 0.2f * float(i), 1);
        for (const float moved : {0.0f, 1.2f}) {
            Ogre::SceneNode& inner = *outer.createChildSceneNode(Ogre::Vector3(moved, 0, 0.1f));
            inner.roll(Ogre::Radian(0.1f * float(i)));
            inner.attachObject(below.getCreator()->createEntity(mesh));
        }
    }
}

std::string refusal(const Ogre::SceneNode& node) {
    try {
        const FarField far_field(node);
        return "";
    } catch (const std::invalid_argument& error) {
        return error.what();
    }
}

}  // namespace

TEST_CASE("without a tolerance the picture is Ogre's, whatever nodes stretch and wherever the object is") {
    if (!starts_unseen()) return;
    const farfield::engines::Eye eye{{6, 5, 20}, {6, 5, 0}};
    const auto place = [](Ogre::SceneNode& node) {
        node.setPosition(1, 0.5f, 2);
        node.yaw(Ogre::Radian(0.2f));
        node.setScale(Ogre::Vector3(0.7f));
    };
    Stage plain(
        [&](Ogre::SceneManager& manager) {
            Ogre::SceneNode& node = *manager.getRootSceneNode()->createChildSceneNode();
            place(node);
            add_stretched(node);
            return nullptr;
        },
        width, height);
    Stage exact(
        [&](Ogre::SceneManager& manager) {
            Ogre::SceneNode& cards = *manager.createSceneNode();
            add_stretched(cards);
            auto far_field = std::make_unique<FarField>(cards);
            far_field->tolerance_px = 0;
            Ogre::SceneNode& node = *manager.getRootSceneNode()->createChildSceneNode();
            place(node);
            node.attachObject(far_field.get());
            return far_field;
        },
        width, height);
    plain.frame(eye);
    exact.frame(eye);
    CHECK(exact.stats().is_exact());
    // Ogre's matrices are of single precision: edges and lines where cards meet move by less than a pixel.
    int moved = 0;
    for (std::size_t i = 0; i < plain.picture().pixels().size(); ++i) {
        const farfield::Rgba8 a = plain.picture().pixels()[i], b = exact.picture().pixels()[i];
        moved += std::max({std::abs(a.r - b.r), std::abs(a.g - b.g), std::abs(a.b - b.b)}) > 4;
    }
    CHECK(moved < width * height / 500);
    CHECK(farfield::flip(plain.picture(), farfield::Image(width, height, plain.picture().at(0, 0))) > 0.05);
}

TEST_CASE("a forest in Ogre is drawn by stand-ins, which look like it and hide behind what Ogre draws") {
    if (!starts_unseen()) return;
    const farfield::engines::Forest trees({.trees_a_side = 8, .triangles_a_tree = 4000, .kinds = 2});
    const Forest forest(trees);
    constexpr int side = 4;
    const farfield::engines::Eye eye = trees.eye(0.3);
    const auto fill = [&](Ogre::SceneManager& manager) { return forest.plain(manager), nullptr; };
    Stage fine(fill, width * side, height * side), plain(fill, width, height);
    Stage far_field([&](Ogre::SceneManager& manager) { return forest.far_field(manager, 2); }, width, height);
    for (Stage* stage : {&fine, &plain, &far_field}) stage->frame(eye);
    CHECK(far_field.stats().approximations > 100);
    CHECK(far_field.stats().primitives > 100);
    const farfield::Image reference = farfield::engines::mean_picture(fine.picture(), side);
    CHECK(farfield::flip(far_field.picture(), reference) < farfield::flip(plain.picture(), reference));
}

TEST_CASE("a mesh is there once however often it is placed, and its vertices stay where they are") {
    if (!starts_unseen()) return;
    Ogre::SceneManager& manager = *Ogre::Root::getSingleton().createSceneManager();
    Ogre::SceneNode& node = *manager.createSceneNode();
    const Ogre::MeshPtr mesh = card();
    for (int i = 0; i < 100; ++i) {
        node.createChildSceneNode(Ogre::Vector3(float(i), 0, 0))->attachObject(manager.createEntity(mesh));
    }
    const Scene scene(node);
    REQUIRE(scene.placements().size() == 100);
    for (const Placement& placement : scene.placements()) {
        CHECK(placement.hierarchy == scene.placements()[0].hierarchy);
        CHECK(placement.primitives.data()->vertex_data == mesh->getSubMesh(0)->vertexData);
    }
    CHECK(scene.hierarchy().bounds().size().x == Approx(100));
}

TEST_CASE("what stand-ins in Ogre cannot show is refused, and node and object named") {
    if (!starts_unseen()) return;
    Ogre::SceneManager& manager = *Ogre::Root::getSingleton().createSceneManager();
    const auto check_refused = [&](Ogre::MovableObject* object, const std::string& why) {
        Ogre::SceneNode& root = *manager.createSceneNode();
        Ogre::SceneNode& node = *root.createChildSceneNode("the culprit's " + object->getName());
        node.attachObject(object);
        const std::string said = refusal(root);
        INFO(said);
        CHECK(said.find("'the culprit's " + object->getName() + "'") != std::string::npos);
        CHECK(said.find(why) != std::string::npos);
        object->setVisible(false);
        CHECK(refusal(root).empty());
    };
    check_refused(manager.createBillboardSet(), "no entity");
    const auto with = [&](auto&& change) {
        Ogre::Entity* entity = manager.createEntity(card());
        const Ogre::MaterialPtr material = entity->getSubEntity(0)->getMaterial()->clone(entity->getMesh()->getName());
        change(*material->getTechnique(0)->getPass(0));
        entity->setMaterial(material);
        return entity;
    };
    check_refused(with([](Ogre::Pass& pass) { pass.setLightingEnabled(true); }), "lit");
    check_refused(with([](Ogre::Pass& pass) { pass.createTextureUnitState(); }), "texture");
    check_refused(with([](Ogre::Pass& pass) { pass.setSceneBlending(Ogre::SBT_TRANSPARENT_ALPHA); }), "blended");
    const auto of_mesh = [&](auto&& change) {
        const Ogre::MeshPtr mesh = card();
        change(*mesh->getSubMesh(0));
        return manager.createEntity(mesh);
    };
    check_refused(of_mesh([](Ogre::SubMesh& part) { part.operationType = Ogre::RenderOperation::OT_LINE_LIST; }),
                  "triangles");
    check_refused(of_mesh([](Ogre::SubMesh& part) { part.vertexData->vertexCount = 3; }), "an index is 3, of 3");
    check_refused(of_mesh([](Ogre::SubMesh& part) { part.vertexData->vertexStart = 1; }), "ends before they do");
    check_refused(of_mesh([](Ogre::SubMesh& part) { part.indexData->indexStart = 1; }), "ends before they do");
    check_refused(of_mesh([](Ogre::SubMesh& part) { part.indexData->indexBuffer.reset(); }), "is missing");
    check_refused(of_mesh([](Ogre::SubMesh& part) { part.vertexData->vertexBufferBinding->unsetBinding(0); }),
                  "a buffer of its vertices is missing");
    for (const std::size_t corner : {0, 1, 2}) {
        const float nan = std::numeric_limits<float>::quiet_NaN();
        check_refused(of_mesh([&](Ogre::SubMesh& part) {
                          part.vertexData->vertexBufferBinding->getBuffer(0)->writeData(16 * corner + 4, 4, &nan);
                      }),
                      "vertex " + std::to_string(corner) + " is not finite");
    }
}

TEST_CASE("in Ogre what is empty or has no area is taken, and places that there are not are refused") {
    if (!starts_unseen()) return;
    Ogre::SceneManager& manager = *Ogre::Root::getSingleton().createSceneManager();
    Ogre::SceneNode& root = *manager.createSceneNode("the root");
    CHECK(refusal(root).empty());
    const auto add = [&](const Ogre::MeshPtr& mesh, const Ogre::Vector3& scale) {
        Ogre::SceneNode& node = *root.createChildSceneNode();
        node.setScale(scale);
        node.attachObject(manager.createEntity(mesh));
    };
    const Ogre::MeshPtr nothing = card();
    nothing->getSubMesh(0)->vertexData->vertexCount = 0;
    nothing->getSubMesh(0)->indexData->indexCount = 0;
    add(nothing, Ogre::Vector3(1));
    CHECK(Scene(root).placements().empty());
    add(mesh_of("a point", {{{2, 3, 4}, {2, 3, 4}, {2, 3, 4}}, {{}, {}, {}}, {0, 1, 2}}), Ogre::Vector3(1));
    const Ogre::MeshPtr mesh = card();
    for (const Ogre::Vector3& scale : {Ogre::Vector3(0, 1, 1), Ogre::Vector3(0, 0, 0)}) add(mesh, scale);
    CHECK(Scene(root).placements().size() == 3);
    add(mesh, Ogre::Vector3(3e38f, 1, 1));
    CHECK(refusal(root).find("overflow") != std::string::npos);
    root.setScale(0, 1, 1);
    CHECK(refusal(root).find("node 'the root'") != std::string::npos);
}
