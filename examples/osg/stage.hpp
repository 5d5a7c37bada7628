// A window that nobody sees, for one scene: draws a frame, takes its time, and reads the picture back.
#pragma once

#include <osgViewer/Viewer>

#include "engines/compare.hpp"
#include "far_drawable.hpp"

namespace far_osg {

class Stage : public farfield::engines::Stage {
  public:
    /// Throws std::runtime_error, one line, where there is no display or no OpenGL 3.0.
    Stage(osg::ref_ptr<osg::Node> scene, int width, int height, osg::ref_ptr<const FarDrawable> far_field = nullptr);
    ~Stage() override;

    double frame(const farfield::engines::Eye& eye) override;
    const farfield::Image& picture() const override;
    farfield::FrameStats stats() const override;

  private:
    class Finish;
    osg::ref_ptr<osg::GraphicsContext> context_;
    osg::ref_ptr<Finish> finish_;
    osg::ref_ptr<const FarDrawable> far_field_;
    osgViewer::Viewer viewer_;
};

}  // namespace far_osg
