// What is cheap about a descent: what the cut is, tests/viewer.cpp says.
#include "farfield/frame/descent.hpp"

#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/viewer.hpp"
#include "support/recorder.hpp"
#include "support/scenes.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

using ExactOctree = SpatialHierarchy<Octree, Exact, TriangleCount>;
using Cubes = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
using FrontToBack = BasicRecorder<RendererFacts{
    .order = VisitOrder::front_to_back, .keeps_sources = true, .draws_faces = true, .draws_splats = true}>;

template <class R, class H>
FrameStats frame(const H& h, const Triangles& triangles, const View& view) {
    R recorder;
    return make_viewer(h, triangles, recorder).frame(view);
}

}  // namespace

TEST_CASE("what lies within the frustum is drawn as one run, of which no cell is looked at") {
    const Triangles triangles = random_triangles(5000, 710, 0.02f);
    const ExactOctree h = build<ExactOctree>(triangles);
    REQUIRE(h.nodes().size() > 50);
    const FrameStats inside = frame<Recorder>(h, triangles, looking({12, 4, 8}));
    CHECK(inside.cells_visited == 1);
    CHECK(inside.runs == 1);
    CHECK(inside.primitives == triangles.size());
    // Not where the frustum's border passes through it, ...
    const FrameStats across = frame<Recorder>(h, triangles, looking({0.1, 0.2, 0.3}, {1, 1, 0}));
    CHECK(across.cells_visited > 10);
    CHECK(across.cells_outside > 0);
    CHECK(across.primitives < triangles.size());
    // ... nor where the renderer wants an order that a run does not have.
    CHECK(frame<FrontToBack>(h, triangles, looking({12, 4, 8})).cells_visited == h.nodes().size());
}

TEST_CASE("where no stand-in may be drawn any more, a subtree within the frustum is one run") {
    const Triangles triangles = random_triangles(5000, 711, 0.02f);
    const Cubes h = build<Cubes>(triangles);
    REQUIRE(h.stand_ins().size() > 100);
    CHECK(frame<Recorder>(h, triangles, looking({12, 4, 8}, {}, 256, 0)).cells_visited == 1);
    const FrameStats near = frame<Recorder>(h, triangles, looking({12, 4, 8}, {}, 256, 0.01f));
    CHECK(near.approximations == 0);
    CHECK(near.cells_visited == 1);
    const FrameStats far = frame<Recorder>(h, triangles, looking({12, 4, 8}, {}, 256, 12));
    CHECK(far.approximations > 0);
    CHECK(far.cells_visited > far.approximations);
}

TEST_CASE("a small subtree is not culled triangle by triangle") {
    const Triangles triangles = random_triangles(max_items_unculled, 712, 0.02f);
    const ExactOctree h = build<ExactOctree>(triangles, {.partition = {.uniform_depth = 2}});
    REQUIRE(h.nodes().size() > 20);
    const FrameStats across = frame<Recorder>(h, triangles, looking({0.1, 0.2, 0.3}, {1, 1, 0}));
    CHECK(across.cells_visited == 1);
    CHECK(across.primitives == triangles.size());
    Triangles more = triangles;
    more.push_back(triangles[0]);
    const ExactOctree larger = build<ExactOctree>(more, {.partition = {.uniform_depth = 2}});
    CHECK(frame<Recorder>(larger, more, looking({1.5, 0.5, 1})).cells_visited > 1);
}
