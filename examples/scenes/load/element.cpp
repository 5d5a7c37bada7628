#include "scenes/load/element.hpp"

#include <algorithm>

namespace farfield::scenes {

const Element* find_element(std::string_view symbol) {
    const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
    const auto same = [&](const Element& e) {
        return std::equal(e.symbol.begin(), e.symbol.end(), symbol.begin(), symbol.end(),
                          [&](char a, char b) { return lower(a) == lower(b); });
    };
    const auto found = std::find_if(elements.begin(), elements.end(), same);
    return found == elements.end() ? nullptr : &*found;
}

}  // namespace farfield::scenes
