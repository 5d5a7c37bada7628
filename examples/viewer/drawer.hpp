// Draws pictures on a thread of its own, so that the window never waits for one. Of several that were asked for the
// last is drawn.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "farfield/image.hpp"
#include "farfield/view.hpp"
#include "order.hpp"
#include "scenes/built_scene.hpp"
#include "shared_picture.hpp"

namespace viewer {

/// Opaque pictures; empty where they were not asked for. OpenGL's lie in textures instead, where the thread can share
/// them and nobody here has to look at their pixels.
struct Drawn {
    Order order;
    farfield::Image variant, exact, difference;
    SharedPicturePtr shared_variant, shared_exact;
    farfield::FrameStats stats{};
    std::uint64_t missing = 0;  ///< cells drawn coarser, of both, for their pages have not come
    double variant_ms = 0, exact_ms = 0, flip = -1, rmse = -1;
    std::vector<farfield::scenes::CellOutline> cells;
    std::string problem;  ///< one line; empty: none

    bool has_variant() const { return shared_variant || !variant.pixels().empty(); }
    bool has_exact() const { return shared_exact || !exact.pixels().empty(); }
};

class Drawer {
  public:
    /// `wake` is called on that thread whenever something is drawn.
    explicit Drawer(std::function<void()> wake, SharesPictures shares = {});
    ~Drawer();
    Drawer(const Drawer&) = delete;
    Drawer& operator=(const Drawer&) = delete;

    void draw(Order order);
    std::optional<Drawn> drawn();
    bool is_busy() const;

  private:
    class Easel;
    void work();
    /// Something newer was asked for.
    bool is_stale() const;

    std::function<void()> wake_;
    SharesPictures shares_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::optional<Order> next_;
    std::optional<Drawn> drawn_;
    bool is_drawing_ = false, ends_ = false;
    std::thread thread_;
};

}  // namespace viewer
