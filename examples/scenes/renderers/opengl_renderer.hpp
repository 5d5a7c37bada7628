// OpenGL without a window as an AnyRenderer, where the program was built with it (FARFIELD_HAS_OPENGL).
#pragma once

#include <memory>

#include "scenes/renderers/any_renderer.hpp"

namespace farfield::scenes {

/// Renderers of one thread share a context, which goes with the last of them. A frame ends when it is drawn and not
/// when it is asked for, so that times are times. Throws std::runtime_error, one line, where there is no OpenGL 4.5.
std::unique_ptr<AnyRenderer> make_opengl_renderer(const RendererChoice& choice);

}  // namespace farfield::scenes
