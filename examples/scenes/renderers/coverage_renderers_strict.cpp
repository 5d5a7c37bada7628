#include "scenes/renderers/coverage_renderers.hpp"

namespace farfield::scenes {

std::unique_ptr<AnyRenderer> make_strict_coverage_renderer(const RendererChoice& choice) {
    return make_coverage_renderer<StrictCoverage>(choice);
}

}  // namespace farfield::scenes
