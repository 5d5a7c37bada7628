// What keys and the mouse do. Whatever needs more than the camera and the look is asked for by a request.
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>

#include "input.hpp"
#include "look.hpp"
#include "navigator.hpp"

namespace viewer {

struct Request {
    enum class Kind { pick, screenshot, record, play, open, quit };
    Kind kind;
    glm::dvec2 at{0.0};
    std::string file{};
};

class Controls {
  public:
    Controls(Look& look, Navigator& navigator) : look_(look), navigator_(navigator) {}

    /// How deep lies what is seen there; 0: nothing is, or nobody knows.
    std::function<double(glm::dvec2)> depth_at;

    void set_size(glm::dvec2 size) { size_ = size; }

    std::optional<Request> handle(const Event& event) {
        switch (event.kind) {
            case Event::Kind::key_down:
                return key_down(event);
            case Event::Kind::key_up:
                set_held(event.key, false);
                break;
            case Event::Kind::button_down:
                begin_drag(event);
                break;
            case Event::Kind::button_up:
                return end_drag(event);
            case Event::Kind::move:
                drag(event);
                break;
            case Event::Kind::wheel:
                navigator_.zoom(event.steps, in_heights(event.at), depth_at ? depth_at(event.at) : 0);
                break;
            case Event::Kind::drop:
                return Request{Request::Kind::open, {}, event.file};
        }
        return std::nullopt;
    }

    /// Time goes on: keys that are held walk.
    void advance(double seconds) {
        glm::dvec3 way(0);
        for (std::size_t i = 0; i < walking.size(); ++i) {
            if (held_[i]) way += walking[i].way;
        }
        const double length = glm::length(way);
        if (length > 0) navigator_.walk(way / length * (seconds * (runs_ ? 3.0 : 0.75)));
    }

    /// The camera is in somebody's hands.
    bool is_moving() const { return (drag_ && drag_->has_moved) || is_walking(); }
    /// Which divider lies there, 0 or 1; below 0: none.
    int divider_at(glm::dvec2 at) const {
        constexpr double reach = 6;
        if (!look_.compares || look_.frozen) return -1;
        const double to_first = std::abs(at.x - look_.exact_until * size_.x),
                     to_second = std::abs(at.x - look_.variant_until * size_.x);
        if (std::min(to_first, to_second) > reach) return -1;
        return to_first < to_second ? 0 : 1;
    }
    /// As Navigator::zoom has it.
    glm::dvec2 in_heights(glm::dvec2 at) const {
        return glm::dvec2(at.x - 0.5 * size_.x, 0.5 * size_.y - at.y) / size_.y;
    }

  private:
    struct Walking {
        char key;
        glm::dvec3 way;
    };
    static constexpr std::array<Walking, 6> walking{Walking{'W', {0, 0, 1}},  Walking{'S', {0, 0, -1}},
                                                    Walking{'A', {-1, 0, 0}}, Walking{'D', {1, 0, 0}},
                                                    Walking{'E', {0, 1, 0}},  Walking{'Q', {0, -1, 0}}};

    struct Drag {
        Button button;
        glm::dvec2 begin, last;
        int divider;
        bool pans, has_moved = false;
    };

    void set_held(Key key, bool is_held) {
        for (std::size_t i = 0; i < walking.size(); ++i) {
            if (key == key_of(walking[i].key)) held_[i] = is_held;
        }
    }
    bool is_walking() const {
        for (const bool held : held_) {
            if (held) return true;
        }
        return false;
    }

    std::optional<Request> key_down(const Event& e) {
        runs_ = e.shift;
        if (e.control) {
            if (e.key == key_of('S')) return Request{Request::Kind::screenshot};
            return std::nullopt;
        }
        set_held(e.key, true);
        switch (int(e.key)) {
            case int(Key::escape):
                return Request{Request::Kind::quit};
            case int(Key::f1):
                look_.shows_help = !look_.shows_help;
                break;
            case int(Key::space):
                look_.shows_exact = !look_.shows_exact;
                break;
            case int(Key::left_bracket):
                look_.tolerance_px = std::max(look_.tolerance_px / 2, 0.125f);
                break;
            case int(Key::right_bracket):
                look_.tolerance_px = std::min(look_.tolerance_px * 2, 64.0f);
                break;
            case 'F':
                navigator_.frame();
                break;
            case 'R':
                navigator_.reset();
                break;
            case 'H':
                look_.hides_panels = !look_.hides_panels;
                break;
            case 'G':
                look_.flies = !look_.flies;
                break;
            case 'C':
                look_.compares = !look_.compares;
                break;
            case 'L':
                look_.tints_levels = !look_.tints_levels;
                break;
            case 'O':
                look_.outlines_cells = !look_.outlines_cells;
                break;
            case 'Z':
                if (look_.frozen) {
                    look_.frozen.reset();
                } else {
                    look_.frozen = navigator_.camera();
                }
                break;
            case 'P':
                return Request{Request::Kind::record};
            case 'K':
                return Request{Request::Kind::play};
            default:
                break;
        }
        return std::nullopt;
    }

    void begin_drag(const Event& e) {
        if (drag_) return;
        const int divider = e.button == Button::left && !e.shift ? divider_at(e.at) : -1;
        drag_ = Drag{e.button, e.at, e.at, divider, e.button != Button::left || e.shift};
    }
    void drag(const Event& e) {
        if (!drag_) return;
        constexpr double of_a_click = 4;
        if (!drag_->has_moved && glm::length(e.at - drag_->begin) < of_a_click) return;
        drag_->has_moved = true;
        const glm::dvec2 pixels = e.at - drag_->last, by = glm::dvec2(pixels.x, -pixels.y) / size_.y;
        drag_->last = e.at;
        if (drag_->divider >= 0) {
            look_.move_divider(drag_->divider, e.at.x / size_.x);
        } else if (drag_->pans) {
            navigator_.pan(glm::dvec2(by.x, -by.y));
        } else if (look_.flies) {
            navigator_.look(by);
        } else {
            navigator_.orbit(by);
        }
    }
    std::optional<Request> end_drag(const Event& e) {
        if (!drag_ || drag_->button != e.button) return std::nullopt;
        const bool is_click = !drag_->has_moved && drag_->button == Button::left && drag_->divider < 0;
        drag_.reset();
        if (is_click) return Request{Request::Kind::pick, e.at};
        return std::nullopt;
    }

    Look& look_;
    Navigator& navigator_;
    glm::dvec2 size_{1.0};
    std::array<bool, walking.size()> held_{};
    bool runs_ = false;
    std::optional<Drag> drag_;
};

}  // namespace viewer
