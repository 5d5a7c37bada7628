#include "farfield/partition/nested.hpp"

#include "catch.hpp"
#include "farfield/build.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/partition/polygon_bsp.hpp"
#include "farfield/spatial_hierarchy.hpp"
#include "support/clipped.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

using OctreeOfBsps = Nested<Octree, PolygonBsp>;
using Hierarchy = SpatialHierarchy<OctreeOfBsps, Exact, TriangleCount>;

Hierarchy built(const Triangles& triangles) {
    return build<Hierarchy>(triangles, {.partition = {.largest_leaf = 12}});
}

}  // namespace

static_assert(Partition<OctreeOfBsps> && CutsItems<OctreeOfBsps> && sizeof(OctreeOfBsps::node_data) == 32);
static_assert(Hierarchy::assignment == Assignment::clipped && Hierarchy::ordering == OrderGuarantee::primitives);

TEST_CASE("polygons of an octree of BSPs come in strict order from everywhere") {
    for (const ClippedScene& scene : clipped_scenes()) {
        INFO(scene.name);
        check_strict_order(built(scene.triangles), scene.triangles);
    }
}

TEST_CASE("fragments of an octree of BSPs have the area of what they were cut from") {
    for (const ClippedScene& scene : clipped_scenes()) {
        INFO(scene.name);
        check_fragments(built(scene.triangles), scene.triangles);
    }
}

TEST_CASE("fragments of an octree of BSPs cover what was cut") {
    for (const ClippedScene& scene : clipped_scenes()) {
        INFO(scene.name);
        check_pictures(built(scene.triangles), scene.triangles);
    }
}
