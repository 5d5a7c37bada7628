// What files of pages our programs make and open: one primitive, three ways to draw what is far away.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/approximation/sample_set.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/spatial_hierarchy.hpp"

namespace farfield::scenes {

using PagedPrimitive = VertexColoredTriangle;

template <class A>
using PagedOver = SpatialHierarchy<Octree, A, TriangleCount>;

inline constexpr std::array<std::string_view, 3> paged_variant_names{"opacity-tensor", "color-cube", "sample-tree"};

/// Calls f(std::type_identity<H>, name) for each, until one returns true. False if none does.
template <class F>
bool any_paged_variant(F&& f) {
    return f(std::type_identity<PagedOver<OpacityTensor>>(), paged_variant_names[0]) ||
           f(std::type_identity<PagedOver<ColorCube>>(), paged_variant_names[1]) ||
           f(std::type_identity<PagedOver<SampleSet<AreaSplat>>>(), paged_variant_names[2]);
}

}  // namespace farfield::scenes
