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

#include "comparison.hpp"
#include "farfield/camera.hpp"
#include "farfield/image.hpp"
#include "farfield/view.hpp"
#include "report/picture.hpp"
#include "scenes/built_scene.hpp"
#include "stage.hpp"

namespace viewer {

/// What pictures to draw, and of what.
struct Order {
    std::shared_ptr<const Stage> stage{};  ///< outlives what is drawn of it
    BuiltPtr variant{}, exact{};           ///< null: it is not drawn
    farfield::scenes::RendererChoice renderer{}, exact_renderer{};
    farfield::View view{};                   ///< of the variant
    std::optional<farfield::View> frozen{};  ///< what is drawn is chosen for this view, and seen from the other
    std::optional<double> budget_ms{};
    std::vector<farfield::View> like{};  ///< from which it is learned what frames cost
    bool tints_levels = false;
    std::size_t most_cells = 0;  ///< whose outlines are wanted
    std::optional<Difference> difference{};
    farfield::report::Background background{};
    int side = 1;            ///< pixels of the window on the side of one of the picture
    std::size_t number = 0;  ///< of the order, for whoever gave it
};

/// Opaque pictures; empty where they were not asked for.
struct Drawn {
    Order order;
    farfield::Image variant, exact, difference;
    farfield::FrameStats stats{};
    std::uint64_t missing = 0;  ///< cells drawn coarser, of both, for their pages have not come
    double variant_ms = 0, exact_ms = 0, flip = -1, rmse = -1;
    std::vector<farfield::scenes::CellOutline> cells;
    std::string problem;  ///< one line; empty: none
};

class Drawer {
  public:
    /// `wake` is called on that thread whenever something is drawn.
    explicit Drawer(std::function<void()> wake);
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
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::optional<Order> next_;
    std::optional<Drawn> drawn_;
    bool is_drawing_ = false, ends_ = false;
    std::thread thread_;
};

}  // namespace viewer
