// What coverage masks must reach: a line of figures for each mark. 512 x 512 pixels, one core; "64" and "1" are samples
// a pixel. Both sides of a pair are drawn in turns in one run; a row is the median over its views, and the worst one.
//
// `ours` is a CoverageRenderer, strict where nothing else is said, and `other` what it is compared with: a speed-up is
// other / ours, wanted to be at least so much, a share is ours / other, wanted to be at most so much.
//
//   cube      192 squares as a sorted list, without a hierarchy (scenes/square_cube.hpp), in both forms
//   inside    an office of a million triangles from rooms and corridors; the z-buffer gets only rooms that are seen
//   outside   the same without exterior walls, from around it; the z-buffer culls by the frustum
//   forest    a million triangles from among the trees
//   floors    408 floors that are one, from inside a room
#include <algorithm>
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdint>
#include <iostream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "farfield/build.hpp"
#include "farfield/partition/nested.hpp"
#include "farfield/partition/polygon_bsp.hpp"
#include "farfield/renderer/coverage_renderer.hpp"
#include "farfield/renderer/hierarchical_z_renderer.hpp"
#include "farfield/renderer/painter_renderer.hpp"
#include "scenes/generate/forest.hpp"
#include "scenes/generate/square_cube.hpp"
#include "scenes/object.hpp"
#include "support/drawer.hpp"
#include "support/office.hpp"
#include "support/pair.hpp"

namespace farfield::bench {
namespace {

using OctreeOfBsps = SpatialHierarchy<Nested<Octree, PolygonBsp>, Exact, TriangleCount>;
using OneBsp = SpatialHierarchy<PolygonBsp, Exact, TriangleCount>;
struct StrictPoints : StrictCoverage {
    using samples = SinglePixels;
};
constexpr ZBufferOptions one_sample{}, samples_64{.samples = 64};

std::vector<double> cells_a_pixel(const std::vector<View>& views, Drawer& masks) {
    std::vector<double> result;
    for (const View& view : views) {
        masks.frame(view);
        const CoverageWork work = masks.work();
        result.push_back(double(work.cells_tiled + work.cells_asked) / (double(view.width) * view.height));
    }
    return result;
}

template <class H>
H built(const char* what, const std::vector<VertexColoredTriangle>& triangles) {
    H hierarchy;
    const double taken = seconds([&] { hierarchy = build<H>(triangles); });
    Table::remark(std::string(what) + ": " + std::to_string(triangles.size()) + " triangles, " +
                  std::to_string(hierarchy.item_count()) + " items, " + std::to_string(hierarchy.bytes() >> 20) +
                  " MiB, built in " + std::to_string(taken) + " s");
    return hierarchy;
}

// ---- cube

void cube(const Run& run) {
    for (const auto& [form, name] : {std::pair{scenes::SquareCubeForm::faces, std::string("cube, three faces")},
                                     {scenes::SquareCubeForm::cubes, std::string("cube of 64 cubes")}}) {
        const scenes::SquareCubeOptions options{.form = form};
        const scenes::Scene scene = scenes::square_cube(options);
        const std::vector<Quadrilateral> sorted = quadrilaterals_of(scene.groups.back().triangles);
        const std::vector<Quadrilateral> reversed(sorted.rbegin(), sorted.rend());
        const std::vector<View> views{office_view(scenes::square_cube_camera(options))};

        const auto masks = list_drawer<StrictCoverageRenderer>(sorted, CoverageOptions{});
        const auto z_buffer = list_drawer<ZBufferRenderer>(sorted, samples_64);
        Table::add(name + ": masks 64, z-buffer 64", run.pairs(views, *masks, *z_buffer), Wanted::at_least(60));
        const auto scalar = list_drawer<StrictCoverageRenderer>(sorted, CoverageOptions{.simd = Simd::scalar});
        Table::add(name + ": scalar masks 64, z-buffer 64", run.pairs(views, *scalar, *z_buffer), Wanted::at_least(12));
        const auto points = list_drawer<BasicCoverageRenderer<StrictPoints>>(sorted, CoverageOptions{});
        const auto painter = list_drawer<PainterRenderer>(reversed, PainterOptions{});
        Table::add(name + ": masks 1, painter 1", run.pairs(views, *points, *painter), Wanted::at_least(1.5));
        const auto painter_64 = list_drawer<PainterRenderer>(reversed, PainterOptions{.samples = 64});
        Table::add(name + ": masks 64, painter 64", run.pairs(views, *masks, *painter_64));
        const auto lazy = list_drawer<CoverageRenderer>(sorted, CoverageOptions{});
        Table::add(name + ": lazy, strict", run.pairs(views, *lazy, *masks), Wanted::at_most(1.3));
        Table::add_figure(name + ": cells visited a pixel", cells_a_pixel(views, *masks), Wanted::at_most(0.11));
        const double samples = 64.0 * views[0].width * views[0].height;
        Table::add_figure(name + ": bits of the pyramid a sample", {8 * double(masks->pyramid_bytes()) / samples},
                          {Wanted::Kind::equal, 1 + 2.0 / 63});
    }
}

// ---- building

/// What inside and outside have in common.
void add_rows(const Run& run, const std::string& name, const std::vector<View>& views, const OctreeOfBsps& hierarchy,
              const std::vector<VertexColoredTriangle>& triangles, Wanted share_of_hierarchical_z) {
    const auto masks = drawer<StrictCoverageRenderer>(hierarchy, triangles, CoverageOptions{});
    const auto hierarchical_z = drawer<HierarchicalZRenderer>(hierarchy, triangles, one_sample);
    Table::add(name + ": masks 64, hierarchical z 1", run.pairs(views, *masks, *hierarchical_z),
               share_of_hierarchical_z);
    const auto lazy = drawer<CoverageRenderer>(hierarchy, triangles, CoverageOptions{});
    Table::add(name + ": lazy, strict", run.pairs(views, *lazy, *masks), Wanted::at_most(1.3));
}

void inside(const Run& run) {
    const OfficePlan plan;
    const std::vector<View> views = run.some(plan.inside());
    const auto triangles = scenes::expanded(scenes::building(plan.options)).groups.back().triangles;
    const auto hierarchy = built<OctreeOfBsps>("inside, octree of BSPs", triangles);
    const auto masks = drawer<StrictCoverageRenderer>(hierarchy, triangles, CoverageOptions{});
    {
        SeenRooms rooms(triangles, plan);
        std::vector<PairTimes> pairs;
        std::vector<double> kept;
        for (const View& view : views) {
            const Built<ExactHierarchy> seen(rooms.triangles(triangles, view));
            kept.push_back(double(seen.primitives.size()));
            const auto z_buffer = drawer<ZBufferRenderer>(seen.hierarchy, seen.primitives, samples_64);
            pairs.push_back(run.pair(view, *masks, *z_buffer));
        }
        Table::add("inside: masks 64, z-buffer 64 of seen rooms", pairs, Wanted::at_least(100));
        Table::add_figure("inside: triangles in seen rooms", kept);
    }
    Table::add_figure("inside: cells visited a pixel", cells_a_pixel(views, *masks), Wanted::at_most(0.5));
    add_rows(run, "inside", views, hierarchy, triangles, Wanted::at_most(0.4));
    const auto one = built<OneBsp>("inside, one BSP", triangles);
    const auto masks_of_one = drawer<StrictCoverageRenderer>(one, triangles, CoverageOptions{});
    Table::add("inside: octree of BSPs, one BSP", run.pairs(views, *masks, *masks_of_one));
}

void outside(const Run& run) {
    OfficePlan plan;
    plan.options.exterior_walls = false;
    const std::vector<View> views = run.some(plan.outside());
    const auto triangles = scenes::expanded(scenes::building(plan.options)).groups.back().triangles;
    const auto hierarchy = built<OctreeOfBsps>("outside, octree of BSPs", triangles);
    const auto masks = drawer<StrictCoverageRenderer>(hierarchy, triangles, CoverageOptions{});
    {
        const Built<ExactHierarchy> octree(triangles);
        const auto z_buffer = drawer<ZBufferRenderer>(octree.hierarchy, octree.primitives, samples_64);
        Table::add("outside: masks 64, z-buffer 64", run.pairs(views, *masks, *z_buffer), Wanted::at_least(12));
    }
    Table::add_figure("outside: cells visited a pixel", cells_a_pixel(views, *masks));
    add_rows(run, "outside", views, hierarchy, triangles, Wanted::at_most(1.0));
    const auto one = built<OneBsp>("outside, one BSP", triangles);
    const auto masks_of_one = drawer<StrictCoverageRenderer>(one, triangles, CoverageOptions{});
    Table::add("outside: octree of BSPs, one BSP", run.pairs(views, *masks, *masks_of_one));
}

// ---- forest

void forest(const Run& run) {
    const auto triangles = triangles_of("forest");
    const Built<ExactHierarchy> octree(triangles);
    const Box& bounds = octree.hierarchy.bounds();
    // At the height of a person's eyes; the first is that of bench_renderer.
    std::vector<View> views;
    for (const auto& [from, to] : {std::pair{glm::dvec2(0.15, 0.15), glm::dvec2(0.5, 0.5)},
                                   {glm::dvec2(0.5, 0.02), glm::dvec2(0.5, 0.6)},
                                   {glm::dvec2(0.6, 0.5), glm::dvec2(0.05, 0.3)},
                                   {glm::dvec2(0.8, 0.9), glm::dvec2(0.3, 0.2)}}) {
        const auto at = [&](glm::dvec2 p, double height) {
            return glm::dvec3(bounds.lower) +
                   glm::dvec3(p.x * double(bounds.size().x), height, p.y * double(bounds.size().z));
        };
        const double height = views.empty() ? double(bounds.center().y - bounds.lower.y) : 3.0;
        views.push_back(at_eye_level(at(from, 1.7), at(to, height)));
    }
    views = run.some(views);
    const auto z_buffer = drawer<ZBufferRenderer>(octree.hierarchy, octree.primitives, samples_64);
    const auto lazy = drawer<CoverageRenderer>(octree.hierarchy, octree.primitives, CoverageOptions{});
    Table::add("forest: lazy over an octree 64, z-buffer 64", run.pairs(views, *lazy, *z_buffer), Wanted::at_least(4));
    if (run.is_quick) return Table::remark("forest: --quick leaves out the BSP trees, which take a minute to build");
    const auto hierarchy = built<OctreeOfBsps>("forest, octree of BSPs", triangles);
    if (!hierarchy.keeps_strict_order()) {
        return Table::remark("forest: " + std::to_string(hierarchy.report().cells_out_of_order) +
                             " cells are out of order, no strict masks");
    }
    const auto strict = drawer<StrictCoverageRenderer>(hierarchy, triangles, CoverageOptions{});
    Table::add("forest: masks over an octree of BSPs 64, z-buffer 64", run.pairs(views, *strict, *z_buffer),
               Wanted::at_least(4));
    Table::add_figure("forest: cells visited a pixel", cells_a_pixel(views, *strict));
}

// ---- floors

void floors(const Run& run) {
    OfficePlan plan{scenes::building_of_408_floors()};
    scenes::Scene scene = scenes::building(plan.options);
    const scenes::Group root = std::move(scene.groups.back());
    scene.groups.pop_back();  // what is left is one floor
    const auto triangles = scenes::expanded(scene).groups.back().triangles;
    const auto floor = built<OctreeOfBsps>("floors, one of them", triangles);

    using Object = scenes::Object<OctreeOfBsps>;
    std::vector<Object> objects;
    for (const VertexColoredTriangle& t : root.triangles) objects.push_back({t});
    for (const scenes::Placement& p : root.placements) {
        objects.push_back({Object::InstanceOfTriangles{&floor, triangles, Similarity(p.to_parent)}});
    }
    const auto all = build<OctreeOfBsps>(objects);
    if (!all.keeps_strict_order()) return Table::remark("floors: out of order, no strict masks");

    // The same place in the lowest floor and, an even number of floors higher, amid all of them.
    const int middle = int(plan.options.floors) / 2 & ~1;
    const auto alone = drawer<StrictCoverageRenderer>(floor, triangles, CoverageOptions{});
    const auto among_all = drawer<StrictCoverageRenderer>(all, objects, CoverageOptions{});
    std::vector<PairTimes> pairs;
    for (View low : run.some({office_view(scenes::inside_building(plan.options)),
                              at_eye_level(plan.corner(4, middle, 3) + glm::dvec3(2.0, 1.65, 4.5),
                                           plan.corner(4, middle, 3) + glm::dvec3(2.0, 1.2, 0.0)),
                              at_eye_level(plan.corner(9, middle, 6) + glm::dvec3(2.0, 1.65, 6.25),
                                           plan.corner(9, middle, 6) + glm::dvec3(8.0, 1.5, 6.25)),
                              at_eye_level(plan.corner(12, middle, 2) + glm::dvec3(1.0, 1.65, 6.6),
                                           plan.corner(12, middle, 2) + glm::dvec3(5.0, 1.3, 3.0))})) {
        const View high = low;
        low.camera.eye.y -= 3.5 * middle;
        pairs.push_back(in_turns(
            run.patience, [&] { among_all->frame(high); }, [&] { alone->frame(low); }));
    }
    Table::add("floors: 408, one alone", pairs, Wanted::at_most(1.3));
}

const std::vector<std::pair<std::string, void (*)(const Run&)>> parts{
    {"cube", cube}, {"inside", inside}, {"outside", outside}, {"forest", forest}, {"floors", floors}};

}  // namespace
}  // namespace farfield::bench

int main(int argc, char** argv) {
    using namespace farfield::bench;
    CLI::App app("Coverage masks against z-buffers and painters: what they must reach, and what they do.", "coverage");
    std::vector<std::string> names, known;
    bool is_quick = false;
    for (const auto& part : parts) known.push_back(part.first);
    app.add_option("PART", names, "what to measure; all by default")->check(CLI::IsMember(known));
    app.add_flag("--quick", is_quick, "two views a row and few turns: less to rely on");
    CLI11_PARSE(app, argc, argv);
    Run run;
    if (is_quick) run = {{3, 9, 0.2}, 2, true};
    Table::header();
    for (const auto& [name, measure] : parts) {
        if (names.empty() || std::find(names.begin(), names.end(), name) != names.end()) measure(run);
    }
}
