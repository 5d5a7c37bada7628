// The variants of support/variants.hpp as the rest of the program sees them: without knowing their types.
#pragma once

#include <cstddef>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "farfield/view.hpp"
#include "scenes/built_scene.hpp"
#include "scenes/renderers/renderer_choice.hpp"
#include "scenes/scene.hpp"

namespace farfield::bench {

struct AnyVariant {
    std::string name;
    bool stands_in = false;      ///< else no tolerance changes anything
    bool caches_images = false;  ///< what it costs depends on how the viewer moves
    DistanceMeasure distance = DistanceMeasure::nearest_point;
    std::function<std::unique_ptr<scenes::BuiltScene>(const scenes::Scene&)> build;
    scenes::RendererChoice renderer{};  ///< but for its samples and back faces
    /// Over more stored ones it is left out: strict order cuts leaves into eight pieces and takes 0.06 ms for each.
    std::size_t most_triangles = std::numeric_limits<std::size_t>::max();

    /// A pixel, where so many are asked for: coverage masks have 64 for about the price of one.
    int samples(int asked) const { return has_own_samples() ? 64 : asked; }
    bool has_own_samples() const { return renderer.kind == scenes::RendererKind::coverage; }
};

/// Of `variants` those that are built over so many stored triangles.
inline std::vector<const AnyVariant*> variants_over(std::size_t triangles, std::vector<const AnyVariant*> variants) {
    std::erase_if(variants, [&](const AnyVariant* v) { return triangles > v->most_triangles; });
    return variants;
}

/// All in the order of the list, drawn by the z-buffer; then those drawn with coverage masks, whose names say so. The
/// first is exact.
const std::vector<AnyVariant>& all_variants();

/// Those that a part of the program has been given to compile, and their places in the list. Each type takes some 15
/// seconds, so the build system compiles variants_part.cpp as FARFIELD_VARIANT_PARTS objects.
template <unsigned part>
std::vector<std::pair<std::size_t, AnyVariant>> variants_of_part();

}  // namespace farfield::bench
