#include <algorithm>
#include <iterator>
#include <tuple>
#include <type_traits>
#include <utility>

#include "scenes/placed_scene.hpp"
#include "support/variants.hpp"
#include "variants.hpp"

namespace farfield::bench {
namespace {

template <class V>
AnyVariant any(const V& variant) {
    using Hierarchy = typename V::hierarchy_type;
    const auto build = [variant](const scenes::Scene& scene) -> std::unique_ptr<scenes::BuiltScene> {
        const auto partition = [&](std::size_t primitives) { return partition_for(variant, primitives); };
        return std::make_unique<scenes::PlacedScene<Hierarchy>>(scene, partition, variant.approximation, variant.cost);
    };
    return {variant.name, Hierarchy::approximation_type::facts.stands_in, distance_measure(variant), build};
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
    const auto list = variants();
    const auto add = [&]<std::size_t place>() {
        using List = decltype(variants());
        using Hierarchy = typename std::tuple_element_t<place, List>::hierarchy_type;
        constexpr std::size_t first = first_place<Hierarchy>(static_cast<const List*>(nullptr));
        if constexpr (first % FARFIELD_VARIANT_PARTS == FARFIELD_VARIANT_PART) {
            ours.emplace_back(place, any(std::get<place>(list)));
        }
    };
    [&]<std::size_t... place>(std::index_sequence<place...>) {
        (add.template operator()<place>(), ...);
    }
    (std::make_index_sequence<std::tuple_size_v<decltype(list)>>());
    return ours;
}

}  // namespace farfield::bench
