#include "scenes/catalog.hpp"

#include <stdexcept>

#include "scenes/generate/building.hpp"
#include "scenes/generate/chessboard.hpp"
#include "scenes/generate/forest.hpp"
#include "scenes/generate/island.hpp"
#include "scenes/generate/molecule.hpp"
#include "scenes/generate/quadrupled_forest.hpp"
#include "scenes/generate/square_cube.hpp"
#include "scenes/generate/tree.hpp"

namespace farfield::scenes {
namespace {

struct Entry {
    std::string_view name;
    Scene (*make)();
};

constexpr Entry catalog[] = {
    {"tree", [] { return tree(); }},
    {"molecule", [] { return molecule(); }},
    {"island", [] { return island(); }},
    {"shade-island", [] { return island(shade_island); }},
    {"forest", [] { return expanded(forest(ForestOptions{})); }},
    {"forest-instanced", [] { return forest(20); }},
    {"quadrupled-forest", [] { return quadrupled_forest(); }},
    {"building", [] { return building(); }},
    {"chessboard", [] { return chessboard(); }},
    {"cube", [] { return square_cube(); }},
};

}  // namespace

std::vector<std::string> names() {
    std::vector<std::string> result;
    for (const Entry& entry : catalog) result.emplace_back(entry.name);
    return result;
}

Scene make(std::string_view name) {
    std::string known;
    for (const Entry& entry : catalog) {
        if (entry.name == name) {
            Scene scene = entry.make();
            scene.name = entry.name;
            return scene;
        }
        known.append(known.empty() ? "" : ", ").append(entry.name);
    }
    throw std::invalid_argument("no scene '" + std::string(name) + "'; known are " + known);
}

}  // namespace farfield::scenes
