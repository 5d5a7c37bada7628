// A second context that shares the window's textures, for the thread that draws: what OpenGL draws there is shown
// without being read back.
#pragma once

#include <glm/vec2.hpp>
#include <memory>
#include <vector>

#include "report/picture.hpp"
#include "shared_picture.hpp"

namespace viewer {

class Window;

/// It is made and goes on the window's thread, after the thread that draws has ended; the window outlives it.
class SharedPictures {
  public:
    /// Where the driver gives no second context nothing is shared.
    explicit SharedPictures(Window& window);
    ~SharedPictures();
    SharedPictures(const SharedPictures&) = delete;
    SharedPictures& operator=(const SharedPictures&) = delete;

    /// For the thread that draws.
    SharesPictures hooks();

  private:
    struct Kept;
    struct Painter;

    void begin();
    void end();
    SharedPicturePtr keep(unsigned texture, glm::ivec2 size, const farfield::report::Background& background);

    void* context_ = nullptr;  ///< GLFW's, of a window that is never shown
    bool is_current_ = false;  ///< on the thread that draws
    std::unique_ptr<Painter> painter_;
    std::vector<std::shared_ptr<Kept>> kept_;  ///< those that nobody else holds are drawn into again
};

}  // namespace viewer
