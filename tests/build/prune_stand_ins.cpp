// Stand-ins that their parents reproduce are not kept, and nothing else changes.
#include <bit>
#include <cstring>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/measure/image_error.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/storage/soundness.hpp"
#include "farfield/viewer.hpp"
#include "support/pictures.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

using Cubes = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
using SharedCubes = SpatialHierarchy<SharedOctree, ColorCube, TriangleCount>;

constexpr ColorCube keeps_all{.redundancy_tolerance = -1};

/// A solid of one color, filled with sheets along three axes: every cell inside looks alike from everywhere.
Triangles solid(int sheets, int squares) {
    Triangles out;
    for (int i = 0; i <= sheets; ++i) {
        const float at = -1 + 2 * float(i) / float(sheets);
        append(out, sheet({-1, at, -1}, {2, 0, 0}, {0, 0, 2}, squares, squares, {90, 120, 60}));
        append(out, sheet({-1, -1, at}, {2, 0, 0}, {0, 2, 0}, squares, squares, {90, 120, 60}));
        append(out, sheet({at, -1, -1}, {0, 0, 2}, {0, 2, 0}, squares, squares, {90, 120, 60}));
    }
    return out;
}

template <class H>
H built(const Triangles& triangles, const ColorCube& cube) {
    return build<H>(triangles, {.approximation = cube});
}

template <class H>
Image picture(const H& h, const Triangles& triangles, const View& view) {
    ZBufferRenderer renderer;
    make_viewer(h, triangles, renderer).frame(view);
    return renderer.image();
}

}  // namespace

TEST_CASE("a solid of one color keeps fewer stand-ins, one level in two") {
    const Triangles triangles = solid(64, 32);
    const Cubes all = built<Cubes>(triangles, keeps_all), told = built<Cubes>(triangles, {});
    CHECK(told.stand_ins().size() < all.stand_ins().size());
    CHECK(detail::unsound_nodes(told.nodes(), told.item_count(), told.stand_ins().size(),
                                told.root_stand_in() != nullptr) == nullptr);
    std::size_t reaching = 0;
    for (const Node& n : told.nodes()) {
        CHECK(n.levels_replaced <= 1);
        if (n.levels_replaced == 0) continue;
        ++reaching;
        CHECK(n.stand_in_mask == 0);
    }
    CHECK(reaching > 0);
    for (const Node& n : all.nodes()) CHECK(n.levels_replaced == 0);
    REQUIRE(std::equal(all.order().begin(), all.order().end(), told.order().begin(), told.order().end()));
}

TEST_CASE("a story told once gives pictures about as good from everywhere") {
    const Triangles triangles = solid(64, 32);
    const Cubes all = built<Cubes>(triangles, keeps_all), told = built<Cubes>(triangles, {});
    const SharedCubes shared_told = built<SharedCubes>(triangles, {});
    for (const double distance : {4.0, 10.0, 30.0, 90.0}) {
        for (const float tolerance : {0.0f, 1.0f, 3.0f}) {
            INFO("distance " << distance << ", tolerance " << tolerance);
            const View view = looking(glm::dvec3(0.6, 0.5, 0.62) * distance, {}, 96, tolerance);
            const Image exact = plain_picture<Triangle>(triangles, view, {.samples = 64});
            const double with_all = rmse(picture(all, triangles, view), exact);
            CHECK(rmse(picture(told, triangles, view), exact) <= 2 * with_all + 0.005);
            CHECK(rmse(picture(shared_told, triangles, view), exact) <= 0.03);
            if (tolerance == 0) {
                CHECK(picture(told, triangles, view) == plain_picture<Triangle>(triangles, view));
            }
        }
    }
}

TEST_CASE("leaves of no use are dropped and their primitives stay in place") {
    // One flat square a cell of the finest level, colors alike: leaves of 2 * 4 * 4 triangles.
    const Triangles triangles = sheet({-1, -1, 0}, {2, 2, 0}, {0, 0, 2}, 128, 128, {200, 180, 160});
    const Cubes all = built<Cubes>(triangles, keeps_all),
                told = built<Cubes>(triangles, {.redundancy_tolerance = 0.2f});
    CHECK(told.nodes().size() < all.nodes().size());
    CHECK(told.report().nodes == told.nodes().size());
    REQUIRE(std::equal(all.order().begin(), all.order().end(), told.order().begin(), told.order().end()));
    CHECK(detail::unsound_nodes(told.nodes(), told.item_count(), told.stand_ins().size(),
                                told.root_stand_in() != nullptr) == nullptr);
    const View view = looking({1, 2, 5}, {}, 96, 0);
    CHECK(picture(told, triangles, view) == plain_picture<Triangle>(triangles, view));
}

TEST_CASE("where every cell has a story of its own nothing is merged") {
    const Triangles triangles = mixed_triangles(6000, 170);
    const Cubes all = built<Cubes>(triangles, keeps_all), told = built<Cubes>(triangles, {.redundancy_tolerance = 0});
    REQUIRE(all.nodes().size() == told.nodes().size());
    CHECK(std::equal(all.nodes().begin(), all.nodes().end(), told.nodes().begin()));
    REQUIRE(all.stand_ins().size() == told.stand_ins().size());
    CHECK(std::memcmp(all.stand_ins().data(), told.stand_ins().data(), all.stand_ins().size_bytes()) == 0);
}

TEST_CASE("a stand-in with reach is drawn up to half the distance, and there its children's contents are") {
    const Triangles triangles = solid(64, 32);
    const Cubes told = built<Cubes>(triangles, {});
    const Cubes all = built<Cubes>(triangles, keeps_all);
    for (const double distance : {6.0, 12.0, 25.0, 50.0, 100.0, 200.0}) {
        const View view = looking(glm::dvec3(0.6, 0.5, 0.62) * distance, {}, 128, 1);
        ZBufferRenderer renderer;
        const FrameStats with = make_viewer(told, triangles, renderer).frame(view);
        const FrameStats without = make_viewer(all, triangles, renderer).frame(view);
        INFO("distance " << distance);
        CHECK(with.approximations <= without.approximations);
        CHECK(with.primitives <= without.primitives);
    }
}
