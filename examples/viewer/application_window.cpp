// What the application shows: pictures, lines over them, widgets.
#include <imgui.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "application.hpp"
#include "outlines.hpp"

namespace viewer {
namespace {

ImVec2 im(glm::dvec2 v) {
    return {float(v.x), float(v.y)};
}

}  // namespace

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
        const farfield::Rgba8 tint = tint_of(cell);
        draw(IM_COL32(tint.r, tint.g, tint.b, tint.a), 1);
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
