#include "farfield/partition/polygon_bsp.hpp"

#include <cstring>

#include "catch.hpp"
#include "farfield/build.hpp"
#include "farfield/executor.hpp"
#include "farfield/primitive/instance.hpp"
#include "farfield/spatial_hierarchy.hpp"
#include "support/clipped.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

using Bsp = SpatialHierarchy<PolygonBsp, Exact, TriangleCount>;

template <class T>
bool same_bytes(std::span<const T> a, std::span<const T> b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}
bool same(const Bsp& a, const Bsp& b) {
    return same_bytes(a.nodes(), b.nodes()) && same_bytes(a.all_node_data(), b.all_node_data()) &&
           same_bytes(a.order(), b.order()) && same_bytes(a.fragments().first_vertex, b.fragments().first_vertex) &&
           same_bytes(a.fragments().vertices, b.fragments().vertices) &&
           same_bytes(a.fragments().colors, b.fragments().colors) &&
           std::memcmp(&a.report(), &b.report(), sizeof(BuildReport)) == 0;
}

/// A triangle, or an instance of a hierarchy of triangles.
struct Thing {
    Triangle triangle{};
    std::vector<Instance<Bsp, Triangle>> instance{};

    BoxD bounds() const {
        if (!instance.empty()) return instance[0].bounds();
        const Box b = triangle.bounds();
        return {glm::dvec3(b.lower), glm::dvec3(b.upper)};
    }
    template <class Sink>
    void polygons(Sink&& sink) const {
        if (instance.empty()) {
            triangle.polygons(sink);
        } else {
            instance[0].polygons(sink);
        }
    }
    template <class F>
    bool visit_instance(F&& f) const {
        if (!instance.empty()) f(instance[0]);
        return !instance.empty();
    }
};

/// Any number of a thing, moved.
std::vector<Thing> placed(const Bsp& h, const Triangles& triangles, const std::vector<glm::dvec3>& places) {
    std::vector<Thing> out;
    for (const glm::dvec3& place : places) {
        Similarity at;
        at.translation = place;
        out.push_back({{}, {Instance<Bsp, Triangle>{&h, triangles, at}}});
    }
    return out;
}

}  // namespace

static_assert(Partition<PolygonBsp> && CutsItems<PolygonBsp> && !PlacesItems<PolygonBsp>);
static_assert(Bsp::assignment == Assignment::clipped && Bsp::ordering == OrderGuarantee::primitives);

TEST_CASE("a BSP's polygons come in strict order from everywhere") {
    for (const ClippedScene& scene : clipped_scenes()) {
        INFO(scene.name);
        check_strict_order(build<Bsp>(scene.triangles), scene.triangles);
    }
}

TEST_CASE("a BSP's fragments have the area of what they were cut from") {
    for (const ClippedScene& scene : clipped_scenes()) {
        INFO(scene.name);
        check_fragments(build<Bsp>(scene.triangles), scene.triangles);
    }
}

TEST_CASE("a BSP's fragments cover what was cut") {
    for (const ClippedScene& scene : clipped_scenes()) {
        INFO(scene.name);
        check_pictures(build<Bsp>(scene.triangles), scene.triangles);
    }
}

TEST_CASE("any number of threads builds the same BSP") {
    for (const std::size_t count : {0u, 1u, 300u, 6000u}) {
        const Triangles triangles = mixed_triangles(count, 80);
        const Bsp serial = build<Bsp>(triangles);
        for (const unsigned threads : {1u, 2u, 3u, 8u}) {
            INFO(count << " triangles, " << threads << " threads");
            CHECK(same(serial, build<Bsp>(triangles, {.executor = ThreadExecutor(threads)})));
        }
    }
}

TEST_CASE("two triangles of one quadrilateral become one polygon") {
    const Rgba8 red{200, 0, 0, 255}, blue{0, 0, 200, 255};
    const glm::vec3 a(0, 0, 0), b(1, 0, 0), c(1, 1, 0.5f), d(0, 1, 0.5f);
    const auto report = [](const Triangles& t) { return build<Bsp>(t).report(); };
    const Triangles quadrilateral{{{a, b, c}, red}, {{a, c, d}, red}};
    const Bsp h = build<Bsp>(quadrilateral);
    REQUIRE(h.item_count() == 1);
    CHECK(h.report().polygons_joined == 1);
    CHECK(h.order()[0] == 0);
    const Polygon p = h.fragments()[0];
    REQUIRE(p.vertices.size() == 4);
    CHECK(area_of(p.vertices) == area_of(quadrilateral));
    for (const auto& [first, second] : std::vector<std::pair<std::array<glm::vec3, 3>, std::array<glm::vec3, 3>>>{
             {{a, b, c}, {c, d, a}}, {{b, c, a}, {d, a, c}}, {{c, a, b}, {a, c, d}}}) {
        CHECK(report({{first, red}, {second, red}}).polygons_joined == 1);
    }
    INFO("not of two colors, bent, with a corner that does not bulge, folded back, or with another one between");
    CHECK(report({{{a, b, c}, red}, {{a, c, d}, blue}}).polygons_joined == 0);
    CHECK(report({{{a, b, c}, red}, {{a, c, d + glm::vec3(0, 0, 0.01f)}, red}}).polygons_joined == 0);
    CHECK(report({{{a, b, c}, red}, {{a, c, 0.5f * (a + c) + (c - a)}, red}}).polygons_without_area == 1);
    CHECK(report({{{a, b, c}, red}, {{a, c, a + (a - b) + 0.0005f * (d - a)}, red}}).polygons_joined == 0);
    CHECK(report({{{a, b, c}, red}, {{a, c, b}, red}}).polygons_joined == 0);
    CHECK(report({{{a, b, c}, red}, {{b, c, c + b - a}, blue}, {{a, c, d}, red}}).polygons_joined == 0);
    INFO("four triangles of a strip are two quadrilaterals, and a vertex in between two steps away is the same plane");
    const Triangles strip = sheet({0, 0, 0}, {2, 0, 0}, {0, 1, 1}, 2, 1, red);
    CHECK(report(strip).polygons_joined == 2);
    CHECK(report(strip).items == 2);
    CHECK(report(strip).polygons == 2);
    CHECK(report(strip).pieces == 2);
}

TEST_CASE("the report counts polygons and what became of them") {
    const Rgba8 gray{128, 128, 128, 255};
    // Three squares through one another: the first plane cuts two of them, the second cuts both parts of the third.
    Triangles squares = sheet({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 1, 1, gray);
    append(squares, sheet({0, -1, -1}, {0, 2, 0}, {0, 0, 2}, 1, 1, gray));
    append(squares, sheet({-1, 0, -1}, {2, 0, 0}, {0, 0, 2}, 1, 1, gray));
    const BuildReport crossing = build<Bsp>(squares).report();
    CHECK(crossing.polygons == 3);
    CHECK(crossing.pieces == 7);
    CHECK(crossing.items == 7);
    INFO(
        "polygons that do not meet, of which each lies on both sides of the other's plane and no axis tells them "
        "apart");
    const Triangles apart{{{{{-1, -1, 0}, {1, 1, 0}, {1, 1, 0.1f}}}, gray},
                          {{{{-1, 1, 0.3f}, {1, -1, 0.1f}, {1, -1.2f, 0}}}, gray}};
    CHECK(build<Bsp>(apart).report().pieces == 2);
    const Triangles body = sphere({0, 0, 0}, 1, 8, gray);
    const Bsp inner = build<Bsp>(body);
    const BuildReport instances = build<Bsp>(placed(inner, body, {{-3, 0, 0}, {3, 0, 0}})).report();
    CHECK(instances.items == 2);
    CHECK(instances.polygons == 0);
    CHECK(instances.pieces == 0);
}

TEST_CASE("quadrilaterals of more colors are joined where these are one linear course") {
    const auto gray = [](int g) { return Rgba8{std::uint8_t(g), std::uint8_t(g), std::uint8_t(g), 255}; };
    const glm::vec3 a(0, 0, 0), b(1, 0, 0), c(1, 1, 0), d(0, 1, 0);
    for (const int last : {100, 99, 101, 60}) {
        const std::vector<VertexColoredTriangle> t{{{a, b, c}, {gray(50), gray(80), gray(130)}},
                                                   {{a, c, d}, {gray(50), gray(130), gray(last)}}};
        const Bsp h = build<Bsp>(t);
        INFO(last);
        CHECK(h.report().polygons_joined == (last == 100 ? 1 : 0));
    }
}

TEST_CASE("rectangles on a grid are cut without any error") {
    Random random(81);
    for (int round = 0; round < 20; ++round) {
        Triangles triangles;
        std::vector<double> areas;
        for (int i = 0; i < 60; ++i) {
            const int axis = int(random.below(3));
            glm::vec3 lower(0), u(0), v(0);
            for (int k = 0; k < 3; ++k) lower[k] = float(random.below(24));
            u[(axis + 1) % 3] = float(1 + random.below(9));
            v[(axis + 2) % 3] = float(1 + random.below(9));
            const Rgba8 color = random.color();
            triangles.push_back({{lower, lower + u, lower + u + v}, color});
            triangles.push_back({{lower, lower + u + v, lower + v}, color});
            areas.push_back(double(glm::length(u)) * double(glm::length(v)));
        }
        const Bsp h = build<Bsp>(triangles);
        std::vector<double> after(areas.size());
        std::size_t off_the_grid = 0;
        for (std::uint32_t at = 0; at < h.item_count(); ++at) {
            const auto vertices = h.fragments()[at].vertices;
            after[h.order()[at] / 2] += area_of(vertices);
            for (const glm::vec3& p : vertices) off_the_grid += p != glm::round(p);
        }
        CHECK(off_the_grid == 0);
        CHECK(after == areas);
        check_strict_order(h, triangles);
    }
}

TEST_CASE("neighbors that share an edge are cut in the same points of it") {
    Random random(82);
    for (int round = 0; round < 2000; ++round) {
        const auto corner = [&] {
            const glm::vec3 p = random.in_cube(1);
            return Corner{p, random.color()};
        };
        const Corner a = corner(), b = corner(), c = corner(), d = corner();
        const glm::vec3 normal = random.direction();
        const float offset = random.between(-0.5f, 0.5f);
        const Cell cell{random.in_cube(1), glm::vec3(2), glm::vec3(0), glm::vec3(2), 0, 0};
        const LocalPlane plane(CuttingPlane{normal, offset}, cell);
        const auto cut_points = [&](const std::vector<Corner>& polygon) {
            std::vector<Corner> part;
            const glm::vec3 its_normal(glm::normalize(doubled_area(polygon)));
            append_part(polygon, plane, Side::behind, its_normal, part);
            append_part(polygon, plane, Side::in_front, its_normal, part);
            return part;
        };
        const double from = plane.height_or_on(a.position), to = plane.height_or_on(b.position);
        if (!(from < 0 && to > 0) && !(from > 0 && to < 0)) continue;
        const Corner point = crossing(a, from, b, to);
        const auto is_point = [&](const Corner& p) { return p.position == point.position && p.color == point.color; };
        const auto one = cut_points({a, b, c}), other = cut_points({b, a, d});
        CHECK(std::count_if(one.begin(), one.end(), is_point) == 2);
        CHECK(std::count_if(other.begin(), other.end(), is_point) == 2);
        CHECK(std::abs(plane.height(point.position)) <= plane.tolerance());
    }
}

TEST_CASE("instances are told from one another and from polygons, whole") {
    const Triangles body = sphere({0, 0, 0}, 1, 8, {90, 90, 200, 255});
    const Bsp inner = build<Bsp>(body);
    std::vector<Thing> things =
        placed(inner, body, {{-3, 0, 0}, {0, 0, 0.5}, {3, 0.4, 0}, {0.2, 3, 0}, {0, 3, 3}, {2.6, 2, 2}});
    for (const Triangle& t : sheet({-6, -1.5f, 6}, {12, 0, 0}, {0, 0, -12}, 2, 2, {})) things.push_back({t, {}});
    for (const Triangle& t : sheet({1.4f, -1.5f, 6}, {0, 0, -12}, {0, 6, 0}, 1, 1, {})) things.push_back({t, {}});
    // Around one of them, far from it.
    for (const Triangle& t : sphere({-3, 0, 0}, 1.9f, 6, {})) things.push_back({t, {}});
    const Bsp h = build<Bsp>(things);
    CHECK(h.report().cells_out_of_order == 0);
    REQUIRE(h.keeps_strict_order());
    std::size_t whole = 0;
    for (std::uint32_t at = 0; at < h.item_count(); ++at) {
        CHECK(h.fragments()[at].vertices.empty() == !things[h.order()[at]].instance.empty());
        whole += !things[h.order()[at]].instance.empty();
    }
    CHECK(whole == 6);
    OrderRecorder recorder;
    auto viewer = make_viewer(h, std::span<const Thing>(things), recorder);
    Random random(83);
    for (int i = 0; i < 30; ++i) {
        const glm::vec3 eye = random.in_cube(i % 2 ? 3.0f : 9.0f);
        const View view = i % 3 ? looking(eye, random.in_cube(1)) : looking_orthographic(eye, random.in_cube(1), 12);
        const FrameStats stats = viewer.frame(view);
        if (i % 2 == 0 && i % 3 != 0) CHECK(stats.instances > 0);
        const OrderCheck check = check_order(recorder.polygons, i % 3 != 0, 6, 1e-6, 200, 84);
        CHECK(check.wrong == 0);
    }
}

TEST_CASE("what no plane tells from an instance is kept with it and counted, and strict renderers refuse it") {
    const Triangles body = sphere({0, 0, 0}, 1, 8, {});
    const Bsp inner = build<Bsp>(body);
    std::vector<Thing> overlapping = placed(inner, body, {{0, 0, 0}, {0.7, 0.6, 0.5}, {5, 0, 0}});
    std::vector<Thing> pierced = placed(inner, body, {{0, 0, 0}, {5, 0, 0}});
    pierced.push_back({Triangle{{{{-4, 0.1f, -4}, {4, 0.2f, -4}, {0, 0.1f, 7}}}, {}}, {}});
    const std::vector<Thing> apart = placed(inner, body, {{0, 0, 0}, {2.5, 0, 0}, {5, 0, 0}});
    OrderRecorder strict;
    ZBufferRenderer any;
    for (const auto* things : {&overlapping, &pierced}) {
        const Bsp h = build<Bsp>(*things);
        CHECK(h.report().cells_out_of_order == 1);
        CHECK(h.report().cells_that_cannot_be_told_apart == 1);
        CHECK_FALSE(h.keeps_strict_order());
        CHECK_NOTHROW(make_viewer(h, std::span<const Thing>(*things), any));
        CHECK_THROWS_AS(make_viewer(h, std::span<const Thing>(*things), strict), std::invalid_argument);
    }
    const Bsp in_order = build<Bsp>(apart);
    CHECK_NOTHROW(make_viewer(in_order, std::span<const Thing>(apart), strict));
    // An instance of what does not keep its order.
    const Bsp limited = build<Bsp>(body, {.partition = {.max_depth = 1}});
    CHECK(limited.report().cells_at_depth_limit > 0);
    CHECK_FALSE(limited.keeps_strict_order());
    const std::vector<Thing> outer = placed(limited, body, {{0, 0, 0}});
    const Bsp around = build<Bsp>(outer);
    CHECK(around.keeps_strict_order());
    CHECK_THROWS_AS(make_viewer(around, std::span<const Thing>(outer), strict), std::invalid_argument);
}

TEST_CASE("cells hold what is in them") {
    for (const ClippedScene& scene : clipped_scenes()) {
        INFO(scene.name);
        const Bsp h = build<Bsp>(scene.triangles);
        std::size_t outside = 0;
        const auto visit = [&](const auto& self, std::uint32_t index, const Cell& cell, std::uint32_t end) -> void {
            const Node& node = h.nodes()[index];
            for (std::uint32_t at = node.first_item; at < end; ++at) {
                for (const glm::vec3& v : h.fragments()[at].vertices) outside += !cell.bounds().contains(v);
            }
            std::uint32_t child = node.first_child;
            for (unsigned mask = node.child_mask; mask != 0; mask &= mask - 1, ++child) {
                const Cell its = h.partition_policy().child(cell, h.data_of(index), unsigned(std::countr_zero(mask)));
                self(self, child, its, (mask & (mask - 1)) != 0 ? h.nodes()[child + 1].first_item : end);
            }
        };
        visit(visit, 0, h.root_cell(), h.item_count());
        CHECK(outside == 0);
    }
}

TEST_CASE("a cell of what lies on a plane is done with, even if rounding took it off that plane") {
    const PolygonBsp bsp;
    const Cell root = bsp.root({glm::vec3(-1), glm::vec3(1)});
    // Two pieces that no plane of either has both on it.
    const std::vector<Corner> corners{{{-1, -1, 0}, {}}, {{1, -1, 0}, {}}, {{0, 1, 0}, {}},
                                      {{-1, -1, 1}, {}}, {{1, -1, 1}, {}}, {{0, 1, 0.9f}, {}}};
    std::vector<SupportingPlane> planes;
    std::vector<ClippedItem> items;
    for (std::uint32_t i = 0; i < 2; ++i) {
        const std::span<const Corner> polygon = std::span(corners).subspan(3 * i, 3);
        const glm::vec3 normal(glm::normalize(doubled_area(polygon)));
        planes.push_back({normal, double(glm::dot(normal, polygon[0].position))});
        Box box = Box::empty();
        for (const Corner& c : polygon) box.add(c.position);
        items.push_back({box, i, i, 3 * i, 3, 1});
    }
    const ClippedItems both(items, corners, planes);
    PolygonBsp::node_data data{};
    REQUIRE(bsp.choose(root, both, data) == Split::always);
    const std::vector<Box> children(3, Box{glm::vec3(-1), glm::vec3(1)});
    bsp.fit(root, data, children);
    PolygonBsp::node_data below{};
    for (const unsigned side : {PolygonBsp::behind, PolygonBsp::in_front}) {
        CHECK(bsp.choose(bsp.child(root, data, side), both, below) == Split::always);
    }
    const Cell on = bsp.child(root, data, PolygonBsp::on);
    CHECK(bsp.choose(on, both, below) == Split::no);
    // So are its own, should it get some.
    CHECK(bsp.choose(bsp.child(on, data, PolygonBsp::behind), both, below) == Split::no);
}
