// What pictures the application asks for, and what becomes of them.
#include <chrono>
#include <exception>
#include <future>
#include <utility>

#include "application.hpp"

namespace viewer {

using farfield::View;
using farfield::scenes::RendererChoice;
using farfield::scenes::RendererKind;

namespace {
constexpr std::size_t most_cells = 1500;
}  // namespace

View Application::view(glm::ivec2 pixels) const {
    View v;
    v.camera = navigator_.camera();
    v.width = pixels.x;
    v.height = pixels.y;
    v.tolerance_px = look_.tolerance_px;
    v.distance = stage_ ? stage_->variants[look_.variant].distance : farfield::DistanceMeasure::nearest_point;
    if (look_.wanted != Wanted::any) v.wanted = {.samples = look_.samples};
    if (look_.wanted == Wanted::value) v.wanted.rmse = double(look_.wanted_rmse);
    return v;
}

std::optional<Order> Application::wanted_order() const {
    if (!stage_) return std::nullopt;
    Order o;
    o.stage = stage_;
    o.side = is_moving() ? resolution_.moving() : 1;
    const glm::ivec2 pixels = glm::max(window_.pixels() / o.side, glm::ivec2(1));
    o.view = view(pixels);
    o.background = stage_->background;
    const bool only_exact = look_.shows_exact && !look_.compares && !look_.frozen;
    const bool needs_exact = only_exact || look_.compares || (look_.measures_error && o.side == 1);
    if (!only_exact) o.variant = built(look_.frozen && look_.shows_exact ? 0 : look_.variant);
    if (needs_exact && !look_.frozen) o.exact = built(0);
    if (!o.variant && !o.exact) return std::nullopt;
    const auto renderer_for = [&](std::size_t variant) {
        RendererChoice r{.kind = look_.renderer,
                         .samples = look_.samples,
                         .culls_back_faces = stage_->culls_back_faces,
                         .threads = unsigned(look_.threads)};
        if (!stage_->variants[variant].obstacle(r.kind).empty()) r.kind = RendererKind::z_buffer;
        if (r.kind == RendererKind::coverage) r.samples = r.samples > 1 ? 64 : 1;
        return r;
    };
    o.renderer = renderer_for(look_.variant);
    o.exact_renderer = renderer_for(0);
    if (look_.has_budget && look_.variant != 0 && !stage_->is_paged) {
        o.budget_ms = double(look_.budget_ms);
        o.like = views_like(o.view);
    }
    if (look_.frozen) {
        o.frozen = o.view;
        o.frozen->camera = *look_.frozen;
        // From outside it is as large as the window, whatever the size that moves.
        o.frozen->width = window_.pixels().x;
        o.frozen->height = window_.pixels().y;
    }
    o.tints_levels = look_.tints_levels;
    o.most_cells = look_.outlines_cells ? most_cells : 0;
    if (o.exact && o.variant) o.difference = look_.difference;
    return o;
}

/// From nearer and from farther away.
std::vector<View> Application::views_like(const View& view) const {
    std::vector<View> views;
    Navigator navigator = navigator_;
    navigator.zoom(6, {0, 0});
    for (int i = 0; i < 8; ++i) {
        views.push_back(view);
        views.back().camera = navigator.camera();
        navigator.zoom(-2, {0, 0});
        navigator.orbit({0.2, 0});
    }
    return views;
}

void Application::order() {
    auto wanted = wanted_order();
    if (!wanted) return;
    const bool is_new = !last_order_ || !is_same(*wanted, *last_order_);
    if (!is_new && !(is_refining_ && !drawer_.is_busy())) return;
    // What moves is drawn picture by picture: of the cameras meanwhile none is missed.
    if (is_new && wanted->side > 1 && last_order_ && last_order_->side > 1 && drawer_.is_busy()) return;
    wanted->number = ++orders_;
    last_order_ = wanted;
    if (is_new) unchanged_ = 0;
    is_refining_ = false;
    drawer_.draw(std::move(*wanted));
}

void Application::take_drawn() {
    if (picking_.valid() && picking_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
        try {
            picked_ = picking_.get();
        } catch (const std::exception& error) {
            message_ = error.what();
        }
    }
    auto drawn = drawer_.drawn();
    if (!drawn) return;
    if (!drawn->problem.empty()) {
        message_ = drawn->problem;
    } else {
        message_.clear();
        notice_.clear();
    }
    if (drawn->order.stage != stage_) return;
    variant_.show(drawn->variant, drawn->shared_variant);
    exact_.show(drawn->exact, drawn->shared_exact);
    difference_.show(drawn->difference, nullptr);
    const bool has_variant = drawn->order.variant != nullptr;
    frame_ms_.add(float(has_variant ? drawn->variant_ms : drawn->exact_ms));
    if (drawn->flip >= 0) {
        errors_.add(float(drawn->flip));
    } else if (drawn->rmse >= 0) {
        errors_.add(float(drawn->rmse));
    }
    resolution_.took(drawn->order.side, drawn->variant_ms + drawn->exact_ms);
    if (drawn->order.number == orders_) is_refining_ = drawn->problem.empty() && gets_better(*drawn);
    drawn_ = std::move(drawn);
}

/// Whether the same again may be better: within a budget until nothing changes, and while pages come.
bool Application::gets_better(const Drawn& drawn) {
    if (drawn.order.side > 1 || drawn.order.frozen) return false;
    const bool is_as_before = drawn_ && is_same(drawn.order, drawn_->order) && drawn.missing == drawn_->missing &&
                              drawn.stats.approximations == drawn_->stats.approximations &&
                              drawn.stats.primitives == drawn_->stats.primitives &&
                              drawn.stats.cells_visited == drawn_->stats.cells_visited;
    unchanged_ = is_as_before ? unchanged_ + 1 : 0;
    // A cache that is too small never has all of them.
    constexpr int patience = 100;
    if (drawn.missing > 0) return unchanged_ < patience;
    return drawn.order.budget_ms && !is_as_before;
}

void Application::pick(glm::dvec2 at) {
    if (!stage_ || picking_.valid()) return;
    const bool in_exact = look_.shows_exact || (look_.compares && at.x < look_.exact_until * window_.size().x);
    const BuiltPtr of = built(in_exact && built(0) ? 0 : look_.variant);
    if (!of) return;
    const View seen = view(window_.pixels());
    const glm::dvec2 pixel = at * glm::dvec2(window_.pixels()) / window_.size();
    // Pages may have to be waited for.
    picking_ = std::async(std::launch::async, [of, seen, pixel] {
        auto picked = of->pick(seen, pixel);
        Window::wake();
        return picked;
    });
}

}  // namespace viewer
