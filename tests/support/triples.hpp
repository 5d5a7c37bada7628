// Every triple of policies that composes. A new policy is entered here once and is tested everywhere.
#pragma once

#include <tuple>

#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/color_cube_cluster.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/cost/measured_time.hpp"
#include "farfield/cost/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/spatial_hierarchy.hpp"

namespace farfield::test {

using Partitions = std::tuple<Octree, SharedOctree>;
using Approximations = std::tuple<Exact, ColorCube, ColorCubeCluster<2>, ColorCubeCluster<4>>;
using CostModels = std::tuple<TriangleCount, MeasuredTime>;

template <class P, class A, class C>
auto hierarchy_if_composable() {
    if constexpr (Composable<P, A, C>) {
        return std::tuple<SpatialHierarchy<P, A, C>>{};
    } else {
        return std::tuple<>{};
    }
}
template <class P, class A, class... C>
auto with_costs(std::tuple<C...>*) {
    return std::tuple_cat(hierarchy_if_composable<P, A, C>()...);
}
template <class A, class... P>
auto with_partitions(std::tuple<P...>*) {
    return std::tuple_cat(with_costs<P, A>(static_cast<CostModels*>(nullptr))...);
}
template <class... A>
auto with_approximations(std::tuple<A...>*) {
    return std::tuple_cat(with_partitions<A>(static_cast<Partitions*>(nullptr))...);
}

/// SpatialHierarchy of each partition and cost model that goes with an approximation.
template <class A>
using HierarchiesWith = decltype(with_partitions<A>(static_cast<Partitions*>(nullptr)));
/// Of every triple.
using Hierarchies = decltype(with_approximations(static_cast<Approximations*>(nullptr)));
static_assert(std::tuple_size_v<Hierarchies> == 16, "all of today's policies compose");

}  // namespace farfield::test
