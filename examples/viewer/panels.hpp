// The widgets: what can be chosen, what was drawn, and what was picked.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "drawer.hpp"
#include "history.hpp"
#include "look.hpp"
#include "scenes/looked_at.hpp"
#include "stage.hpp"

namespace viewer {

/// What they show.
struct Shown {
    const Stage* stage = nullptr;  ///< null: nothing is open yet
    BuiltPtr variant;              ///< as far as it is built
    std::string task;              ///< empty: nothing is being built
    double part = -1;
    const Drawn* drawn = nullptr;
    const History* frame_ms = nullptr;
    const History* errors = nullptr;
    const std::optional<farfield::scenes::PickedInScene>* picked = nullptr;
    std::string message;  ///< what went wrong last
    bool is_recording = false, is_playing = false;
    glm::dvec2 size{1.0};
};

/// What was clicked that is more than a choice.
struct Clicked {
    std::optional<std::string> open;
    bool frame = false, reset = false, screenshot = false, record = false, play = false;
};

Clicked show_panels(Look& look, const Shown& shown);
/// A line at the bottom, panels or not: what is being built, or what went wrong.
void show_status(const Shown& shown);
void show_help(Look& look);

}  // namespace viewer
