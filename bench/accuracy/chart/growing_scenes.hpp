// Scenes that grow, and the views from which their time is told.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/generate/chessboard.hpp"
#include "scenes/generate/quadrupled_forest.hpp"
#include "scenes/generate/tree.hpp"
#include "scenes/scene.hpp"
#include "views.hpp"

namespace farfield::bench {

struct NamedView {
    std::string name;
    View view;
};

struct GrowingScene {
    std::string_view name;
    std::vector<std::uint32_t> sizes, quick_sizes;
    scenes::Scene (*make)(std::uint32_t size);
    std::vector<NamedView> (*views)(std::uint32_t size, const scenes::Scene& scene, int size_px);
    double (*triangles)(std::uint32_t size);  ///< about, with every instance counted
    double (*stored)(std::uint32_t size);     ///< about, with every instance counted once
};

namespace detail {

inline View square(const Camera& camera, int size_px) {
    return {.camera = camera, .width = size_px, .height = size_px};
}
inline double itself(std::uint32_t size) {
    return double(size);
}

}  // namespace detail

inline const std::vector<GrowingScene>& growing_scenes() {
    using scenes::Scene;
    static const std::vector<GrowingScene> all{
        {"tree",
         {2'000, 8'000, 32'000, 128'000, 512'000, 800'000},
         {2'000, 16'000, 128'000},
         [](std::uint32_t triangles) { return scenes::tree({.triangles = triangles}); },
         [](std::uint32_t, const Scene& scene, int size_px) {
             return std::vector<NamedView>{{"7 radii", view_from(scenes::bounds(scene), scene.up, 7, 30, size_px)}};
         },
         detail::itself,
         detail::itself},
        {"chessboard",
         {2'000, 20'000, 80'000, 320'000, 1'280'000},
         {2'000, 20'000, 200'000},
         [](std::uint32_t triangles) { return scenes::chessboard(triangles); },
         [](std::uint32_t triangles, const Scene&, int size_px) {
             return std::vector<NamedView>{
                 {"low over it", detail::square(scenes::low_over_chessboard({.triangles = triangles}), size_px)}};
         },
         detail::itself,
         detail::itself},
        // Sizes are levels: 4^level trees.
        {"quadrupled-forest",
         {0, 1, 2, 3, 4, 5, 6, 7},
         {0, 2, 4},
         [](std::uint32_t levels) { return scenes::quadrupled_forest(levels); },
         [](std::uint32_t levels, const Scene&, int size_px) {
             const scenes::QuadrupledForestOptions options{.levels = levels};
             return std::vector<NamedView>{{"eye level", detail::square(scenes::eye_level(options), size_px)},
                                           {"from above", detail::square(scenes::aerial(options), size_px)}};
         },
         [](std::uint32_t levels) { return std::ldexp(52'472.0, 2 * int(levels)); },
         [](std::uint32_t) { return 52'472.0; }},
    };
    return all;
}

}  // namespace farfield::bench
