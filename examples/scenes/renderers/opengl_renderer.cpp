#include "scenes/renderers/opengl_renderer.hpp"

#include <memory>

#include "opengl/context.hpp"
#include "opengl/gl_renderer.hpp"
#include "scenes/renderers/renderer_behind.hpp"

namespace farfield::scenes {
namespace {

/// A member of what draws, so that it comes first and goes last.
struct HasContext {
    std::shared_ptr<opengl::HeadlessContext> context = shared();

    static std::shared_ptr<opengl::HeadlessContext> shared() {
        thread_local std::weak_ptr<opengl::HeadlessContext> known;
        std::shared_ptr<opengl::HeadlessContext> context = known.lock();
        if (!context) known = context = std::make_shared<opengl::HeadlessContext>();
        return context;
    }
};

class HeadlessRenderer : HasContext, public opengl::GlRenderer {
  public:
    explicit HeadlessRenderer(const opengl::GlOptions& options) : GlRenderer(options) {}
    void end_frame() {
        GlRenderer::end_frame();
        glFinish();
    }
};

}  // namespace

std::unique_ptr<AnyRenderer> make_opengl_renderer(const RendererChoice& choice) {
    opengl::GlOptions options;
    options.samples = choice.samples;
    options.culls_back_faces = choice.culls_back_faces;
    return std::make_unique<RendererBehind<HeadlessRenderer>>(options);
}

}  // namespace farfield::scenes
