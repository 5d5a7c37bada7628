#include "script_player.hpp"

#include <cmath>
#include <stdexcept>
#include <utility>

namespace viewer {
namespace {

/// As in ctrl+S, shift+left.
struct Chord {
    std::string name;
    bool shift = false, control = false;

    explicit Chord(std::string word) {
        for (auto plus = word.find('+'); plus != std::string::npos && plus + 1 < word.size(); plus = word.find('+')) {
            const std::string modifier = word.substr(0, plus);
            if (modifier != "shift" && modifier != "ctrl") throw std::runtime_error("no modifier '" + modifier + "'");
            (modifier == "shift" ? shift : control) = true;
            word.erase(0, plus + 1);
        }
        name = word;
    }
    Key key() const {
        if (name == "space") return Key::space;
        if (name == "escape") return Key::escape;
        if (name == "F1") return Key::f1;
        if (name.size() == 1 && ((name[0] >= 'A' && name[0] <= 'Z') || name[0] == '[' || name[0] == ']')) {
            return key_of(name[0]);
        }
        throw std::runtime_error("no key '" + name + "'; letters are capitals");
    }
    Button button() const {
        if (name == "left") return Button::left;
        if (name == "right") return Button::right;
        if (name == "middle") return Button::middle;
        throw std::runtime_error("no button '" + name + "'");
    }
    Event event(Event::Kind kind) const {
        Event e{.kind = kind};
        e.shift = shift;
        e.control = control;
        return e;
    }
};

double number(const std::string& word) {
    std::size_t end = 0;
    const double value = std::stod(word, &end);
    if (end != word.size() || !std::isfinite(value)) throw std::runtime_error("'" + word + "' is no number");
    return value;
}

void add_click(const Chord& chord, glm::dvec2 from, glm::dvec2 to, std::deque<Event>& events) {
    constexpr int moves = 8;
    const auto add = [&](Event::Kind kind, glm::dvec2 at) {
        Event e = chord.event(kind);
        e.button = chord.button();
        e.at = at;
        events.push_back(e);
    };
    add(Event::Kind::move, from);
    add(Event::Kind::button_down, from);
    for (int i = 1; i <= moves && from != to; ++i) add(Event::Kind::move, from + (to - from) * (double(i) / moves));
    add(Event::Kind::button_up, to);
}

}  // namespace

void ScriptPlayer::step(ScriptHost& host) {
    if (pause_ > 0) {
        --pause_;
        return;
    }
    if (!events_.empty()) {
        host.send(events_.front());
        events_.pop_front();
        return;
    }
    if (waits_ == Wait::settled && !host.is_settled()) return;
    if (waits_ == Wait::played && host.is_playing()) return;
    waits_ = Wait::none;
    if (next_ == lines_.size()) return;
    const ScriptLine& line = lines_[next_++];
    try {
        begin(line, host);
    } catch (const std::exception& error) {
        throw std::runtime_error("line " + std::to_string(line.number) + " of the script, '" + line.text +
                                 "': " + error.what());
    }
}

void ScriptPlayer::begin(const ScriptLine& line, ScriptHost& host) {
    const std::vector<std::string>& w = line.words;
    const auto place = [&](std::size_t i) { return glm::dvec2(number(w[i]), number(w[i + 1])); };
    if (w[0] == "wait") {
        waits_ = Wait::settled;
        pause_ = 2;  // what was asked for just now has not begun
    } else if (w[0] == "key" || w[0] == "hold") {
        const Chord chord(w[1]);
        Event down = chord.event(Event::Kind::key_down), up = chord.event(Event::Kind::key_up);
        down.key = up.key = chord.key();
        host.send(down);
        if (w[0] == "hold") pause_ = int(std::lround(number(w[2]) / frame_seconds));
        events_.push_back(up);
    } else if (w[0] == "drag") {
        add_click(Chord(w[1]), place(2), place(4), events_);
    } else if (w[0] == "click") {
        add_click(Chord("left"), place(1), place(1), events_);
    } else if (w[0] == "wheel") {
        events_.push_back({.kind = Event::Kind::wheel, .at = place(2), .steps = number(w[1])});
    } else if (w[0] == "drop") {
        host.send({.kind = Event::Kind::drop, .file = w[1]});
    } else if (w[0] == "set") {
        host.set(std::span(w).subspan(1));
    } else if (w[0] == "screenshot") {
        host.take_screenshot(w[1]);
    } else if (w[0] == "record") {
        host.begin_recording(w[1]);
    } else if (w[0] == "stop") {
        host.end_recording();
    } else if (w[0] == "play") {
        host.play(w[1]);
        waits_ = Wait::played;
        pause_ = 1;
    } else {
        host.quit();
    }
}

}  // namespace viewer
