// What a selection holds, drawn, is what a frame draws.
#include "farfield/frame/selection.hpp"

#include <algorithm>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/measured_time.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/instance.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "scenes/renderers/coverage_tilers.hpp"
#include "support/pictures.hpp"
#include "support/recorder.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

using Cubes = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
using LawfulCubes = SpatialHierarchy<Octree, ColorCube, MeasuredTime>;
using SharedCubes = SpatialHierarchy<SharedOctree, ColorCube, TriangleCount>;
using ExactOctree = SpatialHierarchy<Octree, Exact, TriangleCount>;

/// A triangle, or an instance of a hierarchy over things.
struct Thing {
    std::variant<Triangle, Instance<Cubes, Thing>> is;

    BoxD bounds() const {
        if (const auto* instance = std::get_if<1>(&is)) return instance->bounds();
        const Box b = std::get<0>(is).bounds();
        return {glm::dvec3(b.lower), glm::dvec3(b.upper)};
    }
    Work work() const {
        const auto* instance = std::get_if<1>(&is);
        return instance ? instance->work() : Work{.triangles = 1};
    }
    template <class Sink>
    void polygons(Sink&& sink) const {
        std::visit([&](const auto& o) { o.polygons(sink); }, is);
    }
    template <class F>
    bool visit_instance(F&& f) const {
        const auto* instance = std::get_if<1>(&is);
        return instance && instance->visit_instance(f);
    }
};

/// Instances of one shape, some in front of others, among triangles.
struct World {
    std::vector<Thing> inner_things, things;
    Cubes inner, outer;

    World() {
        for (const Triangle& t : random_triangles(3000, 720, 0.05f)) inner_things.push_back({t});
        inner = build<Cubes>(inner_things);
        Random random(721);
        for (int i = 0; i < 12; ++i) {
            const float scale = random.between(0.2f, 0.6f);
            const Similarity at(glm::mat3(1.0f), scale, glm::dvec3(random.in_cube(2)));
            things.push_back({Instance<Cubes, Thing>{&inner, inner_things, at}});
        }
        for (const Triangle& t : random_triangles(2000, 722, 0.05f)) things.push_back({t});
        outer = build<Cubes>(things);
    }
};

std::vector<View> views(int size) {
    std::vector<View> out;
    for (const float tolerance : {0.0f, 1.5f, 6.0f, 40.0f}) {
        out.push_back(looking({7, 2, 5}, {}, size, tolerance));
        out.push_back(looking({0.5, 0.4, 1.5}, {-1, 0, 0.2}, size, tolerance));
        out.push_back(looking_orthographic({5, 2, 3}, {}, 4, size, tolerance));
    }
    return out;
}

bool same(const Recording& a, const Recording& b) {
    const auto draws = [](const Recording::Draw& x, const Recording::Draw& y) {
        return x.source == y.source && x.primitive == y.primitive && x.eye == y.eye &&
               x.faces_before == y.faces_before && x.splats_before == y.splats_before && x.law == y.law &&
               x.position == y.position;
    };
    const auto faces = [](const Face& x, const Face& y) {
        return x.lower == y.lower && x.upper == y.upper && x.rgba == y.rgba && x.side == y.side;
    };
    const auto splats = [](const Splat& x, const Splat& y) {
        return x.center == y.center && x.size == y.size && x.opacity == y.opacity && x.rgb == y.rgb;
    };
    return std::equal(a.draws.begin(), a.draws.end(), b.draws.begin(), b.draws.end(), draws) &&
           std::equal(a.faces.begin(), a.faces.end(), b.faces.begin(), b.faces.end(), faces) &&
           std::equal(a.splats.begin(), a.splats.end(), b.splats.begin(), b.splats.end(), splats) &&
           a.views.size() == b.views.size() && a.ranges == b.ranges;
}

/// What is said to be drawn; of cells, what was asked on the way does not count.
bool same_counts(const FrameStats& a, const FrameStats& b) {
    return a.primitives == b.primitives && a.runs == b.runs && a.approximations == b.approximations &&
           a.faces == b.faces && a.splats == b.splats && a.instances == b.instances &&
           std::equal(std::begin(a.approximations_by_level), std::end(a.approximations_by_level),
                      std::begin(b.approximations_by_level));
}

/// Runs may have laws. Selected is what suits a renderer that deposits: where one does not, for once, culling may have
/// been finer than it would have been for it.
constexpr bool lawful = true;

template <class R, class H, class P>
void check_drawn(const H& h, const std::vector<P>& primitives, bool has_laws = false) {
    R at_once, later, other;
    auto viewer = make_viewer(h, primitives, at_once);
    auto drawing = make_viewer(h, primitives, later);
    Selection<H, P> selection;
    for (const float splat : {0.0f, 3.0f}) {
        at_once.largest_splat = later.largest_splat = splat;
        for (const bool deposits : {false, true}) {
            at_once.deposits = later.deposits = deposits;
            for (const View& view : views(160)) {
                at_once.clear();
                later.clear();
                const FrameStats stats = viewer.frame(view);
                drawing.select(view, selection);
                CHECK(later.frames == 0);
                const FrameStats drawn = drawing.draw(selection);
                INFO("tolerance " << view.tolerance_px << ", splats to " << splat);
                if (has_laws && !deposits) {
                    CHECK(later.draws.size() <= at_once.draws.size());
                    CHECK(at_once.splats.size() == later.splats.size());
                    for (const auto& draw : later.draws) CHECK_FALSE(draw.law);
                    continue;
                }
                CHECK(same(at_once, later));
                CHECK(same_counts(stats, drawn));
                CHECK(selection.stats().approximations == stats.approximations);
                CHECK(selection.stats().cells_visited == stats.cells_visited);
                // Again, and selected by another viewer.
                later.clear();
                drawing.draw(viewer.select(view));
                CHECK(same(at_once, later));
            }
        }
    }
}

template <class R, class H, class P>
void check_pictures(const H& h, const std::vector<P>& primitives) {
    R at_once, later;
    auto viewer = make_viewer(h, primitives, at_once);
    auto drawing = make_viewer(h, primitives, later);
    for (const View& view : views(120)) {
        viewer.frame(view);
        drawing.draw(drawing.select(view));
        INFO("tolerance " << view.tolerance_px);
        CHECK(at_once.image() == later.image());
    }
}

}  // namespace

TEST_CASE("what is selected and drawn is what a frame draws") {
    const Triangles triangles = mixed_triangles(5000, 723);
    check_drawn<Recorder>(build<Cubes>(triangles), triangles);
    check_drawn<Recorder>(build<SharedCubes>(triangles), triangles);
    check_drawn<Recorder>(build<ExactOctree>(triangles), triangles);
    check_drawn<Recorder>(build<LawfulCubes>(triangles, {.approximation = {.guesses_area_law = true}}), triangles,
                          lawful);
    check_drawn<BackToFrontRecorder>(build<Cubes>(triangles), triangles);
    check_drawn<BackToFrontRecorder>(build<ExactOctree>(triangles), triangles);
}

TEST_CASE("instances that are selected and drawn are those that a frame draws") {
    const World world;
    check_drawn<Recorder>(world.outer, world.things);
    check_drawn<BackToFrontRecorder>(world.outer, world.things);
}

TEST_CASE("a selection's picture is a frame's") {
    const Triangles triangles = mixed_triangles(3000, 724);
    const World world;
    const Cubes cubes = build<Cubes>(triangles);
    check_pictures<ZBufferRenderer>(cubes, triangles);
    check_pictures<CoverageRenderer>(cubes, triangles);
    check_pictures<ZBufferRenderer>(build<SharedCubes>(triangles), triangles);
    check_pictures<ZBufferRenderer>(world.outer, world.things);
    check_pictures<CoverageRenderer>(world.outer, world.things);
}

TEST_CASE("entries come in order, each in its view, and those of an instance after it") {
    const World world;
    Recorder recorder;
    auto viewer = make_viewer(world.outer, world.things, recorder);
    std::size_t runs = 0, stand_ins = 0, instances = 0;
    for (const View& view : views(160)) {
        const auto selection = viewer.select(view);
        CHECK(selection.hierarchy() == &world.outer);
        CHECK(selection.primitives().data() == world.things.data());
        CHECK(selection.view().tolerance_px == view.tolerance_px);
        CHECK(selection.order() == VisitOrder::front_to_back);
        const auto entries = selection.entries();
        REQUIRE(selection.views().size() == 1 + selection.stats().instances);
        std::uint32_t next_view = 1;
        std::vector<std::pair<std::uint32_t, std::uint32_t>> open{{0, std::uint32_t(entries.size())}};  // view, end
        for (std::uint32_t i = 0; i < entries.size(); ++i) {
            const Selected& s = entries[i];
            while (i == open.back().second) open.pop_back();
            if (s.kind == Selected::Kind::instance) {
                ++instances;
                CHECK(s.view == next_view++);
                CHECK(world.outer.order().size() > s.first);
                REQUIRE((s.end > i && s.end <= open.back().second));
                open.emplace_back(s.view, s.end);
                continue;
            }
            CHECK(s.view == open.back().first);
            const Cubes& h = s.view == 0 ? world.outer : world.inner;
            if (s.kind == Selected::Kind::run) {
                ++runs;
                CHECK(s.first < s.end);
                CHECK(h.nodes()[s.subtree.node].first_item <= s.first);
                CHECK(s.end <= s.subtree.end_item);
            } else {
                ++stand_ins;
                CHECK(s.subtree.stand_in < h.stand_ins().size());
                CHECK(h.approximation_policy().error_px({}, s.subtree.cell, selection.views()[s.view]) <=
                      view.tolerance_px * 2);
            }
        }
        // Visited with what they belong to.
        std::size_t at = 0, of_instances = 0;
        selection.for_each([&](const auto& entered, const Selected& s) {
            CHECK(&s == &entries[at++]);
            const bool is_outer = &entered.hierarchy == &world.outer;
            CHECK(is_outer == (entered.path == 0));
            if (s.kind != Selected::Kind::instance) {
                CHECK(&entered.view == &selection.views()[s.view]);
                of_instances += !is_outer;
            }
        });
        CHECK(at == entries.size());
    }
    CHECK((runs > 100 && stand_ins > 100 && instances > 20));
}

TEST_CASE("a selection costs what is drawn, and the cells that were visited") {
    const World world;
    const Triangles triangles = mixed_triangles(4000, 725);
    const LawfulCubes timed = build<LawfulCubes>(triangles);
    Recorder recorder;
    auto viewer = make_viewer(world.outer, world.things, recorder);
    auto flat = make_viewer(timed, triangles, recorder);
    for (const View& view : views(160)) {
        const auto check = [&](const auto& selection, const FrameStats& drawn) {
            std::size_t runs = 0, primitives = 0, stand_ins = 0;
            for (const Selected& s : selection.entries()) {
                if (s.kind == Selected::Kind::run) ++runs, primitives += s.end - s.first;
                stand_ins += s.kind == Selected::Kind::stand_in;
            }
            CHECK(primitives == drawn.primitives);
            CHECK(stand_ins == drawn.approximations);
            const Work expected{.triangles = float(primitives),
                                .splats = float(stand_ins),
                                .cells = float(selection.stats().cells_visited),
                                .runs = float(runs)};
            const Work work = selection.work();
            CHECK(work.triangles == expected.triangles);
            CHECK(work.splats == expected.splats);
            CHECK(work.cells == expected.cells);
            CHECK(work.runs == expected.runs);
            CHECK((work.faces == 0 && work.images == 0 && work.texels == 0));
            CHECK(selection.cost() == Approx(selection.hierarchy()->cost_policy().cost(expected)));
        };
        const auto selection = viewer.select(view);
        check(selection, viewer.draw(selection));
        const auto of_triangles = flat.select(view);
        check(of_triangles, flat.draw(of_triangles));
    }
}

TEST_CASE("memory of a selection is used again, and nothing of the last one is left") {
    const World world;
    Recorder recorder, expected;
    auto viewer = make_viewer(world.outer, world.things, recorder);
    auto fresh = make_viewer(world.outer, world.things, expected);
    Selection<Cubes, Thing> selection;
    for (const View& view : {looking({7, 2, 5}, {}, 160, 0), looking({70, 2, 5}, {}, 160, 6),
                             looking({7, 2, 5}, {20, 0, 0}, 160, 6), looking({0.1, 0.2, 0.3}, {}, 160, 2)}) {
        recorder.clear();
        expected.clear();
        viewer.select(view, selection);
        viewer.draw(selection);
        fresh.frame(view);
        CHECK(same(recorder, expected));
    }
}

TEST_CASE("stand-ins are drawn in the color that they are given, as opaque as they are") {
    const Triangles triangles = mixed_triangles(4000, 726);
    const Cubes h = build<Cubes>(triangles);
    Recorder plain, tinted;
    auto viewer = make_viewer(h, triangles, plain);
    auto other = make_viewer(h, triangles, tinted);
    for (const float splat : {0.0f, 5.0f}) {
        plain.clear();
        tinted.clear();
        plain.largest_splat = tinted.largest_splat = splat;
        const auto selection = viewer.select(looking({7, 2, 5}, {}, 256, 8));
        viewer.draw(selection);
        std::size_t asked = 0;
        other.draw(selection, [&](const Subtree& s) {
            ++asked;
            CHECK(s.has_stand_in());
            return Rgba8{250, std::uint8_t(s.cell.depth), 100, 255};
        });
        CHECK(asked >= selection.stats().approximations);
        CHECK(plain.draws.size() == tinted.draws.size());
        REQUIRE(plain.faces.size() == tinted.faces.size());
        REQUIRE(plain.splats.size() == tinted.splats.size());
        CHECK(plain.faces.size() + plain.splats.size() > 50);
        for (std::size_t i = 0; i < plain.faces.size(); ++i) {
            const Face &p = plain.faces[i], &t = tinted.faces[i];
            CHECK((p.lower == t.lower && p.upper == t.upper && p.side == t.side && p.rgba.a == t.rgba.a));
            CHECK(std::abs(int(t.rgba.r) - 250 * p.rgba.a / 255) <= 1);
            CHECK(std::abs(int(t.rgba.b) - 100 * p.rgba.a / 255) <= 1);
        }
        for (std::size_t i = 0; i < plain.splats.size(); ++i) {
            const Splat &p = plain.splats[i], &t = tinted.splats[i];
            CHECK((p.center == t.center && p.size == t.size && p.opacity == t.opacity && p.rgb.a == t.rgb.a));
            CHECK((t.rgb.r == 250 && t.rgb.b == 100));
        }
    }
}

TEST_CASE("a selection of another hierarchy, of other primitives or in another order is refused") {
    const Triangles triangles = mixed_triangles(500, 727), copy = triangles;
    const ExactOctree h = build<ExactOctree>(triangles), twin = build<ExactOctree>(triangles);
    const View view = looking({7, 2, 5});
    Recorder recorder;
    BackToFrontRecorder reversed;
    auto viewer = make_viewer(h, triangles, recorder);
    auto of_twin = make_viewer(twin, triangles, recorder);
    auto of_copy = make_viewer(h, copy, recorder);
    auto back_to_front = make_viewer(h, triangles, reversed);
    const auto selection = viewer.select(view);
    CHECK(selection.order() == VisitOrder::any);
    CHECK_NOTHROW(viewer.draw(selection));
    CHECK_THROWS_AS(of_twin.draw(selection), std::invalid_argument);
    CHECK_THROWS_AS(of_copy.draw(selection), std::invalid_argument);
    CHECK_THROWS_AS(back_to_front.draw(selection), std::invalid_argument);
    // One that has an order may be drawn by who wants none.
    const auto ordered = back_to_front.select(view);
    CHECK(ordered.order() == VisitOrder::back_to_front);
    CHECK_NOTHROW(viewer.draw(ordered));
    // And one that never selected anything by nobody.
    const Selection<ExactOctree, Triangle> empty;
    CHECK_THROWS_AS(viewer.draw(empty), std::invalid_argument);
    CHECK(empty.cost() == 0);
    empty.for_each([](const auto&, const Selected&) { FAIL("an entry of nothing"); });
}

TEST_CASE("of nothing, nothing is selected") {
    const Triangles nothing;
    const Cubes h = build<Cubes>(nothing);
    Recorder recorder;
    auto viewer = make_viewer(h, nothing, recorder);
    const auto selection = viewer.select(looking({7, 2, 5}));
    CHECK(selection.entries().empty());
    CHECK(selection.cost() == 0);
    viewer.draw(selection);
    CHECK(recorder.draws.empty());
}
