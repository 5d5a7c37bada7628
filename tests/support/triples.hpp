// Every triple of policies that composes. A new policy is entered here once and is tested everywhere.
#pragma once

#include <tuple>
#include <utility>

#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/color_cube_cluster.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/approximation/sample_set.hpp"
#include "farfield/cost_model/measured_time.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/gap_bsp.hpp"
#include "farfield/partition/nested.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/partition/polygon_bsp.hpp"
#include "farfield/tuning/variants.hpp"

namespace farfield::test {

using OctreeOfBsps = Nested<Octree, PolygonBsp>;
using Partitions =
    std::tuple<Named<Octree>, Named<SharedOctree>, Named<PolygonBsp>, Named<OctreeOfBsps>, Named<GapBsp>>;
using Approximations =
    std::tuple<Named<Exact>, Named<ColorCube>, Named<ColorCubeCluster<2>>, Named<ColorCubeCluster<4>>,
               Named<OpacityTensor>, Named<SampleSet<AreaSplat>>, Named<SampleSet<OpacityTensor>>>;
using CostModels = std::tuple<Named<TriangleCount>, Named<MeasuredTime>>;

template <class... V>
std::tuple<typename V::hierarchy_type...> hierarchies_of(const std::tuple<V...>&);

/// What is built and drawn with an approximation: each partition that goes with it, and each cost model, with the first
/// of the others. Prices are numbers, which change what is chosen and double what is compiled.
template <class A>
using AllHierarchiesWith = decltype(hierarchies_of(std::tuple_cat(
    variants_of(std::declval<Partitions>(), std::declval<std::tuple<Named<A>>>(),
                std::declval<std::tuple<std::tuple_element_t<0, CostModels>>>()),
    variants_of(std::declval<std::tuple<std::tuple_element_t<0, Partitions>>>(), std::declval<std::tuple<Named<A>>>(),
                std::declval<std::tuple<std::tuple_element_t<1, CostModels>>>()))));

#if defined(FARFIELD_FEW_VARIANTS)
/// Where another build has them all: what stands in, with one partition each, so that every policy is there, and each
/// partition with stand-ins and without.
template <class A>
struct FewHierarchiesWith;
template <>
struct FewHierarchiesWith<Exact> {
    using type = AllHierarchiesWith<Exact>;
};
template <>
struct FewHierarchiesWith<ColorCube> {
    using type = std::tuple<SpatialHierarchy<Octree, ColorCube, MeasuredTime>>;
};
template <>
struct FewHierarchiesWith<ColorCubeCluster<2>> {
    using type = std::tuple<SpatialHierarchy<SharedOctree, ColorCubeCluster<2>, TriangleCount>>;
};
template <>
struct FewHierarchiesWith<ColorCubeCluster<4>> {
    using type = std::tuple<SpatialHierarchy<OctreeOfBsps, ColorCubeCluster<4>, TriangleCount>>;
};
template <>
struct FewHierarchiesWith<OpacityTensor> {
    using type = std::tuple<SpatialHierarchy<PolygonBsp, OpacityTensor, TriangleCount>>;
};
template <>
struct FewHierarchiesWith<SampleSet<AreaSplat>> {
    using type = std::tuple<SpatialHierarchy<Octree, SampleSet<AreaSplat>, TriangleCount>>;
};
template <>
struct FewHierarchiesWith<SampleSet<OpacityTensor>> {
    using type = std::tuple<SpatialHierarchy<GapBsp, SampleSet<OpacityTensor>, TriangleCount>>;
};
template <class A>
using HierarchiesWith = typename FewHierarchiesWith<A>::type;
#else
template <class A>
using HierarchiesWith = AllHierarchiesWith<A>;
#endif
/// Every triple.
using Hierarchies = decltype(hierarchies_of(
    variants_of(std::declval<Partitions>(), std::declval<Approximations>(), std::declval<CostModels>())));
static_assert(std::tuple_size_v<Hierarchies> == (5 * 5 + 2 * 2) * std::tuple_size_v<CostModels>,
              "all of today's policies compose, but that sample sets want every item in one cell, whole");

}  // namespace farfield::test
