// The triples that can be asked for by name. A new one is a file variant_NAME.cpp with a function that builds, and a
// line in variants.cpp.
#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "scenes/built_scene.hpp"
#include "scenes/scene.hpp"

namespace walkthrough {

struct Variant {
    std::string_view name;  ///< shorter than 24 characters
    std::string_view description;
    std::unique_ptr<farfield::scenes::BuiltScene> (*build)(const farfield::scenes::Scene& scene);
    farfield::DistanceMeasure distance = farfield::DistanceMeasure::nearest_point;
};

/// Exact is the first.
std::span<const Variant> variants();

/// Null if there is none of that name.
const Variant* find_variant(std::string_view name);

// One source file each, for each of these types takes seconds to compile.
std::unique_ptr<farfield::scenes::BuiltScene> build_exact(const farfield::scenes::Scene& scene);
std::unique_ptr<farfield::scenes::BuiltScene> build_color_cube(const farfield::scenes::Scene& scene);
std::unique_ptr<farfield::scenes::BuiltScene> build_color_cube_direct(const farfield::scenes::Scene& scene);
std::unique_ptr<farfield::scenes::BuiltScene> build_color_cube_1995(const farfield::scenes::Scene& scene);
std::unique_ptr<farfield::scenes::BuiltScene> build_color_cube_cluster(const farfield::scenes::Scene& scene);
std::unique_ptr<farfield::scenes::BuiltScene> build_color_cube_shared(const farfield::scenes::Scene& scene);
std::unique_ptr<farfield::scenes::BuiltScene> build_opacity_tensor(const farfield::scenes::Scene& scene);

}  // namespace walkthrough
