// What coverage masks and the z-buffer must reach: a line of figures for each mark. 512 x 512 pixels, one core; "64"
// and "1" are samples a pixel. All that a row compares is drawn in turns in one run; a row is the median over its
// views, and the worst one.
//
// The yardstick is the peer (peers/plain_z_buffer.hpp), compiled for this processor, which gets the same triangles as
// the z-buffer, of one color each: those of cells in the frustum, from the same octree. "all" gets every triangle,
// "portable" is compiled for any processor. Of a row "ours, other" a speed-up is other / ours, wanted to be at least so
// much, and a share is ours / other, wanted to be at most so much.
//
//   cube      192 squares, sorted, in both forms (scenes/square_cube.hpp)
//   inside    an office of a million triangles from rooms and corridors
//   outside   the same without exterior walls, from around it
//   forest    a million triangles from among the trees
//   near      the same forest, from beside it
//   far       six times as far
//   floors    408 floors that are one, from inside a room
#include <algorithm>
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "farfield/build.hpp"
#include "farfield/partition/nested.hpp"
#include "farfield/partition/polygon_bsp.hpp"
#include "farfield/renderer/coverage_renderer.hpp"
#include "farfield/renderer/hierarchical_z_renderer.hpp"
#include "farfield/renderer/painter_renderer.hpp"
#include "peers/plain_renderer.hpp"
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

std::vector<double> cells_a_pixel(const std::vector<View>& views, Drawer& masks) {
    std::vector<double> result;
    for (const View& view : views) {
        masks.frame(view);
        const CoverageWork work = masks.work();
        result.push_back(double(work.cells_tiled + work.cells_asked) / (double(view.width) * view.height));
    }
    return result;
}

/// Pixels of a hundred that two pictures have differently: by more than what one sample is worth.
std::vector<double> percent_of_pixels_apart(const std::vector<View>& views, Drawer& one, Drawer& other, int samples) {
    std::vector<double> result;
    for (const View& view : views) {
        one.frame(view);
        other.frame(view);
        const auto a = one.image().pixels(), b = other.image().pixels();
        std::size_t apart = 0;
        for (std::size_t i = 0; i < a.size(); ++i) {
            const int most = 256 / samples;
            const auto differ = [&](std::uint8_t p, std::uint8_t q) { return std::abs(int(p) - int(q)) >= most; };
            apart += samples == 1 ? a[i] != b[i]
                                  : differ(a[i].r, b[i].r) || differ(a[i].g, b[i].g) || differ(a[i].b, b[i].b) ||
                                        differ(a[i].a, b[i].a);
        }
        result.push_back(100 * double(apart) / double(a.size()));
    }
    return result;
}

/// A hierarchy of BSPs, and the rows that say what it takes to build one.
template <class H>
H built(const std::string& what, const std::vector<VertexColoredTriangle>& triangles) {
    H hierarchy;
    const std::clock_t start = std::clock();
    hierarchy = build<H>(triangles);
    const double taken = double(std::clock() - start) / CLOCKS_PER_SEC, count = double(triangles.size());
    Table::add_figure(what + ": built, M triangles/s", {1e-6 * count / taken}, Wanted::at_least(1));
    Table::add_figure(what + ": bytes a triangle", {double(hierarchy.bytes()) / count});
    Table::add_figure(what + ": pieces a triangle", {double(hierarchy.item_count()) / count});
    return hierarchy;
}

// ---- what every scene is measured by

/// What has to be reached; 0: nothing.
struct Marks {
    double z_buffer = 1;          ///< share of the peer's time, at 1 and 64 samples
    double strict = 0, lazy = 0;  ///< speed-ups over the peer
    double hierarchical_z = 0;    ///< share, of strict masks at 64 samples
};

Wanted at_least_if_any(double mark) {
    return mark > 0 ? Wanted::at_least(mark) : Wanted{};
}
Wanted at_most_if_any(double mark) {
    return mark > 0 ? Wanted::at_most(mark) : Wanted::share();
}

/// Z-buffers and lazy masks over a plain octree.
void add_drawers(const Run& run, Race& race, const Built<ExactHierarchy>& octree) {
    const auto& [hierarchy, primitives] = std::tie(octree.hierarchy, octree.primitives);
    for (const auto& [samples, text] : {std::pair{1, std::string(" 1")}, {64, std::string(" 64")}}) {
        race.add("peer" + text, drawer<PlainRenderer>(hierarchy, primitives, PlainOptions{samples}));
        race.add("z-buffer" + text, drawer<ZBufferRenderer>(hierarchy, primitives, ZBufferOptions{.samples = samples}));
        if (run.is_quick) continue;
        race.add("portable peer" + text, drawer<PlainRenderer>(hierarchy, primitives, PlainOptions{samples, false}));
        race.add("peer of all" + text, list_drawer<PlainRenderer>(primitives, PlainOptions{samples}));
    }
    race.add("lazy over octree 64", drawer<CoverageRenderer>(hierarchy, primitives, CoverageOptions{}));
}

/// Masks over BSPs, whose order is strict, and hierarchical z over the same.
template <class H>
void add_drawers_in_order(Race& race, const H& hierarchy, const std::vector<VertexColoredTriangle>& triangles) {
    race.add("masks 64", drawer<StrictCoverageRenderer>(hierarchy, triangles, CoverageOptions{}));
    race.add("lazy 64", drawer<CoverageRenderer>(hierarchy, triangles, CoverageOptions{}));
    race.add("hierarchical z 1", drawer<HierarchicalZRenderer>(hierarchy, triangles, ZBufferOptions{}));
}

void add_rows(const Run& run, const Race& race, const Marks& marks) {
    race.row("z-buffer 1", "peer 1", Wanted::at_most(marks.z_buffer));
    race.row("z-buffer 64", "peer 64", Wanted::at_most(marks.z_buffer));
    race.row("lazy over octree 64", "peer 64", at_least_if_any(marks.lazy));
    if (run.is_quick) return;
    race.row("peer 1", "portable peer 1", Wanted::share());
    race.row("peer 64", "portable peer 64", Wanted::share());
    race.row("peer 1", "peer of all 1", Wanted::share());
    race.row("peer 64", "peer of all 64", Wanted::share());
}

void add_rows_in_order(const Race& race, const Marks& marks) {
    race.row("masks 64", "peer 64", at_least_if_any(marks.strict));
    race.row("lazy 64", "masks 64", Wanted::at_most(1.2));
    race.row("lazy over octree 64", "lazy 64", Wanted::share());
    race.row("masks 64", "hierarchical z 1", at_most_if_any(marks.hierarchical_z));
}

void add_pixels(Race& race, const std::string& name, const std::vector<View>& views) {
    for (const auto& [samples, text] : {std::pair{1, std::string(" 1")}, {64, std::string(" 64")}}) {
        Table::add_figure(name + ": % of pixels that differ, z-buffer" + text + ", peer" + text,
                          percent_of_pixels_apart(views, race["z-buffer" + text], race["peer" + text], samples),
                          Wanted::at_most(0.1));
    }
}

/// The triangles keep their order for BSPs; an octree sorts a copy.
template <class H>
void measure(const Run& run, const std::string& name, const std::vector<View>& views,
             const std::vector<VertexColoredTriangle>& triangles, const H* in_order, const Marks& marks) {
    const Built<ExactHierarchy> octree(triangles);
    Race race(run, name);
    add_drawers(run, race, octree);
    if (in_order) add_drawers_in_order(race, *in_order, triangles);
    race.draw(views);
    add_rows(run, race, marks);
    if (in_order) {
        add_rows_in_order(race, marks);
        Table::add_figure(name + ": cells visited a pixel", cells_a_pixel(views, race["masks 64"]));
    }
    add_pixels(race, name, views);
}

// ---- cube

/// From where the order of its squares holds: beyond it on all three axes.
std::vector<View> cube_views(const scenes::SquareCubeOptions& options) {
    std::vector<View> views{office_view(scenes::square_cube_camera(options))};
    for (int i = 0; i < 19; ++i) {
        const double turn = (15 + 60.0 / 18 * i) * 3.14159265358979 / 180, rise = 0.7 + 0.1 * (i % 5);
        const double distance = (2.2 + 0.2 * (i % 3)) * double(options.side_m);
        const glm::dvec3 towards = glm::normalize(glm::dvec3(std::cos(turn), rise, std::sin(turn)));
        views.push_back(office_view(Camera::perspective(towards * distance, glm::dvec3(0), {0, 1, 0}, 1.04719755f)));
    }
    return views;
}

void cube(const Run& run) {
    for (const auto& [form, name] : {std::pair{scenes::SquareCubeForm::faces, std::string("cube, three faces")},
                                     {scenes::SquareCubeForm::cubes, std::string("cube of 64 cubes")}}) {
        const scenes::SquareCubeOptions options{.form = form};
        const scenes::Scene scene = scenes::square_cube(options);
        const auto& triangles = scene.groups.back().triangles;
        const std::vector<Quadrilateral> sorted = quadrilaterals_of(triangles);
        const std::vector<Quadrilateral> reversed(sorted.rbegin(), sorted.rend());
        const std::vector<View> views = run.some(cube_views(options));

        const Built<ExactHierarchy> octree(triangles);
        Race race(run, name);
        add_drawers(run, race, octree);
        const Drawer& masks = race.add("masks 64", list_drawer<StrictCoverageRenderer>(sorted, CoverageOptions{}));
        race.add("lazy 64", list_drawer<CoverageRenderer>(sorted, CoverageOptions{}));
        race.add("scalar masks 64", list_drawer<StrictCoverageRenderer>(sorted, CoverageOptions{.simd = Simd::scalar}));
        race.add("masks 1", list_drawer<BasicCoverageRenderer<StrictPoints>>(sorted, CoverageOptions{}));
        race.add("painter 1", list_drawer<PainterRenderer>(reversed, PainterOptions{}));
        race.add("painter 64", list_drawer<PainterRenderer>(reversed, PainterOptions{.samples = 64}));
        race.draw(views);
        const Marks marks{.strict = 110, .lazy = 90};
        add_rows(run, race, marks);
        race.row("masks 64", "peer 64", Wanted::at_least(marks.strict));
        race.row("scalar masks 64", "peer 64");
        race.row("lazy 64", "masks 64", Wanted::at_most(1.2));
        race.row("lazy over octree 64", "lazy 64", Wanted::share());
        race.row("masks 1", "painter 1", Wanted::at_least(1.5));
        race.row("masks 64", "painter 64");
        Table::add_figure(name + ": cells visited a pixel", cells_a_pixel(views, race["masks 64"]),
                          Wanted::at_most(0.11));
        const double samples = 64.0 * views[0].width * views[0].height;
        Table::add_figure(name + ": bits of the pyramid a sample", {8 * double(masks.pyramid_bytes()) / samples},
                          {Wanted::Kind::equal, 1 + 2.0 / 63});
        add_pixels(race, name, views);
    }
}

// ---- building

void inside(const Run& run) {
    const OfficePlan plan;
    const std::vector<View> views = run.some(plan.inside());
    const auto triangles = in_flat_colors(scenes::expanded(scenes::building(plan.options)).groups.back().triangles);
    const auto hierarchy = built<OctreeOfBsps>("inside, octree of BSPs", triangles);
    measure(run, "inside", views, triangles, &hierarchy, {.strict = 1500, .lazy = 750, .hierarchical_z = 0.4});
    if (run.is_quick) return;
    const auto masks = drawer<StrictCoverageRenderer>(hierarchy, triangles, CoverageOptions{});
    // Whoever has left out by hand all rooms that cannot be seen.
    SeenRooms rooms(triangles, plan);
    std::vector<PairTimes> pairs;
    std::vector<double> kept;
    for (const View& view : views) {
        const Built<ExactHierarchy> seen(rooms.triangles(triangles, view));
        kept.push_back(double(seen.primitives.size()));
        const auto peer = drawer<PlainRenderer>(seen.hierarchy, seen.primitives, PlainOptions{64});
        pairs.push_back(run.pair(view, *masks, *peer));
    }
    Table::add("inside: masks 64, peer 64 of seen rooms", pairs);
    Table::add_figure("inside: triangles in seen rooms", kept);
    const auto one = built<OneBsp>("inside, one BSP", triangles);
    const auto masks_of_one = drawer<StrictCoverageRenderer>(one, triangles, CoverageOptions{});
    Table::add("inside: octree of BSPs, one BSP", run.pairs(views, *masks, *masks_of_one));
}

void outside(const Run& run) {
    OfficePlan plan;
    plan.options.exterior_walls = false;
    const std::vector<View> views = run.some(plan.outside());
    const auto triangles = in_flat_colors(scenes::expanded(scenes::building(plan.options)).groups.back().triangles);
    const auto hierarchy = built<OctreeOfBsps>("outside, octree of BSPs", triangles);
    measure(run, "outside", views, triangles, &hierarchy, {.strict = 9, .lazy = 7, .hierarchical_z = 1.0});
    if (run.is_quick) return;
    const auto one = built<OneBsp>("outside, one BSP", triangles);
    const auto masks = drawer<StrictCoverageRenderer>(hierarchy, triangles, CoverageOptions{});
    const auto masks_of_one = drawer<StrictCoverageRenderer>(one, triangles, CoverageOptions{});
    Table::add("outside: octree of BSPs, one BSP", run.pairs(views, *masks, *masks_of_one));
}

// ---- forest

/// At the height of a person's eyes; the first is that of bench_renderer.
std::vector<View> among_trees(const Box& bounds) {
    std::vector<View> views;
    for (int i = 0; i < 20; ++i) {
        // Along a circle within the forest, every other one looking across it and the rest outwards.
        const double angle = (225 + 18.0 * i) * 3.14159265358979 / 180,
                     ahead = angle + (i % 2 ? 0.6 : 3.14159265358979);
        const glm::dvec2 from = 0.5 + 0.49 * glm::dvec2(std::cos(angle), std::sin(angle)) * (i % 3 == 2 ? 0.5 : 1.0);
        const glm::dvec2 to = from + 0.5 * glm::dvec2(std::cos(ahead), std::sin(ahead));
        const auto at = [&](glm::dvec2 p, double height) {
            return glm::dvec3(bounds.lower) +
                   glm::dvec3(p.x * double(bounds.size().x), height, p.y * double(bounds.size().z));
        };
        views.push_back(at_eye_level(at(from, 1.7), at(to, i == 0 ? double(bounds.size().y) / 2 : 3.0)));
    }
    return views;
}

/// All of it in view from `times` as far as that takes.
std::vector<View> beside_trees(const Box& bounds, double times) {
    std::vector<View> views;
    const glm::dvec3 center(bounds.center());
    for (int i = 0; i < 20; ++i) {
        const double angle = 18.0 * i * 3.14159265358979 / 180;
        const glm::dvec3 towards(std::sin(angle), 0.1 + 0.1 * (i % 4), std::cos(angle));
        const double distance = 0.75 * times * double(length_of(bounds.size()));
        views.push_back(at_eye_level(center + glm::normalize(towards) * distance, center));
    }
    return views;
}

void forest(const Run& run, const std::string& name, std::vector<View> (*views_of)(const Box&), const Marks& marks) {
    const auto triangles = in_flat_colors(triangles_of("forest"));
    Box bounds = Box::empty();
    for (const VertexColoredTriangle& t : triangles) bounds.add(t.bounds());
    const std::vector<View> views = run.some(views_of(bounds));
    if (run.is_quick) {
        Table::remark(name + ": --quick leaves out the BSP trees, which take a minute to build");
        return measure<OctreeOfBsps>(run, name, views, triangles, nullptr, marks);
    }
    const auto hierarchy = built<OctreeOfBsps>(name + ", octree of BSPs", triangles);
    if (!hierarchy.keeps_strict_order()) {
        Table::remark(name + ": " + std::to_string(hierarchy.report().cells_out_of_order) +
                      " cells are out of order, no strict masks");
        return measure<OctreeOfBsps>(run, name, views, triangles, nullptr, marks);
    }
    measure(run, name, views, triangles, &hierarchy, marks);
}

void among(const Run& run) {
    forest(run, "forest", among_trees, {.z_buffer = 0.7, .lazy = 3});
}
void near_forest(const Run& run) {
    forest(run, "near", [](const Box& bounds) { return beside_trees(bounds, 1); }, {.z_buffer = 0.7, .lazy = 3});
}
void far_forest(const Run& run) {
    forest(run, "far", [](const Box& bounds) { return beside_trees(bounds, 6); }, {.z_buffer = 0.7, .lazy = 1.2});
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
    {"cube", cube},        {"inside", inside},  {"outside", outside}, {"forest", among},
    {"near", near_forest}, {"far", far_forest}, {"floors", floors}};

}  // namespace
}  // namespace farfield::bench

int main(int argc, char** argv) {
    using namespace farfield::bench;
    CLI::App app("Coverage masks against z-buffers and painters: what they must reach, and what they do.", "coverage");
    std::vector<std::string> names, known;
    bool is_quick = false;
    for (const auto& part : parts) known.push_back(part.first);
    app.add_option("PART,--only", names, "what to measure; all by default")->check(CLI::IsMember(known));
    app.add_flag("--quick", is_quick, "two views a row and few turns: less to rely on");
    CLI11_PARSE(app, argc, argv);
    Run run{{5, 61, 1.0}, 20, false};
    if (is_quick) run = {{3, 5, 0.2}, 2, true};
    Table::header();
    for (const auto& [name, measure] : parts) {
        if (names.empty() || std::find(names.begin(), names.end(), name) != names.end()) measure(run);
    }
}
