#include "drawer.hpp"

#include <chrono>
#include <exception>
#include <new>
#include <stdexcept>
#include <utility>

#include "farfield/frame/frame_budget.hpp"
#include "farfield/tuning/measure_frame_prices.hpp"

namespace viewer {
namespace {

using farfield::FrameStats;
using farfield::Image;
using farfield::View;
using farfield::scenes::RendererChoice;
using farfield::scenes::SceneViewer;
using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point begin) {
    return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

/// A viewer, made again when something else is to be drawn, or otherwise.
class Kept {
  public:
    SceneViewer& viewer(const BuiltPtr& built, RendererChoice choice) {
        if (viewer_ && built == built_ && choice == choice_) return *viewer_;
        viewer_.reset();  // before the next comes: each may hold a copy of all triangles
        built_ = built;
        choice_ = choice;
        prices.reset();
        frozen.reset();
        try {
            viewer_ = built->viewer(choice);
        } catch (const std::invalid_argument&) {
            // Images are kept by one viewer on one thread.
            if (choice.threads == 1) throw;
            choice.threads = 1;
            viewer_ = built->viewer(choice);
        }
        return *viewer_;
    }
    void forget() {
        viewer_.reset();
        built_.reset();
    }

    std::optional<farfield::FramePrices> prices{};  ///< of its frames
    std::optional<View> frozen{};                   ///< that it has drawn
    bool frozen_is_tinted = false;

  private:
    BuiltPtr built_;  ///< outlives the viewer
    RendererChoice choice_{};
    std::unique_ptr<SceneViewer> viewer_;
};

}  // namespace

class Drawer::Easel {
  public:
    explicit Easel(const Drawer& drawer) : drawer_(drawer) {}

    /// False where it was given up for something newer.
    bool draw(Drawn& out) {
        const Order& order = out.order;
        if (order.stage != stage_) {
            variant_.forget();
            exact_.forget();
            stage_ = order.stage;
        }
        // What has not been asked for is not kept: it may be large.
        if (!order.exact) exact_.forget();
        if (order.variant) {
            SceneViewer& viewer = viewer_of_variant(order);
            if (order.budget_ms && !order.frozen) learn_prices(viewer, order);
            const Image* const image = variant_image(viewer, order, out);
            if (image != nullptr) {
                out.variant = farfield::report::over_background(*image, order.background);
            } else {
                show(viewer, order, out.variant, out.shared_variant);
            }
            if (order.most_cells > 0)
                out.cells = order.frozen ? frozen_cells_ : viewer.cells(order.view, order.most_cells, false);
            out.missing += out.stats.cells_missing;
        }
        if (!order.exact) return true;
        if (order.side == 1 && drawer_.is_stale()) return false;
        SceneViewer& viewer = exact_.viewer(order.exact, order.exact_renderer);
        View view = order.view;
        view.tolerance_px = 0;
        view.wanted = farfield::WantedError::any();
        const auto begin = Clock::now();
        const FrameStats stats = viewer.frame(view);
        out.exact_ms = ms_since(begin);
        if (!order.variant) out.stats = stats;
        out.missing += stats.cells_missing;
        show(viewer, order, out.exact, out.shared_exact);
        if (!order.difference || !order.variant) return true;
        if (order.side == 1 && drawer_.is_stale()) return false;
        Compared compared = compare(tinted_ ? untinted_ : out.variant, out.exact, *order.difference);
        out.difference = std::move(compared.picture);
        out.flip = compared.flip;
        out.rmse = compared.rmse;
        return true;
    }

  private:
    /// A viewer's last frame.
    void show(SceneViewer& viewer, const Order& order, Image& image, SharedPicturePtr& shared) const {
        const unsigned texture = drawer_.shares_.keep && !order.difference ? viewer.texture() : 0;
        const glm::ivec2 size(order.view.width, order.view.height);
        if (texture != 0) shared = drawer_.shares_.keep(texture, size, order.background);
        if (!shared) image = farfield::report::over_background(viewer.image(), order.background);
    }

    SceneViewer& viewer_of_variant(const Order& order) {
        RendererChoice choice = order.renderer;
        if (order.budget_ms || order.frozen) choice.threads = 1;
        choice.looks_on = order.frozen.has_value();
        return variant_.viewer(order.variant, choice);
    }

    void learn_prices(SceneViewer& viewer, const Order& order) {
        if (variant_.prices) return;
        const farfield::FramePriceOptions options{.longest = 2e6 * *order.budget_ms};
        variant_.prices = farfield::fitted_frame_prices(viewer.measured(order.like, options), options);
    }

    /// Null: it is the viewer's last frame.
    const Image* variant_image(SceneViewer& viewer, const Order& order, Drawn& out) {
        const auto begin = Clock::now();
        tinted_ = false;
        if (order.frozen) return image_from_outside(viewer, order, out);
        if (order.budget_ms && variant_.prices) {
            out.stats = viewer.frame_within(
                {.prices = *variant_.prices, .most = 1e6 * *order.budget_ms, .refines_still_views = true}, order.view);
        } else {
            out.stats = viewer.frame(order.view);
        }
        out.variant_ms = ms_since(begin);
        if (!order.tints_levels) return nullptr;
        tinted_ = true;
        if (order.difference) untinted_ = farfield::report::over_background(viewer.image(), order.background);
        image_ = viewer.how_drawn(order.view);
        return &image_;
    }

    /// What the frozen view is drawn by is chosen once, and then only looked at.
    const Image* image_from_outside(SceneViewer& viewer, const Order& order, Drawn& out) {
        const bool is_there = variant_.frozen && is_same(*variant_.frozen, *order.frozen) &&
                              variant_.frozen_is_tinted == order.tints_levels && most_frozen_cells_ == order.most_cells;
        if (!is_there) {
            frozen_stats_ = viewer.frame(*order.frozen);
            // What was hidden is known until the next frame.
            most_frozen_cells_ = order.most_cells;
            frozen_cells_.clear();
            if (order.most_cells > 0) frozen_cells_ = viewer.cells(*order.frozen, order.most_cells, true);
            if (order.tints_levels) viewer.how_drawn(*order.frozen);
            variant_.frozen = order.frozen;
            variant_.frozen_is_tinted = order.tints_levels;
        }
        const auto begin = Clock::now();
        const Image* const image = viewer.from_outside(&order.view);
        out.variant_ms = ms_since(begin);
        out.stats = frozen_stats_;
        if (image == nullptr) throw std::invalid_argument("this renderer cannot be looked at from outside");
        return image;
    }

    const Drawer& drawer_;
    std::shared_ptr<const Stage> stage_;
    Kept variant_, exact_;
    FrameStats frozen_stats_;
    std::vector<farfield::scenes::CellOutline> frozen_cells_;
    std::size_t most_frozen_cells_ = 0;
    Image image_;
    bool tinted_ = false;
    Image untinted_;  ///< what exact is compared with where levels are tinted
};

Drawer::Drawer(std::function<void()> wake, SharesPictures shares)
    : wake_(std::move(wake)), shares_(std::move(shares)), thread_([this] {
          if (shares_.begin) shares_.begin();
          work();
          if (shares_.end) shares_.end();
      }) {}

Drawer::~Drawer() {
    {
        const std::lock_guard lock(mutex_);
        ends_ = true;
        next_.reset();
    }
    changed_.notify_all();
    thread_.join();
}

void Drawer::draw(Order order) {
    {
        const std::lock_guard lock(mutex_);
        next_ = std::move(order);
    }
    changed_.notify_all();
}

std::optional<Drawn> Drawer::drawn() {
    const std::lock_guard lock(mutex_);
    return std::exchange(drawn_, std::nullopt);
}

bool Drawer::is_busy() const {
    const std::lock_guard lock(mutex_);
    return is_drawing_ || next_ || drawn_;
}

bool Drawer::is_stale() const {
    const std::lock_guard lock(mutex_);
    return ends_ || next_;
}

void Drawer::work() {
    Easel easel(*this);
    for (;;) {
        Drawn drawn;
        {
            std::unique_lock lock(mutex_);
            is_drawing_ = false;
            changed_.wait(lock, [this] { return ends_ || next_; });
            if (ends_) return;
            drawn.order = *std::exchange(next_, std::nullopt);
            is_drawing_ = true;
        }
        bool is_done = true;
        try {
            is_done = easel.draw(drawn);
        } catch (const std::bad_alloc&) {
            drawn.problem = "there is not enough memory for this picture";
        } catch (const std::exception& error) {
            drawn.problem = error.what();
        }
        if (!is_done) continue;
        {
            const std::lock_guard lock(mutex_);
            drawn_ = std::move(drawn);
        }
        wake_();
    }
}

}  // namespace viewer
