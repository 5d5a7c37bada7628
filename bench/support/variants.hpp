// What the experiments compare: every composition of these policies. A new policy is one line here.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>
#include <tuple>
#include <type_traits>

#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/color_cube_cluster.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/image_cache.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/approximation/sample_set.hpp"
#include "farfield/approximation/sided_tensor.hpp"
#include "farfield/cost_model/measured_time.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/gap_bsp.hpp"
#include "farfield/partition/nested.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/partition/polygon_bsp.hpp"
#include "farfield/tuning/variants.hpp"
#include "farfield/view.hpp"

namespace farfield::bench {

/// As a tuple of Variants; the first is `exact`, which the others are measured against. MeasuredTime would make other
/// prices of the same cells, and twice as many types: a minute and a half more to compile, twice the time to run.
inline auto variants() {
    return variants_of(
        std::tuple{
            Named{"", Octree{}},
            Named{"shared", SharedOctree{}},
        },
        std::tuple{
            Named{"exact", Exact{}},
            Named{"color-cube", ColorCube{}},
            Named{"opacity-tensor", OpacityTensor{}},
            Named{"sample-tree", SampleSet<OpacityTensor>{}},
            Named{"sample-tree-splats", SampleSet<AreaSplat>{}},
            Named{"sample-tree-sided", SampleSet<SidedTensor>{}},
            Named{"color-cube-direct", ColorCube{.inner = ColorCube::Inner::direct}},
            Named{"color-cube-1995", ColorCube{.opacity = ColorCube::Opacity::thresholded}},
            Named{"color-cube-cluster", ColorCubeCluster<4>{}},
        },
        std::tuple{
            Named{"", TriangleCount{}},
        });
}

/// Those that keep primitives in strict order, for coverage masks (Greene 1996). They draw everything exactly.
inline auto strict_variants() {
    return variants_of(std::tuple{Named{"bsp", PolygonBsp{}}, Named{"octree-of-bsps", Nested<Octree, PolygonBsp>{}}},
                       std::tuple{Named{"", Exact{}}}, std::tuple{Named{"", TriangleCount{}}});
}

/// Those of Shade et al. 1996: planes in gaps, alone and with images of what a viewer drew in the frames before.
inline auto image_variants() {
    const std::tuple gaps{Named{"", GapBsp{}}};
    return std::tuple_cat(variants_of(std::tuple{Named{"gap-bsp", GapBsp{}}}, std::tuple{Named{"", Exact{}}},
                                      std::tuple{Named{"", TriangleCount{}}}),
                          variants_of(gaps,
                                      std::tuple{Named{"image-cache", ImageCache<Exact>{}},
                                                 Named{"image-cache-lod", ImageCache<OpacityTensor>{}}},
                                      std::tuple{Named{"", MeasuredTime{}}}));
}

/// The hierarchies of what is placed: those of images over a far field are octrees, for cells between gaps are long,
/// and few of their stand-ins are good at several pixels.
template <class H>
using InnerHierarchy =
    std::conditional_t<H::approximation_type::facts.caches_images && H::approximation_type::facts.stands_in,
                       SpatialHierarchy<Octree, typename H::approximation_type, typename H::cost_model_type>, H>;

/// Whether experiments draw it with coverage masks, too: the gain from hiding what is hidden and from 64 samples a
/// pixel is much the same for its relatives.
template <class V>
bool is_drawn_with_masks(const V& variant) {
    constexpr std::array<std::string_view, 3> names{"exact", "color-cube", "opacity-tensor"};
    return std::find(names.begin(), names.end(), variant.name) != names.end();
}

/// Of the report of 1995: opaque faces go with a uniform depth and with the depth of a cell as its distance.
template <class V>
bool is_of_1995(const V& variant) {
    if constexpr (std::is_same_v<std::remove_cvref_t<decltype(variant.approximation)>, ColorCube>) {
        return variant.approximation.opacity == ColorCube::Opacity::thresholded;
    } else {
        return false;
    }
}

template <class V>
DistanceMeasure distance_measure(const V& variant) {
    return is_of_1995(variant) ? DistanceMeasure::depth : DistanceMeasure::nearest_point;
}

/// The variant's partition for a hierarchy over so many primitives. Surfaces fill four cells of eight; a uniform depth
/// is such that leaves hold some ten triangles, the price of a splat: deeper ones have no stand-in that pays.
template <class V>
auto partition_for(const V& variant, std::size_t primitives) {
    auto partition = variant.partition;
    if (is_of_1995(variant)) {
        if constexpr (requires { partition.uniform_depth; }) {
            partition.uniform_depth = 1;
            for (std::size_t cells = 4; cells * 10 < primitives; cells *= 4) ++partition.uniform_depth;
        }
    }
    return partition;
}

}  // namespace farfield::bench
