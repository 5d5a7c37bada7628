// A picture that lies on the GPU where the window can show it, and the thread that draws it there.
#pragma once

#include <functional>
#include <glm/vec2.hpp>
#include <memory>

#include "report/picture.hpp"

namespace viewer {

/// A texture of the window's, opaque, rows from the top. It is not drawn into again while anybody holds it.
struct SharedPicture {
    unsigned name = 0;
    glm::ivec2 size{0};
};
using SharedPicturePtr = std::shared_ptr<const SharedPicture>;

/// What a thread that draws needs so that OpenGL's pictures need not be read back; all empty: they are.
struct SharesPictures {
    std::function<void()> begin{}, end{};  ///< on that thread: makes a context current there, and lets go of it
    /// Copies a premultiplied picture of that context over a background. Null: there is no such context.
    std::function<SharedPicturePtr(unsigned texture, glm::ivec2 size, const farfield::report::Background&)> keep{};
};

}  // namespace viewer
