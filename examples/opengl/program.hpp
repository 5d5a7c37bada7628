// Programs from the text of their shaders.
#pragma once

#include <string>

#include "opengl/objects.hpp"

namespace farfield::opengl {

/// Throws std::runtime_error with the driver's words where it does not compile.
Program make_program(const std::string& vertex_text, const std::string& fragment_text);
Program make_compute_program(const std::string& text);

}  // namespace farfield::opengl
