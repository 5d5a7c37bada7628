#include "application.hpp"

#include <imgui.h>

#include <algorithm>
#include <stdexcept>
#include <thread>
#include <utility>

#include "choices.hpp"
#include "outlines.hpp"
#include "report/picture.hpp"
#include "scenes/how_drawn.hpp"

namespace viewer {
namespace {

using farfield::View;
using farfield::scenes::RendererChoice;
using farfield::scenes::RendererKind;

constexpr std::size_t most_cells = 1500;

bool is_same(const farfield::Camera& a, const farfield::Camera& b) {
    return a.eye == b.eye && a.right == b.right && a.up == b.up && a.forward == b.forward &&
           a.half_height == b.half_height;
}
bool is_same(const View& a, const View& b) {
    return is_same(a.camera, b.camera) && a.width == b.width && a.height == b.height &&
           a.tolerance_px == b.tolerance_px && a.distance == b.distance && a.wanted == b.wanted;
}
bool is_same(const RendererChoice& a, const RendererChoice& b) {
    return a.kind == b.kind && a.samples == b.samples && a.threads == b.threads;
}
bool is_same(const Order& a, const Order& b) {
    const bool both_frozen = a.frozen && b.frozen;
    return a.stage == b.stage && a.variant == b.variant && a.exact == b.exact && is_same(a.renderer, b.renderer) &&
           is_same(a.exact_renderer, b.exact_renderer) && is_same(a.view, b.view) &&
           a.frozen.has_value() == b.frozen.has_value() && (!both_frozen || is_same(*a.frozen, *b.frozen)) &&
           a.budget_ms == b.budget_ms && a.tints_levels == b.tints_levels && a.most_cells == b.most_cells &&
           a.difference == b.difference && a.side == b.side;
}

ImVec2 im(glm::dvec2 v) {
    return {float(v.x), float(v.y)};
}

}  // namespace

Application::Application(const Options& options) : options_(options), window_(options.size, "farfield viewer") {
    look_.threads = int(std::max(1u, std::thread::hardware_concurrency()));
    if (options.script) script_.emplace(read_script(*options.script));
    if (options.path) {
        const auto path = farfield::scenes::read_camera_path(*options.path);
        recorder_.play(path);
    }
    controls_.depth_at = [this](glm::dvec2 at) {
        const BuiltPtr built = this->built(look_.variant);
        if (!built || stage_->is_paged) return 0.0;
        const glm::dvec2 pixel = at * glm::dvec2(window_.pixels()) / window_.size();
        const auto there = built->pick(view(window_.pixels()), pixel);
        return there ? there->depth : 0.0;
    };
    builder_.open(options.scene, options.cache_mib);
}

void Application::run() {
    auto last = Clock::now();
    while (!window_.should_close() && !is_over_) {
        const bool is_quick = script_ || is_moving() || controls_.is_moving() || recorder_.is_recording();
        window_.wait(is_quick ? 1.0 / 60 : 0.5);
        const auto now = Clock::now();
        const double seconds =
            script_ ? ScriptPlayer::frame_seconds : std::min(std::chrono::duration<double>(now - last).count(), 0.1);
        last = now;
        take_news();
        window_.begin_frame();
        controls_.set_size(window_.size());
        for (const Event& event : window_.events()) send(event);
        if (script_) script_->step(*this);
        advance(seconds);
        build_what_is_missing();
        order();
        take_drawn();
        paint();
        window_.end_frame();
        if (screenshot_) {
            farfield::report::write_png(window_.read_back(), *screenshot_);
            notice_ = "written: " + screenshot_->string();
            screenshot_.reset();
        }
        window_.show();
    }
    if (!window_.gl_errors().empty()) throw std::runtime_error("OpenGL: " + window_.gl_errors().front());
}

bool Application::is_settled() const {
    if (builder_.is_busy() || drawer_.is_busy() || is_moving() || is_refining_ || picking_.valid()) return false;
    if (!stage_) return !message_.empty();
    const auto wanted = wanted_order();
    if (!wanted) return failed_[look_.variant];
    return last_order_ && is_same(*wanted, *last_order_) && drawn_ && drawn_->order.number == orders_;
}

void Application::send(const Event& event) {
    const auto request = controls_.handle(event);
    if (!request) return;
    switch (request->kind) {
        case Request::Kind::pick:
            pick(request->at);
            break;
        case Request::Kind::screenshot:
            screenshot_ = new_file("", ".png");
            break;
        case Request::Kind::record:
            record_or_stop();
            break;
        case Request::Kind::play:
            play_or_stop();
            break;
        case Request::Kind::open:
            message_.clear();
            builder_.open(request->file, options_.cache_mib);
            being_built_.reset();
            break;
        case Request::Kind::quit:
            is_over_ = true;
            break;
    }
}

void Application::choose(std::span<const std::string> words) {
    viewer::choose(look_, stage_.get(), words);
}

// ---- scenes and hierarchies

void Application::take_news() {
    const auto news = builder_.news();
    if (!news) {
        if (!builder_.is_busy()) being_built_.reset();
        return;
    }
    if (const auto* opened = std::get_if<Opened>(&*news)) {
        show(opened->stage);
    } else if (const auto* built = std::get_if<Built>(&*news)) {
        if (built->stage == stage_) built_[built->variant] = built->built;
        being_built_.reset();
    } else if (const auto* failed = std::get_if<Failed>(&*news)) {
        if (!has_opened_) throw std::runtime_error(failed->message);
        message_ = failed->message;
        if (failed->variant && *failed->variant < failed_.size()) {
            failed_[*failed->variant] = true;
            if (*failed->variant == look_.variant) look_.variant = 0;
        }
        being_built_.reset();
    }
}

void Application::show(std::shared_ptr<const Stage> stage) {
    const bool is_first = !has_opened_;
    const std::string variant = stage_ ? stage_->variants[look_.variant].name : "opacity-tensor";
    stage_ = std::move(stage);
    built_.assign(stage_->variants.size(), nullptr);
    failed_.assign(built_.size(), false);
    being_built_.reset();
    look_.variant = std::min<std::size_t>(1, built_.size() - 1);
    look_.frozen.reset();
    for (std::size_t i = 0; i < built_.size(); ++i) {
        if (stage_->variants[i].name == variant) look_.variant = i;
    }
    navigator_ = Navigator(stage_->bounds, stage_->up);
    if (stage_->start) navigator_.start_at(*stage_->start);
    resolution_.forget();
    frame_ms_.clear();
    errors_.clear();
    picked_.reset();
    has_opened_ = true;
    message_.clear();
    window_.set_title(stage_->name + " - farfield viewer");
    if (is_first) {
        for (const auto& words : options_.choices) choose(words);
    }
}

void Application::build_what_is_missing() {
    if (!stage_) return;
    const auto build = [&](std::size_t variant) {
        if (built_[variant] || failed_[variant]) return false;
        if (being_built_ != variant) {
            builder_.build(stage_, variant);
            being_built_ = variant;
        }
        return true;
    };
    // While another scene is being opened nothing is built of this one.
    if (builder_.is_busy() && !being_built_) return;
    if (look_.shows_exact && !look_.compares && build(0)) return;
    if (build(look_.variant)) return;
    if (look_.shows_exact || look_.compares || look_.measures_error) build(0);
}

// ---- the camera

bool Application::is_moving() const {
    return Clock::now() - moved_at_ < std::chrono::milliseconds(150) || (recorder_.is_playing() && stage_);
}

void Application::advance(double seconds) {
    if (!stage_) return;
    controls_.advance(seconds);
    if (const auto camera = recorder_.advance(seconds, navigator_.camera())) navigator_.follow(*camera);
    const farfield::Camera camera = navigator_.camera();
    if (!camera_ || !is_same(*camera_, camera)) moved_at_ = Clock::now();
    camera_ = camera;
}

void Application::begin_recording(const std::filesystem::path& file) {
    recording_ = file;
    recorder_.record();
}

void Application::end_recording() {
    if (recorder_.is_recording()) {
        farfield::scenes::write_camera_path(recorder_.path(), recording_);
        notice_ = "written: " + recording_.string();
    }
    recorder_.stop();
}

void Application::play(const std::filesystem::path& file) {
    recorder_.play(farfield::scenes::read_camera_path(file));
}

void Application::record_or_stop() {
    if (recorder_.is_recording()) {
        end_recording();
    } else {
        begin_recording(new_file("_path", ".json"));
    }
}

void Application::play_or_stop() {
    if (recorder_.is_playing()) {
        recorder_.stop();
    } else if (recorder_.is_recording()) {
        end_recording();
    } else if (!recorder_.path().is_empty()) {
        recorder_.play(recorder_.path());
    } else if (stage_ && stage_->flight) {
        recorder_.play(stage_->flight());
    }
}

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

// ---- pictures

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
    variant_.upload(drawn->variant);
    exact_.upload(drawn->exact);
    difference_.upload(drawn->difference);
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

// ---- the window

void Application::paint() {
    const glm::dvec2 size = window_.size();
    ImDrawList& canvas = *ImGui::GetBackgroundDrawList();
    const auto add = [&](const Texture& texture, double from, double to) {
        if (texture.is_empty() || !(from < to)) return;
        // Whole pixels, so that every pixel of the window shows one of the picture.
        const double left = std::round(from * size.x), right = std::round(to * size.x);
        canvas.AddImage(reinterpret_cast<ImTextureID>(std::uintptr_t(texture.name())), im({left, 0}),
                        im({right, size.y}), im({left / size.x, 0}), im({right / size.x, 1}));
    };
    const bool is_split = look_.compares && !look_.frozen && !exact_.is_empty() && !variant_.is_empty();
    if (is_split) {
        add(exact_, 0, look_.exact_until);
        add(variant_, look_.exact_until, look_.variant_until);
        add(difference_, look_.variant_until, 1);
        for (const int i : {0, 1}) {
            const double x = std::round((i == 0 ? look_.exact_until : look_.variant_until) * size.x);
            const bool is_near = controls_.divider_at(window_.cursor()) == i;
            canvas.AddLine(im({x, 0}), im({x, size.y}), 0xff404040, 4);  // seen on white, too
            canvas.AddLine(im({x, 0}), im({x, size.y}), is_near ? 0xff40c0ff : 0xffffffff, 2);
        }
    } else {
        add(variant_.is_empty() ? exact_ : variant_, 0, 1);
    }
    paint_lines(size);
    const Shown s = shown();
    if (!look_.hides_panels) {
        if (is_split) {
            const std::string& name = stage_->variants[look_.variant].name;
            const double y = size.y - 24;
            canvas.AddText(im({look_.exact_until * size.x - 50, y}), 0xff000000, "exact");
            canvas.AddText(im({look_.exact_until * size.x + 8, y}), 0xff000000, name.c_str());
            canvas.AddText(im({look_.variant_until * size.x + 8, y}), 0xffffffff,
                           difference_names[std::size_t(look_.difference)]);
        }
        do_clicked(show_panels(look_, s));
    }
    if (look_.shows_help) show_help(look_);
    show_status(s);
}

void Application::paint_lines(glm::dvec2 size) {
    if (!drawn_) return;
    ImDrawList& canvas = *ImGui::GetBackgroundDrawList();
    const farfield::Camera& camera = drawn_->order.view.camera;
    std::vector<Line> lines;
    const auto draw = [&](ImU32 color, float width) {
        for (const Line& line : lines) canvas.AddLine(im(line.from), im(line.to), color, width);
        lines.clear();
    };
    for (const auto& cell : drawn_->cells) {
        add_lines(camera, size, cell, lines);
        const farfield::Rgba8 tint =
            cell.is_stand_in ? farfield::scenes::tint_of_level(cell.depth) : farfield::Rgba8{90, 90, 90, 255};
        draw(IM_COL32(tint.r, tint.g, tint.b, cell.is_stand_in ? 200 : 60), 1);
    }
    if (!picked_ || look_.hides_panels) return;
    if (picked_->cell) {
        add_lines(camera, size, *picked_->cell, lines);
        draw(IM_COL32(60, 220, 255, 255), 1.5f);
    }
    add_lines(camera, size, picked_->corners, lines);
    draw(IM_COL32(255, 230, 60, 255), 2);
}

Shown Application::shown() const {
    return {.stage = stage_.get(),
            .variant = built(look_.variant),
            .task = builder_.task(),
            .part = builder_.part(),
            .drawn = drawn_ ? &*drawn_ : nullptr,
            .frame_ms = &frame_ms_,
            .errors = &errors_,
            .picked = &picked_,
            .message = message_.empty() && !look_.hides_panels ? notice_ : message_,
            .is_recording = recorder_.is_recording(),
            .is_playing = recorder_.is_playing(),
            .size = window_.size()};
}

void Application::do_clicked(const Clicked& clicked) {
    if (clicked.open) send({.kind = Event::Kind::drop, .file = *clicked.open});
    if (clicked.frame) navigator_.frame();
    if (clicked.reset) navigator_.reset();
    if (clicked.screenshot) screenshot_ = new_file("", ".png");
    if (clicked.record) record_or_stop();
    if (clicked.play) play_or_stop();
}

std::filesystem::path Application::new_file(const std::string& what, const std::string& extension) const {
    for (int i = 1;; ++i) {
        std::string number = std::to_string(i);
        if (number.size() < 3) number.insert(0, 3 - number.size(), '0');
        const std::filesystem::path file = (stage_ ? stage_->name : "viewer") + what + "_" + number + extension;
        if (!std::filesystem::exists(file)) return file;
    }
}

}  // namespace viewer
