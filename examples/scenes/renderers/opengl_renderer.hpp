// OpenGL without a window as an AnyRenderer, where the program was built with it (FARFIELD_HAS_OPENGL).
#pragma once

#include <memory>

#include "scenes/renderers/any_renderer.hpp"

namespace farfield::scenes {

/// The context that all OpenGL renderers of one thread share, current; it goes with the last that holds it.
std::shared_ptr<void> opengl_context();

/// Says that whoever calls has made a context current on this thread, where all renderers made on it from now on draw;
/// it must stay current while any of them lives.
void adopt_opengl_context();

/// Renderers of one thread share a context, which goes with the last of them. A frame ends when it is drawn and not
/// when it is asked for, so that times are times. Throws std::runtime_error, one line, where there is no OpenGL 4.5.
std::unique_ptr<AnyRenderer> make_opengl_renderer(const RendererChoice& choice);

}  // namespace farfield::scenes
