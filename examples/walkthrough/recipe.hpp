// What every file variant_NAME.cpp does with its type of hierarchy.
#pragma once

#include <cstddef>
#include <memory>

#include "scenes/placed_scene.hpp"
#include "variants.hpp"

namespace walkthrough {

/// `partition_for` is given how many primitives a group has.
template <class Hierarchy, class Inner = Hierarchy, class PartitionFor>
Recipe recipe(PartitionFor partition_for, const typename Hierarchy::approximation_type& approximation) {
    using Scene = farfield::scenes::PlacedScene<Hierarchy, Inner>;
    using farfield::scenes::SceneProgress;
    const auto build = [=](const farfield::scenes::Scene& scene,
                           const SceneProgress& progress) -> std::unique_ptr<farfield::scenes::BuiltScene> {
        return std::make_unique<Scene>(scene, partition_for, approximation, typename Hierarchy::cost_model_type{},
                                       progress);
    };
    return {build, Scene::obstacle};
}

/// With the partition as it is by default.
template <class Hierarchy, class Inner = Hierarchy>
Recipe recipe(const typename Hierarchy::approximation_type& approximation = {}) {
    return recipe<Hierarchy, Inner>([](std::size_t) { return typename Hierarchy::partition_type{}; }, approximation);
}

}  // namespace walkthrough
