#include "stage.hpp"

#include <chrono>
#include <osg/GraphicsContext>
#include <stdexcept>

namespace far_osg {
namespace {
constexpr double field_of_view_degrees = 45;
}

class Stage::Finish : public osg::Camera::DrawCallback {
  public:
    void operator()(osg::RenderInfo&) const override { glFinish(); }
};

Stage::Stage(osg::ref_ptr<osg::Node> scene, int width, int height) : width_(width), height_(height) {
    osg::ref_ptr<osg::GraphicsContext::Traits> traits = new osg::GraphicsContext::Traits;
    traits->readDISPLAY();
    traits->setUndefinedScreenDetailsToDefaultScreen();
    traits->width = width;
    traits->height = height;
    traits->pbuffer = true;
    traits->alpha = 8;
    traits->stencil = 8;
    context_ = osg::GraphicsContext::createGraphicsContext(traits);
    if (!context_.valid()) throw std::runtime_error("osg: there is no display to make a context for");
    osg::Camera& camera = *viewer_.getCamera();
    camera.setGraphicsContext(context_);
    camera.setViewport(0, 0, width, height);
    camera.setDrawBuffer(GL_FRONT);
    camera.setReadBuffer(GL_FRONT);
    camera.setClearColor({0.62f, 0.72f, 0.82f, 1});
    camera.setProjectionMatrixAsPerspective(field_of_view_degrees, double(width) / height, 1, 10'000);
    camera.setFinalDrawCallback(new Finish);
    viewer_.setLightingMode(osg::View::NO_LIGHT);
    scene->getOrCreateStateSet()->setMode(GL_LIGHTING, osg::StateAttribute::OFF);
    viewer_.setSceneData(scene);
    viewer_.setThreadingModel(osgViewer::Viewer::SingleThreaded);
    viewer_.realize();
    if (!viewer_.isRealized()) throw std::runtime_error("osg: no context could be made");
}

double Stage::frame(const Eye& eye) {
    viewer_.getCamera()->setViewMatrixAsLookAt(eye.at, eye.target, {0, 1, 0});
    const auto begin = std::chrono::steady_clock::now();
    viewer_.frame();
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

farfield::Image Stage::picture() {
    farfield::Image out(width_, height_);
    context_->makeCurrent();
    glReadBuffer(GL_FRONT);
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    for (int y = 0; y < height_; ++y)
        glReadPixels(0, height_ - 1 - y, width_, 1, GL_RGBA, GL_UNSIGNED_BYTE, &out.at(0, y));
    context_->releaseContext();
    for (farfield::Rgba8& pixel : out.pixels()) pixel.a = 255;
    return out;
}

farfield::Image Stage::mean_picture(int side) {
    const farfield::Image fine = picture();
    farfield::Image out(width_ / side, height_ / side);
    const int count = side * side;
    for (int y = 0; y < out.height(); ++y) {
        for (int x = 0; x < out.width(); ++x) {
            int sum[3] = {count / 2, count / 2, count / 2};
            for (int v = 0; v < side; ++v) {
                for (int u = 0; u < side; ++u) {
                    const farfield::Rgba8 c = fine.at(x * side + u, y * side + v);
                    sum[0] += c.r, sum[1] += c.g, sum[2] += c.b;
                }
            }
            const auto mean = [&](int i) { return static_cast<std::uint8_t>(sum[i] / count); };
            out.at(x, y) = {mean(0), mean(1), mean(2), 255};
        }
    }
    return out;
}

}  // namespace far_osg
