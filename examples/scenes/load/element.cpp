#include "scenes/load/element.hpp"

#include <algorithm>
#include <cmath>

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

const Element* find_element_by_mass(double daltons) {
    // IUPAC, "Abridged standard atomic weights", 2021; of uranium and the like as given there, in the table's order.
    static constexpr std::array<double, elements.size()> weights{
        1.008,  4.0026, 6.94,   9.0122, 10.81,  12.011, 14.007, 15.999, 18.998, 20.180, 22.990, 24.305, 26.982,
        28.085, 30.974, 32.06,  35.45,  39.95,  39.098, 40.078, 47.867, 50.942, 51.996, 54.938, 55.845, 58.933,
        58.693, 63.546, 65.38,  74.922, 78.971, 79.904, 83.798, 85.468, 87.62,  95.95,  107.87, 112.41, 118.71,
        127.60, 126.90, 131.29, 132.91, 137.33, 157.25, 183.84, 195.08, 196.97, 200.59, 207.2,  238.03, 2.014};
    std::size_t nearest = 0;
    for (std::size_t i = 1; i < weights.size(); ++i) {
        if (std::abs(weights[i] - daltons) < std::abs(weights[nearest] - daltons)) nearest = i;
    }
    const double distance = std::abs(weights[nearest] - daltons);
    return distance <= std::max(0.01, 0.001 * weights[nearest]) ? &elements[nearest] : nullptr;
}

}  // namespace farfield::scenes
