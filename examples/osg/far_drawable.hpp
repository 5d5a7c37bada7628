// A drawable that shows a scene by farfield, among whatever else osg draws.
//
//     const auto scene = std::make_shared<far_osg::Scene>(*forest);
//     root->addChild(new far_osg::FarDrawable(scene));   // in the forest's place
#pragma once

#include <memory>
#include <osg/Viewport>

#include "farfield/viewer.hpp"
#include "renderer.hpp"

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

    osg::BoundingBox computeBoundingBox() const override { return scene_->bounds(); }
    void drawImplementation(osg::RenderInfo& info) const override {
        const osg::State& state = *info.getState();
        const osg::Viewport& viewport = *state.getCurrentViewport();
        const glm::dmat4 view = glm::make_mat4(state.getModelViewMatrix().ptr());
        const glm::dmat4 projection = glm::make_mat4(state.getProjectionMatrix().ptr());
        renderer_.prepare(info, glm::translate(view, scene_->hierarchy().origin()));
        stats_ = viewer_.frame(
            {.camera = farfield::Camera::from_matrices(view, projection, farfield::ClipDepth::minus_one_to_one),
             .width = int(viewport.width()),
             .height = int(viewport.height()),
             .tolerance_px = tolerance_px});
    }

  private:
    std::shared_ptr<const Scene> scene_;
    mutable Renderer renderer_;
    mutable farfield::Viewer<Hierarchy, Placement, Renderer> viewer_;
    mutable farfield::FrameStats stats_;
};

}  // namespace far_osg
