#include "application.hpp"

#include <algorithm>
#include <stdexcept>
#include <thread>
#include <utility>

#include "choices.hpp"
#include "report/picture.hpp"

namespace viewer {

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

}  // namespace viewer
