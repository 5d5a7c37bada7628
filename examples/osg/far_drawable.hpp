// A drawable that shows a scene by farfield, among whatever else osg draws.
//
//     const auto scene = std::make_shared<far_osg::Scene>(*forest);
//     root->addChild(new far_osg::FarDrawable(scene));   // in the forest's place
#pragma once

#include <glm/gtc/type_ptr.hpp>
#include <memory>
#include <osg/Drawable>
#include <osg/State>
#include <osg/Viewport>
#include <utility>

#include "farfield/viewer.hpp"
#include "renderer.hpp"
#include "scene.hpp"

namespace far_osg {

/// Belongs to one window. Colors are drawn as they are, without lights.
class FarDrawable : public osg::Drawable {
  public:
    float tolerance_px = 1;

    explicit FarDrawable(std::shared_ptr<const Scene> scene)
        : scene_(std::move(scene)), viewer_(scene_->hierarchy(), scene_->placements(), renderer_) {
        setSupportsDisplayList(false);
        setDataVariance(osg::Object::DYNAMIC);
        getOrCreateStateSet()->setMode(GL_LIGHTING, osg::StateAttribute::OFF);
    }
    const farfield::FrameStats& stats() const { return stats_; }  ///< of the last frame

    osg::BoundingBox computeBoundingBox() const override {
        const farfield::Box box = scene_->hierarchy().bounds();
        if (box.is_empty()) return {};
        const glm::dvec3 origin = scene_->hierarchy().origin();
        const glm::vec3 lower(glm::dvec3(box.lower) + origin), upper(glm::dvec3(box.upper) + origin);
        return {lower.x, lower.y, lower.z, upper.x, upper.y, upper.z};
    }
    void drawImplementation(osg::RenderInfo& info) const override {
        const osg::State& state = *info.getState();
        const osg::Viewport& viewport = *state.getCurrentViewport();
        const osg::Matrixd view = state.getModelViewMatrix();
        farfield::View v{.camera = farfield::Camera::from_matrices(glm::make_mat4(view.ptr()),
                                                                   glm::make_mat4(state.getProjectionMatrix().ptr()),
                                                                   farfield::ClipDepth::minus_one_to_one),
                         .width = int(viewport.width()),
                         .height = int(viewport.height()),
                         .tolerance_px = tolerance_px};
        const glm::dvec3 x(v.camera.right), y(v.camera.up), z(-v.camera.forward), eye = v.camera.eye;
        const osg::Matrixd to_world(x.x, x.y, x.z, 0, y.x, y.y, y.z, 0, z.x, z.y, z.z, 0, eye.x, eye.y, eye.z, 1);
        renderer_.prepare(info, to_world * view);
        stats_ = viewer_.frame(v);
    }

  private:
    std::shared_ptr<const Scene> scene_;
    mutable Renderer renderer_;
    mutable farfield::Viewer<Hierarchy, Placement, Renderer> viewer_;
    mutable farfield::FrameStats stats_;
};

}  // namespace far_osg
