// A window that nobody sees, for one scene: draws a frame, takes its time, and reads the picture back.
#pragma once

#include <osg/Node>
#include <osgViewer/Viewer>

#include "farfield/image.hpp"

namespace far_osg {

struct Eye {
    osg::Vec3d at, target;
};

class Stage {
  public:
    /// Throws std::runtime_error, one line, where there is no display or no OpenGL 3.0.
    Stage(osg::ref_ptr<osg::Node> scene, int width, int height);

    ~Stage();

    /// In milliseconds, from the first call to the end of glFinish.
    double frame(const Eye& eye);
    /// Of the last frame; opaque.
    const farfield::Image& picture() const;
    /// Its mean over squares of pixels.
    farfield::Image mean_picture(int side) const;

  private:
    class Finish;
    osg::ref_ptr<osg::GraphicsContext> context_;
    osg::ref_ptr<Finish> finish_;
    osgViewer::Viewer viewer_;
};

}  // namespace far_osg
