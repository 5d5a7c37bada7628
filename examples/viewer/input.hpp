// What hands do: as a window tells it, or a script.
#pragma once

#include <glm/vec2.hpp>
#include <string>

namespace viewer {

/// Letters, digits and signs are themselves, in capitals; numbers of others are GLFW's.
enum class Key : int {
    none = 0,
    space = ' ',
    left_bracket = '[',
    right_bracket = ']',
    escape = 256,
    f1 = 290,
};
inline constexpr Key key_of(char c) {
    return Key(int(c));
}

enum class Button { left, right, middle };

struct Event {
    enum class Kind { key_down, key_up, button_down, button_up, move, wheel, drop };
    Kind kind = Kind::move;
    Key key = Key::none;
    bool shift = false, control = false;
    Button button = Button::left;
    glm::dvec2 at{0.0};  ///< of the mouse, in the window's units, from its upper left corner
    double steps = 0;    ///< of the wheel, away from the user
    std::string file{};  ///< that was dropped
};

}  // namespace viewer
