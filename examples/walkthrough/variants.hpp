// The triples that can be asked for by name. A new one is a file variant_NAME.cpp with its recipe, and a line in
// variants.cpp.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string_view>

#include "scenes/built_scene.hpp"
#include "scenes/renderers/renderer_choice.hpp"
#include "scenes/scene.hpp"

namespace walkthrough {

struct Recipe {
    std::function<std::unique_ptr<farfield::scenes::BuiltScene>(const farfield::scenes::Scene&,
                                                                const farfield::scenes::SceneProgress&)>
        build;
    /// As PlacedScene::obstacle.
    std::string_view (*obstacle)(farfield::scenes::RendererKind);
};

struct Variant {
    std::string_view name;  ///< shorter than 24 characters
    std::string_view description;
    Recipe (*recipe)();
    farfield::DistanceMeasure distance = farfield::DistanceMeasure::nearest_point;

    std::unique_ptr<farfield::scenes::BuiltScene> build(const farfield::scenes::Scene& scene,
                                                        const farfield::scenes::SceneProgress& progress = {}) const {
        return recipe().build(scene, progress);
    }
    /// Empty where the renderer can draw it.
    std::string_view obstacle(farfield::scenes::RendererKind kind) const { return recipe().obstacle(kind); }
};

/// Exact is the first.
std::span<const Variant> variants();

/// Null if there is none of that name.
const Variant* find_variant(std::string_view name);

// One source file for each type of hierarchy, for each takes seconds to compile.
Recipe exact();
Recipe color_cube();
Recipe color_cube_direct();
Recipe color_cube_1995();
Recipe color_cube_cluster();
Recipe color_cube_shared();
Recipe opacity_tensor();
Recipe sample_tree();
Recipe sample_tree_splats();
Recipe sample_tree_sided();
Recipe bsp();
Recipe octree_of_bsps();
Recipe gap_bsp();
Recipe image_cache();
Recipe image_cache_lod();

}  // namespace walkthrough
