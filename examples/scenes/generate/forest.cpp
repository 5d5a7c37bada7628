#include "scenes/generate/forest.hpp"

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <stdexcept>

#include "scenes/generate/random.hpp"
#include "scenes/generate/tree.hpp"
#include "scenes/light.hpp"

namespace farfield::scenes {

Scene forest(const ForestOptions& options) {
    if (options.columns == 0 || options.rows == 0) throw std::invalid_argument("forest: no trees");
    if (options.tree_kinds == 0) throw std::invalid_argument("forest: no tree kinds");
    Scene scene{"forest", {}};
    for (std::size_t kind = 0; kind < options.tree_kinds; ++kind) {
        TreeOptions tree_options;
        tree_options.seed = options.seed + kind;
        tree_options.triangles = options.tree_triangles;
        tree_options.light.to_sun = glm::vec3(0, 1, 0);  // the same light however a tree is turned
        scene.groups.push_back(std::move(tree(tree_options).groups.front()));
    }
    Group& root = scene.groups.emplace_back();
    Random random(options.seed * 0x2545f4914f6cdd1du + 5);
    const auto place = [&](std::size_t column, std::size_t row, float dx, float dz) {
        return glm::vec3(
            options.spacing_m * (static_cast<float>(column) + dx - 0.5f * static_cast<float>(options.columns)), 0,
            options.spacing_m * (static_cast<float>(row) + dz - 0.5f * static_cast<float>(options.rows)));
    };
    for (std::size_t row = 0; row < options.rows; ++row) {
        for (std::size_t column = 0; column < options.columns; ++column) {
            const float tint = random.between(0.8f, 1.1f);
            const Rgba8 grass = display_color(glm::vec3(0.10f, 0.15f, 0.035f) * tint);
            const glm::vec3 a = place(column, row, 0, 0), b = place(column, row, 0, 1);
            const glm::vec3 c = place(column, row, 1, 1), d = place(column, row, 1, 0);
            root.triangles.push_back({{a, b, c}, {grass, grass, grass}});
            root.triangles.push_back({{a, c, d}, {grass, grass, grass}});
            const glm::mat4 moved = glm::translate(glm::mat4(1.0f), place(column, row, 0.5f, 0.5f));
            const float turn = glm::quarter_pi<float>() * static_cast<float>(random.below(8));
            root.placements.push_back(
                {static_cast<std::size_t>(random.below(options.tree_kinds)), glm::rotate(moved, turn, {0, 1, 0})});
        }
    }
    return scene;
}

Scene forest(std::size_t trees_per_side) {
    ForestOptions options;
    options.columns = options.rows = trees_per_side;
    return forest(options);
}

}  // namespace farfield::scenes
