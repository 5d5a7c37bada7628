#include <stdexcept>

#include "farfield/renderer/hierarchical_z_renderer.hpp"
#include "farfield/renderer/painter_renderer.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "scenes/renderers/coverage_renderers.hpp"
#include "scenes/renderers/onlooker.hpp"
#include "scenes/renderers/opengl_renderer.hpp"

namespace farfield::scenes {
namespace {

std::unique_ptr<AnyRenderer> coverage_renderer([[maybe_unused]] const RendererChoice& choice,
                                               [[maybe_unused]] bool is_strict) {
#ifdef FARFIELD_FIRST_LOOK
    throw std::invalid_argument("coverage masks are not in this program: build it with -DFARFIELD_FIRST_LOOK=OFF");
#else
    if (choice.masks_by_table) return make_table_coverage_renderer(choice);
    return is_strict ? make_strict_coverage_renderer(choice) : make_lazy_coverage_renderer(choice);
#endif
}

std::unique_ptr<AnyRenderer> opengl_renderer([[maybe_unused]] const RendererChoice& choice) {
#ifdef FARFIELD_HAS_OPENGL
    return make_opengl_renderer(choice);
#else
    throw std::invalid_argument(
        "OpenGL is not in this program: libepoxy was not found when it was configured (Debian and Ubuntu: "
        "libepoxy-dev libegl-dev libegl-mesa0 libgl1-mesa-dri)");
#endif
}

}  // namespace

std::unique_ptr<AnyRenderer> make_renderer(const RendererChoice& choice, bool is_strict) {
    if (choice.looks_on) {
        RendererChoice alone = choice;
        alone.looks_on = false;
        return std::make_unique<Onlooker>(make_renderer(alone, is_strict));
    }
    ZBufferOptions z_buffer;
    z_buffer.samples = choice.samples;
    z_buffer.culls_back_faces = choice.culls_back_faces;
    PainterOptions painter;
    painter.samples = choice.samples;
    painter.culls_back_faces = choice.culls_back_faces;
    switch (choice.kind) {
        case RendererKind::hierarchical_z:
            return std::make_unique<RendererBehind<HierarchicalZRenderer>>(z_buffer);
        case RendererKind::painter:
            return std::make_unique<RendererBehind<PainterRenderer>>(painter);
        case RendererKind::coverage:
            return coverage_renderer(choice, is_strict);
        case RendererKind::opengl:
            return opengl_renderer(choice);
        case RendererKind::z_buffer:
            break;
    }
    return std::make_unique<RendererBehind<ZBufferRenderer>>(z_buffer);
}

}  // namespace farfield::scenes
