// The programs that draw, compiled when they are first wanted.
#pragma once

#include <array>

#include "opengl/objects.hpp"

namespace farfield::opengl {

enum class Shader : unsigned char {
    triangles,
    far_field,
    small_triangles,
    image_quad,
    copied_depth,
    composite,
    bounds
};
inline constexpr std::size_t shaders = 7;

/// What a program does beyond the common: bits. Each is a macro of that name in the sources.
enum ShaderFeature : unsigned {
    CLIPS = 1,          ///< by depths in the view's row
    LIT = 2,            ///< triangles get light
    TRANSLUCENT = 4,    ///< triangles may have holes, by alpha
    SLICED = 8,         ///< only a range of depths is drawn
    KEEPS_DEPTHS = 16,  ///< of images
    LEAVES_SMALL = 32,  ///< triangles smaller than two samples are deposited instead
    TENSORS = 64,       ///< stand-ins are opacity tensors, and made splats of
    CUBES = 128         ///< they are color cubes, as small as splats
};
inline constexpr unsigned shader_features = 256;

/// A context's own.
class Programs {
  public:
    /// Throws std::runtime_error with the driver's words where it does not compile.
    GLuint get(Shader shader, unsigned features = 0);

  private:
    std::array<std::array<Program, shader_features>, shaders> programs_;
};

}  // namespace farfield::opengl
