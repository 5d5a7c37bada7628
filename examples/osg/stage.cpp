#include "stage.hpp"

#include <chrono>
#include <osg/GraphicsContext>
#include <stdexcept>

namespace far_osg {
namespace {
constexpr double field_of_view_degrees = 45;
}

/// Takes the time and the picture before buffers are swapped, and it is gone.
class Stage::Finish : public osg::Camera::DrawCallback {
  public:
    Finish(int width, int height) : picture(width, height) {}

    void operator()(osg::RenderInfo&) const override {
        glFinish();
        end = std::chrono::steady_clock::now();
        glReadBuffer(GL_BACK);
        glPixelStorei(GL_PACK_ALIGNMENT, 4);
        for (int y = 0; y < picture.height(); ++y) {
            glReadPixels(0, picture.height() - 1 - y, picture.width(), 1, GL_RGBA, GL_UNSIGNED_BYTE, &picture.at(0, y));
        }
        for (farfield::Rgba8& pixel : picture.pixels()) pixel.a = 255;
    }

    mutable farfield::Image picture;
    mutable std::chrono::steady_clock::time_point end;
};

Stage::Stage(osg::ref_ptr<osg::Node> scene, int width, int height, osg::ref_ptr<const FarDrawable> far_field)
    : finish_(new Finish(width, height)), far_field_(far_field) {
    osg::ref_ptr<osg::GraphicsContext::Traits> traits = new osg::GraphicsContext::Traits;
    traits->readDISPLAY();
    traits->setUndefinedScreenDetailsToDefaultScreen();
    traits->width = width;
    traits->height = height;
    traits->pbuffer = true;
    traits->doubleBuffer = true;
    traits->stencil = 8;  // as the buffer of deposits has, which takes the window's depths
    context_ = osg::GraphicsContext::createGraphicsContext(traits);
    if (!context_.valid()) throw std::runtime_error("osg: there is no display to make a context for");
    osg::Camera& camera = *viewer_.getCamera();
    camera.setGraphicsContext(context_);
    camera.setViewport(0, 0, width, height);
    camera.setDrawBuffer(GL_BACK);
    camera.setReadBuffer(GL_BACK);
    camera.setClearColor({0.62f, 0.72f, 0.82f, 1});
    camera.setProjectionMatrixAsPerspective(field_of_view_degrees, double(width) / height, 1, 10'000);
    camera.setFinalDrawCallback(finish_);
    viewer_.setLightingMode(osg::View::NO_LIGHT);
    scene->getOrCreateStateSet()->setMode(GL_LIGHTING, osg::StateAttribute::OFF);
    viewer_.setSceneData(scene);
    viewer_.setThreadingModel(osgViewer::Viewer::SingleThreaded);
    viewer_.realize();
    if (!viewer_.isRealized()) throw std::runtime_error("osg: no context could be made");
}

double Stage::frame(const farfield::engines::Eye& eye) {
    const auto point = [](const glm::dvec3& p) { return osg::Vec3d(p.x, p.y, p.z); };
    viewer_.getCamera()->setViewMatrixAsLookAt(point(eye.at), point(eye.target), {0, 1, 0});
    const auto begin = std::chrono::steady_clock::now();
    viewer_.frame();
    return std::chrono::duration<double, std::milli>(finish_->end - begin).count();
}

Stage::~Stage() = default;

const farfield::Image& Stage::picture() const {
    return finish_->picture;
}

farfield::FrameStats Stage::stats() const {
    return far_field_.valid() ? far_field_->stats() : farfield::FrameStats{};
}

}  // namespace far_osg
