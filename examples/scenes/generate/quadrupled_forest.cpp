#include "scenes/generate/quadrupled_forest.hpp"

#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "scenes/framing.hpp"
#include "scenes/generate/quarter_turn.hpp"
#include "scenes/generate/random.hpp"
#include "scenes/generate/tree.hpp"
#include "scenes/light.hpp"

namespace farfield::scenes {
namespace {

constexpr std::uint32_t most_levels = 20;
constexpr float field_of_view = 1.04719755f;  // 60 degrees
constexpr double radians_per_degree = 3.14159265358979323846 / 180.0;
/// Above every leaf of a tree of 10 meters.
constexpr double forest_height_m = 12.0;

std::array<int, 4> shuffled_turns(Random& random) {
    std::array<int, 4> turns{0, 1, 2, 3};
    for (std::size_t i = 3; i > 0; --i) std::swap(turns[i], turns[random.below(i + 1)]);
    return turns;
}

}  // namespace

Scene quadrupled_forest(const QuadrupledForestOptions& options) {
    if (options.levels > most_levels) throw std::invalid_argument("quadrupled_forest: more than 20 levels");
    if (!(options.spacing_m > 0 && std::isfinite(std::ldexp(options.spacing_m, most_levels)))) {
        throw std::invalid_argument("quadrupled_forest: the spacing must be positive and finite");
    }
    TreeOptions tree_options;
    tree_options.seed = options.seed;
    tree_options.triangles = options.tree_triangles;
    tree_options.light.to_sun = glm::vec3(0, 1, 0);
    Scene scene{"quadrupled-forest", {std::move(tree(tree_options).groups.front())}};
    if (options.ground) {
        const float h = 0.5f * options.spacing_m;
        const Rgba8 grass = display_color({0.095f, 0.14f, 0.033f});
        const glm::vec3 a(-h, 0, -h), b(-h, 0, h), c(h, 0, h), d(h, 0, -h);
        scene.groups[0].triangles.push_back({{a, b, c}, {grass, grass, grass}});
        scene.groups[0].triangles.push_back({{a, c, d}, {grass, grass, grass}});
    }
    Random random(options.seed * 0x9fb21c651e98df25u + 11);
    for (std::uint32_t level = 0; level < options.levels; ++level) {
        const float h = std::ldexp(0.5f * options.spacing_m, static_cast<int>(level));
        const std::array<int, 4> turns = shuffled_turns(random);
        Group& group = scene.groups.emplace_back();
        for (std::size_t i = 0; i < 4; ++i) {
            const glm::vec3 center((i & 1) ? h : -h, 0, (i & 2) ? h : -h);
            group.placements.push_back({level, quarter_turn(turns[i], center)});
        }
    }
    return scene;
}

Scene quadrupled_forest(std::uint32_t levels) {
    QuadrupledForestOptions options;
    options.levels = levels;
    return quadrupled_forest(options);
}

double half_extent_m(const QuadrupledForestOptions& options) {
    return std::ldexp(0.5 * options.spacing_m, static_cast<int>(options.levels));
}

Camera eye_level(const QuadrupledForestOptions& options, double height_m) {
    const glm::dvec3 eye(0, height_m, half_extent_m(options) + 0.25 * options.spacing_m);
    const double slant = 10.0 * radians_per_degree;
    return Camera::perspective(eye, eye + glm::dvec3(std::sin(slant), 0, -std::cos(slant)), {0, 1, 0}, field_of_view);
}

Camera aerial(const QuadrupledForestOptions& options, double elevation_degrees) {
    const double half = half_extent_m(options) + 0.25 * options.spacing_m;  // crowns hang over the edge
    const double elevation = elevation_degrees * radians_per_degree;
    return framing({{-half, 0, -half}, {half, forest_height_m, half}}, {0, std::sin(elevation), std::cos(elevation)},
                   field_of_view);
}

}  // namespace farfield::scenes
