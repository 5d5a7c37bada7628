#include <algorithm>
#include <iterator>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

#include "scenes/placed_scene.hpp"
#include "support/variants.hpp"
#include "variants.hpp"

namespace farfield::bench {
namespace {

/// All that the chart has, drawn by the z-buffer, with masks or both ways.
auto listed_variants() {
#ifdef FARFIELD_FEW_VARIANTS  // by which the command line is tested
    return variants_of(std::tuple{Named{"", Octree{}}},
                       std::tuple{Named{"exact", Exact{}}, Named{"color-cube", ColorCube{}}},
                       std::tuple{Named{"", TriangleCount{}}});
#else
    return std::tuple_cat(variants(), image_variants(), strict_variants());
#endif
}
// After all that are drawn by the z-buffer.
constexpr std::size_t with_masks = 1000, with_masks_by_table = 2000;

template <class V>
AnyVariant any(const V& variant) {
    using Hierarchy = typename V::hierarchy_type;
    const auto build = [variant](const scenes::Scene& scene) -> std::unique_ptr<scenes::BuiltScene> {
        const auto partition = [&](std::size_t primitives) { return partition_for(variant, primitives); };
        return std::make_unique<scenes::PlacedScene<Hierarchy, InnerHierarchy<Hierarchy>>>(
            scene, partition, variant.approximation, variant.cost_model);
    };
    constexpr ApproximationFacts facts = Hierarchy::approximation_type::facts;
    return {variant.name, facts.stands_in, facts.caches_images, distance_measure(variant), build};
}

template <class V>
AnyVariant any_with_masks(const V& variant) {
    AnyVariant result = any(variant);
    result.name += "+masks";
    result.renderer.kind = scenes::RendererKind::coverage;
    if (V::hierarchy_type::ordering == OrderGuarantee::primitives) result.most_triangles = 200'000;
    return result;
}

/// Of the variants that are of one type and differ in their options: those are compiled together.
template <class Hierarchy, class... V>
constexpr std::size_t first_place(const std::tuple<V...>*) {
    constexpr bool is_same[] = {std::is_same_v<Hierarchy, typename V::hierarchy_type>...};
    return std::size_t(std::find(std::begin(is_same), std::end(is_same), true) - std::begin(is_same));
}

}  // namespace

template <>
std::vector<std::pair<std::size_t, AnyVariant>> variants_of_part<FARFIELD_VARIANT_PART>() {
    std::vector<std::pair<std::size_t, AnyVariant>> ours;
    const auto list = listed_variants();
    const auto add = [&]<std::size_t place>() {
        using List = decltype(listed_variants());
        using Hierarchy = typename std::tuple_element_t<place, List>::hierarchy_type;
        constexpr std::size_t first = first_place<Hierarchy>(static_cast<const List*>(nullptr));
        if constexpr (first % FARFIELD_VARIANT_PARTS == FARFIELD_VARIANT_PART) {
            const auto& variant = std::get<place>(list);
            constexpr bool is_strict = Hierarchy::ordering == OrderGuarantee::primitives;
            if (!is_strict) ours.emplace_back(place, any(variant));
            if (is_strict || (is_drawn_with_masks(variant) &&
                              scenes::PlacedScene<Hierarchy>::obstacle(scenes::RendererKind::coverage).empty())) {
                ours.emplace_back(with_masks + place, any_with_masks(variant));
            }
            if constexpr (place == 0) {
                // Once: what masks are made of is no matter of what they draw.
                AnyVariant by_table = any_with_masks(variant);
                by_table.name += "-by-table";
                by_table.renderer.masks_by_table = true;
                ours.emplace_back(with_masks_by_table, by_table);
            }
        }
    };
    [&]<std::size_t... place>(std::index_sequence<place...>) {
        (add.template operator()<place>(), ...);
    }
    (std::make_index_sequence<std::tuple_size_v<decltype(list)>>());
    return ours;
}

}  // namespace farfield::bench
