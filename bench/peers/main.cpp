// Coverage masks against others' renderers at 64 samples a pixel, on the office building from inside, 512 x 512 pixels,
// one core, processor's time, in turns. Ours is a strict CoverageRenderer over an octree of BSP trees. What is built
// beforehand is part of no frame, on either side. Nobody has left out what cannot be seen: to know that is the
// business of each.
//
// rmse is of the two pictures. Embree's has one color a quadrilateral, and neither shares our samples' rounding.
#include <algorithm>
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "farfield/build.hpp"
#include "farfield/measure/image_error.hpp"
#include "farfield/partition/nested.hpp"
#include "farfield/partition/polygon_bsp.hpp"
#include "farfield/renderer/coverage_renderer.hpp"
#include "support/drawer.hpp"
#include "support/office.hpp"
#include "support/pair.hpp"
#ifdef FARFIELD_HAS_EMBREE
#include "embree_drawer.hpp"
#endif
#ifdef FARFIELD_HAS_EPOXY
#include "opengl_drawer.hpp"
#endif

namespace farfield::bench {
namespace {

void measure(const Run& run) {
    using OctreeOfBsps = SpatialHierarchy<Nested<Octree, PolygonBsp>, Exact, TriangleCount>;
    const OfficePlan plan;
    const auto triangles = scenes::expanded(scenes::building(plan.options)).groups.back().triangles;
    const auto hierarchy = build<OctreeOfBsps>(triangles);
    const auto masks = drawer<StrictCoverageRenderer>(hierarchy, triangles, CoverageOptions{});
    const std::vector<View> views = run.some(plan.inside());
    [[maybe_unused]] const auto row = [&](const std::string& name, Drawer& peer, double wanted) {
        std::vector<PairTimes> pairs;
        std::vector<double> errors;
        for (const View& view : views) {
            pairs.push_back(run.pair(view, *masks, peer));
            errors.push_back(rmse(masks->image(), peer.image()));
        }
        Table::add(name, pairs, Wanted::at_least(wanted));
        Table::add_figure(name + ": rmse", errors);
    };
    Table::header();
#ifdef FARFIELD_HAS_EMBREE
    row(embree_name() + ", 64 rays a pixel", *embree_drawer(triangles), 300);
#endif
#ifdef FARFIELD_HAS_EPOXY
    const auto opengl = opengl_drawer(triangles);
    row("OpenGL at 4096 x 4096, " + opengl_name(), *opengl, 500);
#endif
}

}  // namespace
}  // namespace farfield::bench

int main(int argc, char** argv) {
    using namespace farfield::bench;
    CLI::App app("Coverage masks against others' renderers, those that were installed when this was built.",
                 "coverage_peers");
    bool is_quick = false;
    app.add_flag("--quick", is_quick, "two views and few turns: less to rely on");
    CLI11_PARSE(app, argc, argv);
    Run run{{5, 31, 2}};
    if (is_quick) run = {{3, 9, 0.2}, 2, true};
    try {
        measure(run);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "coverage_peers: %s\n", error.what());
        return 1;
    }
}
