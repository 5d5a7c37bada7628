// Strict: the first polygon drawn is seen wherever it covers a sample, by exact edge functions. Lazy: the samples of a
// z-buffer, whatever the order. And what is said to be hidden is.
#include "farfield/renderer/coverage_renderer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <stdexcept>
#include <utility>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/raster/polygon_clip.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "scenes/renderers/coverage_tilers.hpp"
#include "support/masks.hpp"
#include "support/pictures.hpp"
#include "support/random.hpp"
#include "support/scenes.hpp"

namespace farfield::test {
namespace {

struct Quadrilateral {
    std::array<glm::vec3, 4> vertices{};
    Rgba8 rgba{};

    Box bounds() const {
        Box box = Box::empty();
        for (const glm::vec3& v : vertices) box.add(Box{v, v});
        return box;
    }
    template <class Sink>
    void polygons(Sink&& sink) const {
        sink(Polygon{vertices, {&rgba, 1}});
    }
};

template <class R, class P>
void draw_all(R& renderer, const Source<P>& source) {
    const Range all{0, source.item_count};
    renderer.draw(source, std::span<const Range>(&all, 1));
}

/// Every primitive in the user's order.
template <class R, class P>
Image picture(R& renderer, std::span<const P> primitives, const View& view) {
    glm::dvec3 origin;
    const LocalView local = local_view(primitives, view, origin);
    Source<P> source{primitives, {}, std::uint32_t(primitives.size()), origin, 0};
    source.id = renderer.upload(source);
    renderer.begin_frame(local);
    renderer.set_view(local);
    draw_all(renderer, source);
    renderer.end_frame();
    renderer.release(source.id);
    return renderer.image();
}
template <class R, class P>
Image picture(R& renderer, const std::vector<P>& primitives, const View& view) {
    return picture(renderer, std::span<const P>(primitives), view);
}

struct Points : LazyCoverage {
    using samples = SinglePixels;
};
using LazyPoints = BasicCoverageRenderer<Points>;
using StrictPoints = BasicCoverageRenderer<RecordedStrict<1>>;
using StrictSamples = BasicCoverageRenderer<RecordedStrict<8>>;

View sized(View view, int width, int height) {
    view.width = width;
    view.height = height;
    return view;
}

/// Across a unit cube from outside and from inside, so that the near plane cuts; in sizes of all kinds.
const std::vector<View>& views() {
    static const std::vector<View> all = [] {
        std::vector<View> v{looking({0, 0, 4}), looking({2, 1.5, 2.5}), looking({0.1, 0.2, 0.3}, {1, 0.5, 0.2}),
                            looking_orthographic({1, 2, 3})};
        v.push_back(sized(looking({1.5, 0.3, 0.2}), 333, 200));
        return v;
    }();
    return all;
}
const std::vector<View>& odd_views() {
    static const std::vector<View> all = [] {
        std::vector<View> v;
        v.push_back(sized(looking({0, 0, 3}), 640, 360));
        for (const auto& [w, h] : {std::pair{1, 1}, {7, 3}, {8, 8}, {64, 64}, {65, 63}}) {
            v.push_back(sized(looking({0, 0, 3}), w, h));
            v.push_back(sized(looking({0.3, -0.2, 0.1}, {1, 0.4, 0.3}), w, h));
            v.push_back(sized(looking_orthographic({1, 2, 3}), w, h));
        }
        v.push_back(looking({0.3, -0.2, 0.9}));
        v.back().camera.near_depth = 0.5f;
        v.push_back(looking_orthographic({0, 0, 0.1}, {0, 0, -1}));
        v.back().camera.near_depth = 0.01f;
        return v;
    }();
    return all;
}

/// A triangle as it is to be tiled: on the screen and clockwise, in parts where it crosses the near plane or leaves the
/// guard band.
template <class Sink>
void on_screen(const std::array<glm::vec3, 3>& vertices, Rgba8 color, const SampleProjection& to, Sink&& sink) {
    bool is_whole = true;
    ClippedPolygon polygon;
    for (const glm::vec3& v : vertices) {
        const glm::vec3 p = to.project(v);
        const float inverse = to.inverse_w(p.z), guard = SampleProjection::guard_band * 256;
        is_whole = is_whole && p.z >= to.near_depth && std::abs(p.x * inverse + to.offset_x) < guard &&
                   std::abs(p.y * inverse + to.offset_y) < guard;
        polygon.add(v, to);
    }
    if (!is_whole) polygon.clip(to);
    for (std::size_t i = 2; i < polygon.size(); ++i) {
        SnappedTriangle t;
        polygon.snap(0, to, t, 0);
        polygon.snap(i - 1, to, t, 1);
        polygon.snap(i, to, t, 2);
        if (t.doubled_area() < 0) t.flip();
        if (t.doubled_area() == 0) continue;
        TilePolygon p;
        p.corners = 3;
        std::copy(t.x, t.x + 3, p.x.begin());
        std::copy(t.y, t.y + 3, p.y.begin());
        p.surface.colors.fill(color);
        sink(p);
    }
}

/// By brute force, the first of what covers a sample.
std::vector<Rgba8> strict_samples(const std::vector<Triangle>& triangles, const LocalView& view, int side) {
    const SampleProjection to(view, side);
    BruteForce brute({view.width, view.height, side});
    for (const Triangle& t : triangles) {
        on_screen(t.vertices, t.rgba, to, [&](const TilePolygon& p) { brute.draw_strict(p); });
    }
    return brute.colors();
}

Triangles slivers(std::size_t count, std::uint64_t seed) {
    Random random(seed);
    Triangles out;
    for (std::size_t i = 0; i < count; ++i) {
        const glm::vec3 a = random.in_cube(1.2f), b = random.in_cube(1.2f);
        const float along = random.unit();
        const glm::vec3 c = a + (b - a) * along + random.in_cube(i % 3 == 0 ? 0.0f : 0.004f);
        out.push_back({{a, b, c}, random.color()});
    }
    return out;
}
Triangles degenerate(std::uint64_t seed) {
    Random random(seed);
    Triangles out;
    for (int i = 0; i < 60; ++i) {
        const glm::vec3 a = random.in_cube(1), b = random.in_cube(1);
        out.push_back({{a, a, a}, random.color()});
        out.push_back({{a, b, a}, random.color()});
        out.push_back({{a, b, 0.5f * (a + b)}, random.color()});
        out.push_back({{a, b, random.in_cube(1)}, random.color()});
    }
    return out;
}

struct Scene {
    const char* name;
    Triangles triangles;
};
const std::vector<Scene>& scenes() {
    static const std::vector<Scene> all = {
        {"small", random_triangles(600, 1)},
        {"large", random_triangles(100, 2, 0.7f)},
        {"mixed", mixed_triangles(1000, 3)},
        {"sphere", sphere(glm::vec3(0.1f), 0.8f, 20, {200, 100, 50, 255})},
        {"sheet", sheet({-1.5f, -1, 0.2f}, {3, 0.5f, -0.3f}, {0.2f, 2, 0.6f}, 12, 9, {10, 200, 50, 255})},
        {"one", random_triangles(1, 4, 0.9f)},
        {"huge", random_triangles(40, 5, 30.0f)},
        {"slivers", slivers(400, 6)},
        {"degenerate", degenerate(7)},
        {"none", {}},
    };
    return all;
}

template <class R, class Samples>
void check_strict(R& renderer, const Scene& scene, const View& view, int side) {
    Triangles triangles = scene.triangles;
    for (std::size_t i = 0; i < triangles.size(); ++i) triangles[i].rgba = numbered(std::uint32_t(i));
    const LocalView local = local_view(std::span<const Triangle>(triangles), view);
    const std::vector<Rgba8> expected = strict_samples(triangles, local, side);
    const std::size_t different = different_samples(picture(renderer, triangles, view), expected);
    if (different != 0 || !Samples::last_error.empty()) {
        FAIL(scene.name << ", " << view.width << " x " << view.height << ": " << different << " samples differ; "
                        << Samples::last_error);
    }
}

/// A box to be asked about.
Cell box_cell(glm::vec3 center, glm::vec3 half) {
    Cell cell;
    cell.center = cell.bounds_center = center;
    cell.half = cell.bounds_half = half;
    return cell;
}
}  // namespace

TEST_CASE("strict: every sample shows what brute force finds first, and comes once", "[raster]") {
    StrictPoints points[] = {StrictPoints({.simd = Simd::scalar}), StrictPoints({.simd = Simd::four_lanes}),
                             StrictPoints({.simd = Simd::eight_lanes}), StrictPoints({.simd = Simd::sixteen_lanes})};
    StrictSamples samples;
    for (const Scene& scene : scenes()) {
        for (const View& view : views()) {
            for (StrictPoints& renderer : points)
                check_strict<StrictPoints, RecordedSamples<1>>(renderer, scene, view, 1);
        }
        for (const View& view : odd_views()) {
            check_strict<StrictPoints, RecordedSamples<1>>(points[3], scene, view, 1);
            if (view.width < 70) check_strict<StrictSamples, RecordedSamples<8>>(samples, scene, view, 8);
        }
    }
}

TEST_CASE("strict: quadrilaterals cover what their two triangles cover, bent by snapping or not", "[raster]") {
    Random random(860);
    StrictPoints renderer;
    for (int round = 0; round < 40; ++round) {
        std::vector<Quadrilateral> quadrilaterals;
        Triangles triangles;
        const float size = std::exp2(-float(round % 10));
        for (std::uint32_t i = 0; i < 60; ++i) {
            const glm::vec3 at = random.in_cube(1), u = random.in_cube(size), v = random.in_cube(size);
            Quadrilateral q{{at, at + u, at + u + v, at + v}, numbered(i)};
            if (i % 4 == 1) q.vertices[2] = at + 0.51f * (u + v);                // nearly a triangle
            if (i % 4 == 2) q.vertices[2] = at + u + random.in_cube(size / 64);  // a short edge
            if (i % 16 == 3) q.vertices[1] = at;
            quadrilaterals.push_back(q);
            triangles.push_back({{q.vertices[0], q.vertices[1], q.vertices[2]}, q.rgba});
            triangles.push_back({{q.vertices[0], q.vertices[2], q.vertices[3]}, q.rgba});
        }
        for (const View& view : {looking({0, 0, 3}), sized(looking({0.2, 0.1, 0.3}, {1, 0.4, 0.3}), 65, 63),
                                 looking_orthographic({1, 2, 3})}) {
            const LocalView local = local_view(std::span<const Quadrilateral>(quadrilaterals), view);
            const Image image = picture(renderer, quadrilaterals, view);
            REQUIRE(different_samples(image, strict_samples(triangles, local, 1)) == 0);
            REQUIRE(RecordedSamples<1>::last_error == "");
        }
    }
}

TEST_CASE("lazy masks give the samples of a z-buffer, whatever the order", "[raster]") {
    CoverageRenderer filtered[] = {
        CoverageRenderer({.simd = Simd::scalar}), CoverageRenderer({.simd = Simd::four_lanes}),
        CoverageRenderer({.simd = Simd::eight_lanes}), CoverageRenderer({.simd = Simd::sixteen_lanes})};
    LazyPoints points[] = {LazyPoints({.simd = Simd::scalar}), LazyPoints({.simd = Simd::four_lanes}),
                           LazyPoints({.simd = Simd::eight_lanes}), LazyPoints({.simd = Simd::sixteen_lanes})};
    for (const Scene& scene : scenes()) {
        const std::span<const Triangle> all(scene.triangles);
        for (const View& view : views()) {
            CAPTURE(scene.name, view.camera.eye.x, view.width);
            const Image fine = plain_picture(all, view, {.samples = 64}), coarse = plain_picture(all, view);
            for (CoverageRenderer& r : filtered) CHECK(different_pixels(picture(r, all, view), fine) == 0);
            for (LazyPoints& r : points) CHECK(different_pixels(picture(r, all, view), coarse) == 0);
        }
        for (const View& view : odd_views()) {
            CAPTURE(scene.name, view.camera.eye.x, view.width);
            if (view.width < 70) {
                const Image fine = plain_picture(all, view, {.samples = 64});
                CHECK(different_pixels(picture(filtered[3], all, view), fine) == 0);
            }
            CHECK(different_pixels(picture(points[3], all, view), plain_picture(all, view)) == 0);
        }
    }
}

TEST_CASE("lazy: slivers that cross are told apart by the depths that samples have, rounding included", "[raster]") {
    // The slopes of the first one's plane are lost to rounding: at the sample that both cover it is clamped.
    const Triangles pair = {{{{{-0.137664557f, -0.68623054f, -0.474749565f},
                               {0.772417665f, 0.872249842f, 1.05608177f},
                               {0.0443282947f, -0.369440109f, -0.161588714f}}},
                             {255, 0, 0, 255}},
                            {{{{-0.103655815f, -1.14098346f, 0.65294838f},
                               {0.591365337f, 0.490919471f, 0.350192666f},
                               {0.372908503f, -0.012115689f, 0.442960173f}}},
                             {0, 255, 0, 255}}};
    LazyPoints points;
    const auto check = [&](std::span<const Triangle> all, const View& view) {
        CHECK(different_pixels(picture(points, all, view), plain_picture(all, view)) == 0);
    };
    check(pair, sized(looking({0.3, -0.2, 0.1}, {1, 0.4, 0.3}), 7, 3));
    Random random(865);
    for (int round = 0; round < 60; ++round) {
        CAPTURE(round);
        Triangles triangles;
        for (int i = 0; i < 150; ++i) {
            const glm::vec3 a = random.in_cube(1.2f), b = random.in_cube(1.2f), beside = random.in_cube(1);
            const float along = random.unit(), width = std::exp2(-float(3 + random.below(18)));
            triangles.push_back({{a, b, a + (b - a) * along + beside * width}, random.color()});
        }
        for (const View& view : odd_views()) check(triangles, view);
    }
}

TEST_CASE("lazy: order, duplicates and coplanar polygons do not matter", "[raster]") {
    Random random(870);
    CoverageRenderer filtered;
    LazyPoints points;
    for (int round = 0; round < 6; ++round) {
        Triangles triangles = random_triangles(150, 871 + std::uint64_t(round), 0.5f);
        append(triangles, sheet({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 4, 4, {100, 0, 0, 255}));
        append(triangles, sheet({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 4, 4, {0, 100, 0, 255}));      // the same plane
        append(triangles, sheet({-1, -0.5f, -1}, {2, 0, 0}, {0, 1, 2}, 1, 1, {0, 0, 100, 255}));  // through it
        const std::size_t count = triangles.size();
        for (std::size_t i = 0; i < count; i += 3) {
            triangles.push_back(triangles[i]);
            if (i % 2 == 0) triangles.back().rgba = random.color();
        }
        for (const View& view : {views()[1], views()[2], views()[3]}) {
            const Image fine = plain_picture(std::span<const Triangle>(triangles), view, {.samples = 64});
            const Image coarse = plain_picture(std::span<const Triangle>(triangles), view);
            for (int order = 0; order < 4; ++order) {
                CHECK(different_pixels(picture(filtered, triangles, view), fine) == 0);
                CHECK(different_pixels(picture(points, triangles, view), coarse) == 0);
                const auto depth = [&](const Triangle& t) {
                    return glm::dot(view.camera.forward, t.vertices[0] + t.vertices[1] + t.vertices[2]);
                };
                if (order == 0) random.shuffle(triangles);
                if (order == 1) {
                    std::sort(triangles.begin(), triangles.end(),
                              [&](const Triangle& a, const Triangle& b) { return depth(a) < depth(b); });
                }
                if (order == 2) std::reverse(triangles.begin(), triangles.end());
            }
        }
    }
}

TEST_CASE("lazy: translucent primitives cover the samples that they cover in a z-buffer", "[raster]") {
    Random random(880);
    CoverageRenderer filtered({.background = {10, 20, 30, 40}});
    LazyPoints points({.background = {10, 20, 30, 40}});
    Triangles triangles = random_triangles(400, 881, 0.4f);
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        if (i % 2 == 0) triangles[i].rgba.a = std::uint8_t(random.below(256));
    }
    append(triangles, random_triangles(5, 882, 30));
    for (std::size_t i = 400; i < 405; ++i) triangles[i].rgba.a = 100;
    for (const View& view : views()) {
        const std::span<const Triangle> all(triangles);
        CHECK(different_pixels(picture(filtered, all, view),
                               plain_picture(all, view, {.samples = 64, .background = {10, 20, 30, 40}})) == 0);
        CHECK(different_pixels(picture(points, all, view),
                               plain_picture(all, view, {.background = {10, 20, 30, 40}})) == 0);
    }
}

TEST_CASE("lazy: colors that vary are a z-buffer's where samples are pixels, and near them elsewhere", "[raster]") {
    Random random(890);
    std::vector<VertexColoredTriangle> triangles;
    for (const Triangle& t : random_triangles(300, 891, 0.6f)) {
        triangles.push_back({t.vertices, {random.color(), random.color(), random.color()}});
        if (triangles.size() % 3 == 0) triangles.back().rgba[random.below(3)].a = std::uint8_t(random.below(256));
        if (triangles.size() % 5 == 0) triangles.back().rgba[1] = triangles.back().rgba[2] = triangles.back().rgba[0];
    }
    for (const bool culls : {false, true}) {
        LazyPoints points({.culls_back_faces = culls});
        for (const View& view : views()) {
            const std::span<const VertexColoredTriangle> all(triangles);
            CHECK(different_pixels(picture(points, all, view), plain_picture(all, view, {.culls_back_faces = culls})) ==
                  0);
        }
    }

    // Smooth over many pixels, one color a pixel is not far off.
    std::vector<VertexColoredTriangle> smooth;
    for (const Triangle& t : sheet({-1, -1, 0}, {2, 0.3f, 0}, {0, 2, -0.5f}, 3, 3, {})) {
        smooth.push_back({t.vertices, {}});
        for (std::size_t c = 0; c < 3; ++c) {
            const glm::vec3 at = 60.0f * (t.vertices[c] + glm::vec3(2));
            smooth.back().rgba[c] = {std::uint8_t(at.x), std::uint8_t(at.y), std::uint8_t(at.z), 255};
        }
    }
    CoverageRenderer filtered;
    for (const View& view : {views()[0], views()[1], views()[3]}) {
        const std::span<const VertexColoredTriangle> all(smooth);
        CHECK(largest_difference(picture(filtered, all, view), plain_picture(all, view, {.samples = 64})) <= 3);
    }
}

TEST_CASE("lazy: light and culled back faces as in a z-buffer", "[raster]") {
    const DirectionalLight light{.towards = glm::normalize(glm::vec3(1, 2, 0.5f))};
    const Triangles triangles = [] {
        Triangles t = sphere(glm::vec3(0.1f), 0.8f, 12, {200, 100, 50, 255});
        append(t, random_triangles(60, 895, 0.8f));
        return t;
    }();
    const std::span<const Triangle> all(triangles);
    for (const View& view : views()) {
        for (const bool culls : {false, true}) {
            CoverageRenderer filtered({.light = light, .culls_back_faces = culls});
            const Image fine = plain_picture(all, view, {.samples = 64, .light = light, .culls_back_faces = culls});
            CHECK(different_pixels(picture(filtered, all, view), fine) == 0);
        }
    }
}

TEMPLATE_TEST_CASE("what is said to be hidden would change no sample", "[raster]", StrictPoints, StrictSamples,
                   LazyPoints, CoverageRenderer) {
    Random random(900);
    TestType renderer;
    int hidden = 0, seen = 0, inside_view = 0;
    for (int round = 0; round < 60; ++round) {
        Triangles triangles = random_triangles(40, 901 + std::uint64_t(round), round % 2 == 0 ? 0.8f : 0.3f);
        if (round % 3 == 0) append(triangles, sheet({-4, -4, 0.3f}, {8, 0, 0.1f}, {0, 8, 0}, 2, 2, {1, 2, 3, 255}));
        if (round % 5 == 0) append(triangles, random_triangles(10, 77, 30));
        View view = round % 4 == 3 ? looking_orthographic({1, 2, 3}) : looking({0.3, 0.2, 2.5}, random.in_cube(0.5f));
        constexpr int sizes[][2] = {{64, 64}, {65, 33}, {9, 20}};
        view = sized(view, sizes[round % 3][0], sizes[round % 3][1]);
        const LocalView local = local_view(std::span<const Triangle>(triangles), view);

        Image without;
        Triangles contents;
        for (int pass = 0; pass < 2; ++pass) {
            Source<Triangle> source{triangles, {}, std::uint32_t(triangles.size()), glm::dvec3(0), 0};
            source.id = renderer.upload(source);
            renderer.begin_frame(local);
            renderer.set_view(local);
            draw_all(renderer, source);
            for (int i = 0; pass == 0 && i < 80; ++i) {
                // Behind, among and in front of what was drawn, around the eye, behind it, off the screen.
                const glm::vec3 center =
                    i % 8 == 0   ? local.eye + random.in_cube(0.5f)
                    : i % 8 == 1 ? random.in_cube(6)
                                 : random.in_cube(1.2f) - (i % 3 == 0 ? glm::vec3(0, 0, 1.5f) : glm::vec3(0));
                const float size = std::exp2(-float(random.below(14)));
                const glm::vec3 half =
                    size * glm::vec3(random.unit(), random.unit(), i % 5 == 0 ? 0.0f : random.unit());
                const bool is_hidden = renderer.hidden(box_cell(center, half), {});
                ++(is_hidden ? hidden : seen);
                if (!is_hidden) continue;
                if (local.depth(center) > 0.1f) {
                    const SampleProjection to(local, 1);
                    const glm::vec3 p = to.project(center);
                    const float x = p.x * to.inverse_w(p.z) / 256, y = p.y * to.inverse_w(p.z) / 256;
                    inside_view +=
                        x > float(to.first_x) && x < float(to.end_x) && y > float(to.first_y) && y < float(to.end_y);
                }
                for (int k = 0; k < 12; ++k) {
                    Triangle t;
                    for (glm::vec3& v : t.vertices) {
                        const float x = inside_of(random, center.x, half.x), y = inside_of(random, center.y, half.y),
                                    z = inside_of(random, center.z, half.z);
                        v = {x, y, z};
                    }
                    t.rgba = {255, 255, 255, 255};
                    contents.push_back(t);
                }
            }
            if (pass == 1) {
                Source<Triangle> more{contents, {}, std::uint32_t(contents.size()), glm::dvec3(0), 0};
                more.id = renderer.upload(more);
                draw_all(renderer, more);
                renderer.release(more.id);
            }
            renderer.end_frame();
            renderer.release(source.id);
            if (pass == 0) without = renderer.image();
        }
        if (!(renderer.image() == without)) FAIL("round " << round);
    }
    CAPTURE(hidden, seen, inside_view);
    CHECK(std::min(hidden, seen) > 300);
    CHECK(inside_view > 200);
}

TEMPLATE_TEST_CASE("boxes behind a wall are hidden, and those before, beside and around it are not", "[raster]",
                   StrictPoints, StrictSamples, LazyPoints, CoverageRenderer) {
    TestType renderer;
    const Triangles wall = sheet({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 3, 3, {1, 2, 3, 255});
    constexpr bool is_lazy = TestType::facts.needs_ordering == OrderGuarantee::none;
    for (const View& view : {sized(looking({0, 0, 4}), 64, 64), sized(looking_orthographic({0, 0, 4}), 70, 50)}) {
        const LocalView local = local_view(std::span<const Triangle>(wall), view);
        Source<Triangle> source{wall, {}, std::uint32_t(wall.size()), glm::dvec3(0), 0};
        source.id = renderer.upload(source);
        renderer.begin_frame(local);
        renderer.set_view(local);
        const auto is_hidden = [&](glm::vec3 center, float half) {
            return renderer.hidden(box_cell(center, glm::vec3(half)), {});
        };
        CHECK_FALSE(is_hidden({0, 0, -1}, 0.1f));  // nothing is there yet
        draw_all(renderer, source);
        for (const float half : {0.5f, 0.1f, 0.01f, 1e-4f, 0.0f}) {
            CHECK(is_hidden({0, 0, -1}, half));
            CHECK(is_hidden({0.3f, -0.4f, -0.6f}, half));
            CHECK(is_hidden({30, 0, -1}, half));                                // off the screen
            if (local.is_perspective) CHECK_FALSE(is_hidden({0, 0, 4}, half));  // around the eye
        }
        CHECK(is_hidden({0, 0, -3}, 0.9f));
        for (const float half : {0.5f, 0.1f}) {
            CHECK_FALSE(is_hidden({1.2f, 0, -0.5f}, half));  // beside
            CHECK_FALSE(is_hidden({0, 0.95f, -0.5f}, half + 0.5f));
            CHECK(is_hidden({0, 0, 1}, half) == !is_lazy);  // whatever is drawn later is behind, if order is strict
            CHECK(is_hidden({0, 0, 0}, half) == !is_lazy);
        }
        CHECK_FALSE(is_hidden({0, 0, 0}, 2));
        CHECK_FALSE(is_hidden({0, 0, 0}, 1000));
        if (local.is_perspective) CHECK_FALSE(is_hidden({0, 0, 1e4f}, 1));  // behind the eye: may err towards this
        renderer.end_frame();
        renderer.release(source.id);
    }
}

TEST_CASE("a room along a corridor's wall is hidden, though its nearest corner is nearer than most of the wall",
          "[raster]") {
    for (const int parts : {1, 40}) {
        CAPTURE(parts);
        CoverageRenderer renderer;
        const Triangles wall = sheet({0.5f, -30, 3.5f}, {0, 0, -90}, {0, 60, 0}, parts, parts, {1, 2, 3, 255});
        const View view = sized(looking({0, 0, 4}, {0.6f, 0, -6}), 200, 160);
        const LocalView local = local_view(std::span<const Triangle>(wall), view);
        Source<Triangle> source{wall, {}, std::uint32_t(wall.size()), glm::dvec3(0), 0};
        source.id = renderer.upload(source);
        renderer.begin_frame(local);
        renderer.set_view(local);
        draw_all(renderer, source);
        const auto is_hidden = [&](glm::vec3 lower, glm::vec3 upper) {
            return renderer.hidden(box_cell((lower + upper) * 0.5f, (upper - lower) * 0.5f), {});
        };
        CHECK(is_hidden({0.6f, -1, -10}, {1.6f, 1, 2}));
        CHECK(is_hidden({0.6f, -0.2f, -4}, {4, 0.2f, 1}));
        CHECK_FALSE(is_hidden({0.4f, -1, -10}, {1.6f, 1, 2}));     // breaks through
        CHECK_FALSE(is_hidden({-0.3f, -1, -10}, {0.45f, 1, -1}));  // in the corridor
        CHECK_FALSE(is_hidden({0.5f, -0.2f, -4}, {4, 0.2f, 1}));   // touches it
        renderer.end_frame();
        renderer.release(source.id);
    }
}

TEST_CASE("a hierarchy culled by the renderer's answers gives the picture of all its primitives", "[raster]") {
    using Hierarchy = SpatialHierarchy<Octree, Exact, TriangleCount>;
    Triangles triangles = random_triangles(20000, 940, 0.03f);
    append(triangles, random_triangles(20, 941, 1.0f));
    append(triangles,
           sheet({-1.1f, -1.1f, 1.2f}, {2, 0, 0}, {0, 2, 0}, 4, 4, {50, 60, 70, 255}));  // a wall before them
    const std::span<const Triangle> all(triangles);
    const Hierarchy hierarchy = build<Hierarchy>(all);
    CoverageRenderer renderer;
    auto viewer = make_viewer(hierarchy, triangles, renderer);
    std::uint64_t hidden = 0;
    for (const View& view : views()) {
        hidden += viewer.frame(view).cells_hidden;
        CHECK(different_pixels(renderer.image(), plain_picture(all, view, {.samples = 64})) == 0);
    }
    CHECK(hidden > 0);
}

TEST_CASE("work is that of primitives and questions, and an empty frame is the background", "[raster]") {
    CoverageRenderer renderer({.background = {1, 2, 3, 4}});
    const View view = sized(looking({0, 0, 3}), 100, 60);
    const Triangles none, some = random_triangles(50, 910, 0.5f);
    const Image empty = picture(renderer, none, view);
    CHECK(std::count(empty.pixels().begin(), empty.pixels().end(), Rgba8{1, 2, 3, 4}) == 6000);
    CHECK(renderer.work().cells_tiled == 0);
    CHECK(renderer.work().polygons_tiled == 0);
    picture(renderer, some, view);
    CHECK(renderer.work().cells_tiled > 50);
    CHECK(renderer.work().polygons_tiled <= 50);
    CHECK(renderer.work().cells_asked == 0);

    const LocalView local = local_view(std::span<const Triangle>(some), sized(view, 512, 512));
    renderer.begin_frame(local);
    renderer.hidden(box_cell(glm::vec3(0), glm::vec3(0.5f)), {});
    CHECK(renderer.work().cells_asked > 0);
    CHECK(renderer.work().cells_tiled == 0);
    renderer.end_frame();
    CHECK(8 * double(renderer.pyramid_bytes()) / (4096.0 * 4096.0) == Approx(1 + 2.0 / 63).epsilon(1e-6));
}

TEST_CASE("images of no or too many samples are refused", "[raster]") {
    CoverageRenderer filtered;
    LazyPoints points;
    LocalView view(looking({0, 0, 3}), glm::dvec3(0), 1);
    for (const auto& [width, height] : {std::pair{0, 5}, {5, 0}, {-1, 5}, {3876, 5}, {5, 3876}}) {
        view.width = width, view.height = height;
        CHECK_THROWS_AS(filtered.begin_frame(view), std::invalid_argument);
    }
    view.width = 31001, view.height = 1;
    CHECK_THROWS_AS(points.begin_frame(view), std::invalid_argument);
    for (const auto& [width, height] : {std::pair{3875, 1}, {1, 3875}}) {
        const Triangles triangles = random_triangles(30, 920, 0.5f);
        const View wide = sized(looking({0, 0, 3}), width, height);
        const std::span<const Triangle> all(triangles);
        CHECK(different_pixels(picture(points, all, wide), plain_picture(all, wide)) == 0);
    }
}

TEST_CASE("sources come and go, and take each other's places", "[raster]") {
    CoverageRenderer renderer;
    const View view = looking({0, 0, 4});
    const Triangles a = random_triangles(20, 930, 0.5f), b = random_triangles(20, 931, 0.5f);
    Source<Triangle> first{a, {}, 20, glm::dvec3(0), 0}, second{b, {}, 20, glm::dvec3(0), 0};
    first.id = renderer.upload(first);
    second.id = renderer.upload(second);
    CHECK(first.id != second.id);
    renderer.release(first.id);
    first.id = renderer.upload(first);
    CHECK(first.id != second.id);
    Triangles both = a;
    append(both, b);
    const LocalView local = local_view(std::span<const Triangle>(both), view);
    renderer.begin_frame(local);
    renderer.set_view(local);
    const Range ranges[] = {{0, 5}, {5, 15}};
    renderer.draw(first, std::span<const Range>(ranges));
    renderer.draw(second, std::span<const Range>(ranges));
    renderer.end_frame();
    CHECK(different_pixels(renderer.image(), plain_picture(std::span<const Triangle>(both), view, {.samples = 64})) ==
          0);
}

}  // namespace farfield::test
