// Greene 1996, section 6.2: bodies that pass through one another, each with a hierarchy of its own, come in one strict
// order, and look as a z-buffer shows them.
#include "farfield/merged_viewer.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/nested.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/partition/polygon_bsp.hpp"
#include "farfield/renderer/coverage_renderer.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "scenes/renderers/coverage_tilers.hpp"
#include "support/pictures.hpp"
#include "support/scenes.hpp"
#include "support/strict_order.hpp"

namespace farfield::test {
namespace {

using Bsp = SpatialHierarchy<PolygonBsp, Exact, TriangleCount>;
using OctreeOfBsps = SpatialHierarchy<Nested<Octree, PolygonBsp>, Exact, TriangleCount>;

/// A piece as a primitive.
struct One {
    Polygon polygon;
    Box bounds() const {
        Box box = Box::empty();
        for (const glm::vec3& v : polygon.vertices) box.add(v);
        return box;
    }
    template <class Sink>
    void polygons(Sink&& sink) const {
        sink(polygon);
    }
};

/// Keeps pieces too.
struct PolygonRecorder : OrderRecorder {
    static constexpr RendererFacts facts{
        .order = VisitOrder::front_to_back, .needs_ordering = OrderGuarantee::primitives, .draws_polygons = true};
    std::size_t pieces = 0;

    using OrderRecorder::draw;
    void draw(std::span<const Polygon> drawn) {
        pieces += drawn.size();
        std::vector<One> all;
        for (const Polygon& p : drawn) all.push_back({p});
        const Range range{0, std::uint32_t(all.size())};
        draw(Source<One>{all, {}, range.count}, std::span<const Range>(&range, 1));
    }
};

/// Pieces that back-to-front renderers get, nearest last.
struct BackToFrontRecorder : PolygonRecorder {
    static constexpr RendererFacts facts{
        .order = VisitOrder::back_to_front, .needs_ordering = OrderGuarantee::primitives, .draws_polygons = true};
};

struct Scene {
    std::string name;
    std::vector<Triangles> bodies;
    std::vector<Similarity> places;
};

template <class H>
class Built {
  public:
    explicit Built(const Scene& scene) : scene_(scene) {
        for (const Triangles& t : scene_.bodies) hierarchies_.push_back(build<H>(t));
    }
    std::vector<Instance<H, Triangle>> bodies() const {
        std::vector<Instance<H, Triangle>> result;
        for (std::size_t b = 0; b < hierarchies_.size(); ++b) {
            result.push_back({&hierarchies_[b], scene_.bodies[b], scene_.places[b]});
        }
        return result;
    }

  private:
    const Scene& scene_;
    std::vector<H> hierarchies_;
};

Similarity placed(glm::vec3 at, glm::vec3 axis = {0, 1, 0}, float radians = 0, float scale = 1) {
    const glm::dmat4 m = glm::translate(glm::dmat4(1), glm::dvec3(at));
    return Similarity(
        glm::scale(glm::rotate(m, double(radians), glm::normalize(glm::dvec3(axis))), glm::dvec3(double(scale))));
}

Triangles box(glm::vec3 lower, glm::vec3 upper, Rgba8 color) {
    const glm::vec3 s = upper - lower, x(s.x, 0, 0), y(0, s.y, 0), z(0, 0, s.z);
    Triangles t = sheet(lower, y, x, 1, 1, color);
    append(t, sheet(lower, z, y, 1, 1, color));
    append(t, sheet(lower, x, z, 1, 1, color));
    append(t, sheet(upper, -x, -y, 1, 1, color));
    append(t, sheet(upper, -y, -z, 1, 1, color));
    append(t, sheet(upper, -z, -x, 1, 1, color));
    for (std::size_t i = 0; i < t.size(); ++i) {
        const auto shade = [&](std::uint8_t c) { return std::uint8_t(c * (7 + i / 2) / 13); };
        t[i].rgba = {shade(color.r), shade(color.g), shade(color.b), 255};
    }
    return t;
}

Triangles colored(Triangles t, std::uint64_t seed) {
    Random random(seed);
    for (Triangle& one : t) {
        one.rgba = random.color();
        one.rgba.a = 255;
    }
    return t;
}

/// A floor, three walls, one of them oblique, and a table and a shelf.
Triangles room() {
    Triangles t = sheet({-2, -1, -2}, {0, 0, 4}, {4, 0, 0}, 6, 6, {});
    append(t, sheet({-2, -1, -2}, {4, 0, 0}, {0, 2, 0}, 5, 3, {}));
    append(t, sheet({-2, -1, 2}, {0.5f, 0, -4}, {0, 2, 0}, 4, 2, {}));
    append(t, sheet({0.3f, -1, -2}, {0, 0, 2.6f}, {0, 2, 0}, 4, 3, {}));
    append(t, box({-1.2f, -0.4f, -0.5f}, {-0.1f, -0.3f, 0.7f}, {}));
    for (int i = 0; i < 4; ++i) {
        const glm::vec3 leg(i % 2 == 0 ? -1.1f : -0.3f, -1.02f, i / 2 == 0 ? -0.4f : 0.5f);
        append(t, box(leg, leg + glm::vec3(0.1f, 0.67f, 0.1f), {}));
    }
    for (int i = 0; i < 3; ++i)
        append(t, box({1, -0.8f + 0.5f * float(i), -1.9f}, {1.8f, -0.75f + 0.5f * float(i), -1.2f}, {}));
    return colored(std::move(t), 11);
}

/// Bodies that fly through the room, its walls and each other.
Scene flying(double t) {
    Scene scene{"room at " + std::to_string(t), {room()}, {Similarity()}};
    Random random(12);
    for (int b = 0; b < 9; ++b) {
        Triangles body;
        const float size = random.between(0.25f, 0.5f);
        if (b % 3 == 0) body = sphere({0, 0, 0}, size, 6, {});
        if (b % 3 == 1)
            body = box(glm::vec3(-size, -0.5f * size, -0.7f * size), glm::vec3(size, 0.5f * size, 0.7f * size), {});
        if (b % 3 == 2) body = random_triangles(40, 13 + std::uint64_t(b), size);
        if (b % 3 == 2) body = moved(std::move(body), 0.5f * size);
        scene.bodies.push_back(colored(std::move(body), 14 + std::uint64_t(b)));
        const glm::vec3 axis = random.in_cube(1), from = random.in_cube(0.8f), to = random.in_cube(1.6f);
        const float scale = b % 2 == 0 ? 1.0f : random.between(0.5f, 1.5f), phase = random.between(0, 6);
        scene.places.push_back(placed(from + (to - from) * float(t), axis, phase + 3 * float(t), scale));
    }
    return scene;
}

std::vector<Scene> scenes() {
    std::vector<Scene> out;
    const auto add = [&](const char* name, std::vector<std::pair<Triangles, Similarity>> bodies) {
        Scene scene{name, {}, {}};
        for (auto& [triangles, place] : bodies) {
            scene.bodies.push_back(std::move(triangles));
            scene.places.push_back(place);
        }
        out.push_back(std::move(scene));
    };
    const auto ball = [](float radius, int n, std::uint64_t seed) { return colored(sphere({}, radius, n, {}), seed); };
    for (const double t : {0.0, 0.31, 0.62, 1.0}) out.push_back(flying(t));
    add("apart",
        {{ball(0.5f, 6, 1), placed({-1, 0, 0})}, {ball(0.5f, 6, 2), placed({1, 0, 0})}, {room(), placed({0, 4, 0})}});
    add("inside one another", {{ball(1, 8, 3), placed({})},
                               {ball(1, 7, 4), placed({0.05f, 0, 0}, {1, 2, 3}, 1, 0.7f)},
                               {ball(1, 6, 5), placed({0, 0.02f, 0}, {3, 2, 3}, 2, 0.3f)}});
    add("through one another",
        {{ball(1, 8, 6), placed({-0.3f, 0, 0})}, {ball(1, 8, 7), placed({0.3f, 0.1f, 0.2f}, {1, 1, 0}, 1)}});
    add("one polygon through a body",
        {{ball(1, 8, 8), placed({})},
         {colored(sheet({-2, -2, 0}, {4, 0, 0}, {0, 4, 0}, 1, 1, {}), 9), placed({}, {1, 0.2f, 0.1f}, 1)}});
    add("single polygons through one another",
        {{colored(sheet({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 1, 1, {}), 21), placed({})},
         {colored(sheet({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 1, 1, {}), 22), placed({}, {1, 0, 0}, 1)},
         {colored(sheet({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 1, 1, {}), 23), placed({}, {1, 1, 0}, 1.5f)}});
    add("something empty",
        {{{}, placed({})}, {ball(0.6f, 6, 10), placed({})}, {{}, placed({1, 0, 0})}, {room(), placed({})}});
    add("the same twice", {{ball(0.8f, 6, 24), placed({})}, {ball(0.8f, 6, 24), placed({})}});
    add("of very different sizes", {{room(), placed({}, {0, 1, 0}, 0.3f, 100)},
                                    {moved(ball(0.8f, 8, 25), 1e-3f), placed({-40, -70, 20}, {1, 2, 0}, 1, 4e4f)},
                                    {moved(ball(0.8f, 8, 26), 1e3f), placed({-60, -60, 30}, {1, 2, 0}, 1, 0.05f)}});
    add("many random", [] {
        std::vector<std::pair<Triangles, Similarity>> bodies;
        Random random(27);
        for (int b = 0; b < 40; ++b) {
            const glm::vec3 at = random.in_cube(1), axis = random.in_cube(1);
            bodies.emplace_back(colored(random_triangles(12, 28 + std::uint64_t(b), 0.5f), 29 + std::uint64_t(b)),
                                placed(at, axis, random.between(0, 6), 0.3f));
        }
        return bodies;
    }());
    return out;
}

/// Its box in the world.
template <class H>
BoxD bounds_of(const std::vector<Instance<H, Triangle>>& bodies) {
    BoxD whole = BoxD::empty();
    for (const auto& b : bodies) whole.add(b.bounds());
    return whole;
}

std::vector<View> views_of(const BoxD& whole, int size) {
    const glm::dvec3 center = whole.center();
    const double radius = 0.5 * glm::length(whole.size());
    std::vector<View> out;
    for (const glm::dvec3& d : {glm::dvec3(1, 0.5, 1.1), {-0.6, 1, 0.2}, {0.01, -0.2, 1}}) {
        out.push_back(looking(center + radius * 1.6 * glm::normalize(d), center, size));
        out.push_back(looking(center + radius * 0.3 * d, center + radius * glm::dvec3(d.y, -d.z, d.x + 0.1), size));
        out.push_back(
            looking_orthographic(center + radius * 3.0 * glm::normalize(d), center, float(1.4 * radius), size));
    }
    return out;
}

/// All triangles as they are, by a z-buffer, in the same views.
template <class R, class H>
Image plain_picture(R& renderer, const std::vector<Instance<H, Triangle>>& bodies, const View& view) {
    const glm::vec3 size(bounds_of(bodies).size());
    const LocalView outer(view, bodies[0].hierarchy->origin(), std::sqrt(glm::dot(size, size)));
    std::vector<Source<Triangle>> sources;
    for (const auto& body : bodies) {
        const auto count = std::uint32_t(body.primitives.size());
        sources.push_back({body.primitives, {}, count, body.hierarchy->origin(), 0});
        sources.back().id = renderer.upload(sources.back());
    }
    renderer.begin_frame(outer);
    for (std::size_t b = 0; b < bodies.size(); ++b) {
        renderer.set_view(outer.inside(bodies[b].to_world, bodies[0].hierarchy->origin(), sources[b].origin));
        const Range all{0, sources[b].item_count};
        renderer.draw(sources[b], std::span<const Range>(&all, 1));
    }
    renderer.end_frame();
    for (const auto& s : sources) renderer.release(s.id);
    return renderer.image();
}

using Strict = StrictCoverageRenderer;

template <class H, class Recorder>
void check_order_of(const Scene& scene) {
    INFO(scene.name);
    const Built<H> built(scene);
    const auto bodies = built.bodies();
    const BoxD whole = bounds_of(bodies);
    const glm::dvec3 reach = glm::max(glm::abs(whole.lower), glm::abs(whole.upper));
    // Of the world's coordinates and of the eye's.
    const double radius = 0.5 * glm::length(whole.size()), step = 0x1p-22 * (glm::length(reach) + 3 * radius);
    Recorder recorder;
    auto viewer = make_merged_viewer(bodies, recorder);
    std::uint64_t seed = 30;
    for (const View& view : views_of(whole, 64)) {
        const MergedFrameStats stats = viewer.frame(view);
        CHECK(stats.primitives == recorder.polygons.size());
        if (Recorder::facts.order == VisitOrder::back_to_front)
            std::reverse(recorder.polygons.begin(), recorder.polygons.end());
        const OrderCheck check = check_order(recorder.polygons, view.camera.projection == Projection::perspective,
                                             radius, step, 300, ++seed);
        INFO("view " << seed - 30 << ", " << check.hits << " hits, " << stats.pieces << " pieces");
        CHECK(check.wrong == 0);
    }
}

}  // namespace

TEST_CASE("polygons of bodies that meet come in strict order") {
    for (const Scene& scene : scenes()) {
        check_order_of<Bsp, PolygonRecorder>(scene);
        check_order_of<OctreeOfBsps, PolygonRecorder>(scene);
    }
}

TEST_CASE("a painter gets the polygons of bodies that meet back to front") {
    for (const Scene& scene : scenes()) check_order_of<Bsp, BackToFrontRecorder>(scene);
}

TEST_CASE("bodies that meet look as a z-buffer shows them") {
    constexpr int size = 96;
    ZBufferRenderer reference(ZBufferOptions{.samples = 64});
    Strict renderer;
    for (const Scene& scene : scenes()) {
        INFO(scene.name);
        const Built<Bsp> built(scene);
        const auto bodies = built.bodies();
        auto viewer = make_merged_viewer(bodies, renderer);
        for (const View& view : views_of(bounds_of(bodies), size)) {
            viewer.frame(view);
            const Image expected = plain_picture(reference, bodies, view);
            // Corners of pieces are snapped to 1/256 sample: a sample in 64, here and there.
            CHECK(different_pixels(renderer.image(), expected) <= size * size / 100);
            CHECK(largest_difference(renderer.image(), expected) <= 8);
        }
    }
}

TEST_CASE("one body alone, wherever it is, looks as a viewer of it shows it") {
    const Triangles triangles = room();
    const auto h = build<OctreeOfBsps>(triangles, {.partition = {.largest_leaf = 40}});
    const std::vector<View> views = views_of(BoxD{{-2, -1, -2}, {2.5, 1, 2}}, 96);
    Strict alone, merged;
    auto viewer = make_viewer(h, triangles, alone);
    for (const bool is_far_away : {false, true}) {
        // Something that is never seen.
        std::vector<Instance<OctreeOfBsps, Triangle>> bodies{{&h, triangles, Similarity()}};
        if (is_far_away) bodies.push_back({&h, triangles, placed({0, 0, -9}, {0, 1, 0}, 0, 1e-3f)});
        auto merging = make_merged_viewer(bodies, merged);
        for (const View& view : views) {
            const FrameStats expected = viewer.frame(view);
            const MergedFrameStats stats = merging.frame(view);
            if (is_far_away) {
                CHECK(different_pixels(merged.image(), alone.image()) <= 96 * 96 / 100);
                continue;
            }
            CHECK(merged.image() == alone.image());
            CHECK(stats.primitives == expected.primitives);
            CHECK(stats.cells_visited == expected.cells_visited);
            CHECK(stats.cells_hidden == expected.cells_hidden);
            CHECK(stats.cells_outside == expected.cells_outside);
            CHECK(stats.regions + stats.pieces == 0);
        }
    }
}

TEST_CASE("bodies whose boxes do not meet are not cut") {
    const Triangles ball = colored(sphere({}, 1, 6, {}), 40), scattered = random_triangles(60, 41, 0.3f);
    const Bsp h = build<Bsp>(ball), other = build<Bsp>(scattered);
    std::vector<Instance<Bsp, Triangle>> bodies;
    for (int i = 0; i < 7; ++i) {
        const glm::vec3 at(2.5f * float(i), 0.3f * float(i % 3), float(i % 2));
        bodies.push_back(i % 3 == 0 ? Instance<Bsp, Triangle>{&other, scattered, placed(at)}
                                    : Instance<Bsp, Triangle>{&h, ball, placed(at)});
    }
    PolygonRecorder recorder;
    auto viewer = make_merged_viewer(bodies, recorder);
    for (const View& view : views_of(bounds_of(bodies), 64)) {
        const MergedFrameStats stats = viewer.frame(view);
        CHECK(stats.pieces == 0);
        CHECK(recorder.pieces == 0);
    }
}

TEST_CASE("a body that was placed is where it was placed") {
    const Scene before = flying(0.2), after = flying(0.7);
    const Built<Bsp> built(before);
    auto bodies = built.bodies();
    Strict one, other;
    auto moving = make_merged_viewer(bodies, one);
    const std::vector<View> views = views_of(bounds_of(bodies), 64);
    moving.frame(views[0]);
    for (std::size_t b = 0; b < bodies.size(); ++b) {
        moving.place(b, after.places[b]);
        bodies[b].to_world = after.places[b];
    }
    auto there = make_merged_viewer(bodies, other);
    for (const View& view : views) {
        moving.frame(view);
        there.frame(view);
        CHECK(one.image() == other.image());
    }
    CHECK_THROWS_WITH(moving.place(10, Similarity()), "farfield::MergedViewer: there is no body 10 of 10");
    Similarity nowhere;
    nowhere.translation.z = std::numeric_limits<double>::quiet_NaN();
    CHECK_THROWS_WITH(moving.place(1, nowhere), "farfield::MergedViewer: body 1's translation must be finite");
}

TEST_CASE("no bodies, and bodies of nothing, show the background") {
    const Triangles nothing;
    const Bsp h = build<Bsp>(nothing);
    Strict renderer;
    const View view = looking({0, 0, 3});
    std::vector<Instance<Bsp, Triangle>> bodies;
    for (int i = 0; i < 3; ++i) {
        auto viewer = make_merged_viewer(bodies, renderer);
        CHECK(viewer.frame(view).primitives == 0);
        CHECK(coverage(renderer.image()) == 0);
        bodies.push_back({&h, nothing, placed({float(i), 0, 0})});
    }
}

TEST_CASE("bodies that cannot be merged are refused by name") {
    const Triangles triangles = random_triangles(40, 42, 0.5f);
    const Bsp strict = build<Bsp>(triangles), loose = build<Bsp>(triangles, {.partition = {.max_depth = 2}});
    REQUIRE(!loose.keeps_strict_order());
    PolygonRecorder recorder;
    const auto with = [&](const Bsp* h, std::span<const Triangle> primitives) {
        return make_merged_viewer(std::vector<Instance<Bsp, Triangle>>{{&strict, triangles, {}}, {h, primitives, {}}},
                                  recorder);
    };
    using Catch::Contains;
    CHECK_THROWS_WITH(with(nullptr, triangles), "farfield::MergedViewer: body 1 has no hierarchy");
    CHECK_THROWS_WITH(with(&strict, std::span(triangles).first(39)),
                      "farfield::MergedViewer: body 1 was built from 40 primitives and is given 39");
    CHECK_THROWS_WITH(with(&loose, triangles),
                      Contains("MergedViewer: body 1 does not keep") && Contains("cells_out_of_order"));
    CHECK_THROWS_AS(with(&loose, triangles), std::invalid_argument);
    CHECK_NOTHROW(with(&strict, triangles));
}

}  // namespace farfield::test
