// An object that shows what lies below a scene node by farfield, among whatever else Ogre draws.
//
//     far_ogre::FarField far_field(*forest);          // reads the entities below
//     forest->getParentSceneNode()->removeChild(forest);
//     root->attachObject(&far_field);                 // in the forest's place
#pragma once

#include <OgreCamera.h>
#include <OgreMovableObject.h>
#include <OgreViewport.h>

#include "farfield/viewer.hpp"
#include "renderer.hpp"
#include "scene.hpp"

namespace far_ogre {

/// Colors are drawn as they are, without lights. It may be attached to any node without stretch, and seen by several
/// cameras. It keeps the meshes, and must go before Ogre::Root does.
class FarField : public Ogre::MovableObject {
  public:
    float tolerance_px = 1;

    explicit FarField(const Ogre::SceneNode& node)
        : scene_(node), viewer_(scene_.hierarchy(), scene_.placements(), renderer_) {
        scene_.close_buffers();
        setCastShadows(false);
        const farfield::Box box = scene_.hierarchy().bounds();
        if (box.is_empty()) return;
        const glm::dvec3 origin = scene_.hierarchy().origin();
        const glm::vec3 lower(glm::dvec3(box.lower) + origin), upper(glm::dvec3(box.upper) + origin);
        bounds_ = {lower.x, lower.y, lower.z, upper.x, upper.y, upper.z};
    }
    const Scene& scene() const { return scene_; }
    const farfield::FrameStats& stats() const { return stats_; }  ///< of the last frame

    const Ogre::String& getMovableType() const override {
        static const Ogre::String type = "far_ogre::FarField";
        return type;
    }
    const Ogre::AxisAlignedBox& getBoundingBox() const override { return bounds_; }
    Ogre::Real getBoundingRadius() const override { return Ogre::Math::boundingRadiusFromAABB(bounds_); }
    void visitRenderables(Ogre::Renderable::Visitor*, bool) override {}
    void _notifyCurrentCamera(Ogre::Camera* camera) override {
        MovableObject::_notifyCurrentCamera(camera);
        camera_ = camera;
    }
    void _updateRenderQueue(Ogre::RenderQueue* queue) override {
        const glm::dmat4 view = to_glm(camera_->getViewMatrix(true)) * to_glm(_getParentNodeFullTransform());
        const glm::dmat4 projection = to_glm(camera_->getProjectionMatrix());
        renderer_.prepare(glm::translate(view, scene_.hierarchy().origin()));
        stats_ = viewer_.frame(
            {.camera = farfield::Camera::from_matrices(view, projection, farfield::ClipDepth::minus_one_to_one),
             .width = camera_->getViewport()->getActualWidth(),
             .height = camera_->getViewport()->getActualHeight(),
             .tolerance_px = tolerance_px});
        renderer_.add_to(*queue);
    }

  private:
    Scene scene_;
    Renderer renderer_;
    farfield::Viewer<Hierarchy, Placement, Renderer> viewer_;
    farfield::FrameStats stats_;
    Ogre::AxisAlignedBox bounds_;
    Ogre::Camera* camera_ = nullptr;
};

}  // namespace far_ogre
