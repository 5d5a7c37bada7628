#include "scenes/renderers/opengl_renderer.hpp"

#include <memory>

#include "opengl/context.hpp"
#include "opengl/culled_in_software.hpp"
#include "opengl/gl_renderer.hpp"
#include "scenes/renderers/renderer_behind.hpp"

namespace farfield::scenes {
namespace {

thread_local bool has_context_of_others = false;

/// A member of what draws, so that it comes first and goes last.
struct HasContext {
    std::shared_ptr<void> context = opengl_context();
};

class HeadlessRenderer : HasContext, public opengl::GlRenderer {
  public:
    explicit HeadlessRenderer(const opengl::GlOptions& options) : GlRenderer(options) {}
    void end_frame() {
        GlRenderer::end_frame();
        glFinish();
    }
    std::uint64_t sent_bytes() const { return stats().uploaded_bytes; }
};

struct HasShading {
    HeadlessRenderer shading;
};

class CulledRenderer : HasShading, public opengl::CulledInSoftware<HeadlessRenderer> {
  public:
    explicit CulledRenderer(const opengl::GlOptions& options)
        : HasShading{HeadlessRenderer(options)},
          CulledInSoftware(shading,
                           ZBufferOptions{.samples = options.samples, .culls_back_faces = options.culls_back_faces}) {}
    std::uint64_t sent_bytes() const { return shading.sent_bytes(); }
};

}  // namespace

std::shared_ptr<void> opengl_context() {
    if (has_context_of_others) return std::make_shared<char>('\0');
    thread_local std::weak_ptr<opengl::HeadlessContext> known;
    std::shared_ptr<opengl::HeadlessContext> context = known.lock();
    if (!context) known = context = std::make_shared<opengl::HeadlessContext>();
    return context;
}

void adopt_opengl_context() {
    has_context_of_others = true;
}

std::unique_ptr<AnyRenderer> make_opengl_renderer(const RendererChoice& choice) {
    opengl::GlOptions options;
    options.samples = choice.samples;
    options.culls_back_faces = choice.culls_back_faces;
    options.shapes_stand_ins = !choice.shapes_here;
    if (choice.draws_hidden) return std::make_unique<RendererBehind<HeadlessRenderer>>(options);
    return std::make_unique<RendererBehind<CulledRenderer>>(options);
}

}  // namespace farfield::scenes
