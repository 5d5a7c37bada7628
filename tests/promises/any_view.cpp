// Where the eye stands, how large the unit is and how far a corner lies change nothing that is not there to be seen.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/partition/polygon_bsp.hpp"
#include "farfield/primitive/instance.hpp"
#include "farfield/renderer/hierarchical_z_renderer.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "scenes/renderers/coverage_tilers.hpp"
#include "support/pictures.hpp"
#include "support/random.hpp"
#include "support/scenes.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

using Plain = SpatialHierarchy<Octree, Exact, TriangleCount>;
using Bsp = SpatialHierarchy<PolygonBsp, Exact, TriangleCount>;

struct Quadrilateral {
    std::array<glm::vec3, 4> vertices;
    Rgba8 rgba;
    Box bounds() const {
        Box b = Box::empty();
        for (const glm::vec3 p : vertices) b.add(p);
        return b;
    }
    template <class Sink>
    void polygons(Sink&& sink) const {
        sink(Polygon{vertices, {&rgba, 1}});
    }
};

template <class R, class H, class P>
Image picture(const H& h, const std::vector<P>& primitives, const View& view, R&& renderer = R()) {
    auto viewer = make_viewer(h, primitives, renderer);
    viewer.frame(view);
    return renderer.image();
}

/// The same by three renderers.
template <class H, class P>
std::array<Image, 3> pictures(const H& h, const std::vector<P>& primitives, const View& view) {
    return {picture<ZBufferRenderer>(h, primitives, view), picture<HierarchicalZRenderer>(h, primitives, view),
            picture<CoverageRenderer>(h, primitives, view)};
}

int blue_pixels(const Image& image) {
    return int(std::count_if(image.pixels().begin(), image.pixels().end(), [](Rgba8 c) { return c.b > 100; }));
}
int covered_pixels(const Image& image) {
    return int(std::count_if(image.pixels().begin(), image.pixels().end(), [](Rgba8 c) { return c.a != 0; }));
}

/// A blue sheet close behind a red one.
Triangles sheets(float gap) {
    Triangles t = sheet({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 8, 8, {0, 0, 220, 255});
    append(t, sheet({-1, -1, gap}, {2, 0, 0}, {0, 2, 0}, 8, 8, {220, 0, 0, 255}));
    return t;
}

}  // namespace

TEST_CASE("how far back the eye stands does not change which of two sheets is in front") {
    for (const float gap : {1e-2f, 1e-3f, 1e-4f}) {
        const Triangles triangles = sheets(gap);
        const auto h = build<Plain>(std::span<const Triangle>(triangles));
        Similarity placed;
        placed.translation = {5, 0, 0};
        const std::vector<Instance<Plain, Triangle>> instances{{&h, triangles, placed}};
        const auto outer = build<Plain>(std::span<const Instance<Plain, Triangle>>(instances));
        for (const double distance : {4.0, 20.0, 100.0, 1e3, 1e5, 1e7, 1e10}) {
            INFO("gap " << gap << ", eye " << distance << " away");
            const glm::dvec3 back = glm::normalize(glm::dvec3(0.3, 0.2, 1)) * distance;
            View view = looking_orthographic(back, {}, 1);
            for (const Image& image : pictures(h, triangles, view)) {
                CHECK(blue_pixels(image) == 0);
                CHECK(covered_pixels(image) == view.width * view.height);
            }
            const glm::dvec3 there(5, 0, 0);
            for (const Image& image : pictures(outer, instances, looking_orthographic(there + back, there, 1)))
                CHECK(blue_pixels(image) == 0);
            view.camera = Camera::perspective(back, {}, {0, 1, 0}, float(2 * std::atan(0.5 / distance)));
            for (const Image& image : pictures(h, triangles, view)) {
                CHECK(blue_pixels(image) == 0);
                CHECK(covered_pixels(image) == view.width * view.height);
            }
        }
    }
}

TEST_CASE("things near the eye are seen however large the scene is") {
    const Triangles ball = sphere({0, 0, 0}, 0.5f, 8, {200, 120, 60, 255});
    const View view = looking({1, 1, 2});
    const auto alone = build<Plain>(std::span<const Triangle>(ball));
    const auto seen = pictures(alone, ball, view);
    for (const float away : {1e3f, 1e5f, 1e7f}) {
        Triangles triangles = ball;
        triangles.push_back({{{{away, away, away}, {away + 1, away, away}, {away, away + 1, away}}}, {255, 0, 0, 255}});
        const auto h = build<Plain>(std::span<const Triangle>(triangles));
        const auto found = pictures(h, triangles, view);
        for (std::size_t i = 0; i < seen.size(); ++i)
            CHECK(std::abs(covered_pixels(found[i]) - covered_pixels(seen[i])) < 40);
    }
}

TEST_CASE("panes of glass hide as much as instances as they do as triangles") {
    const Rgba8 glass{0, 200, 0, 128};
    const Triangles pane = sheet({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 1, 1, glass);
    const auto inner = build<Plain>(std::span<const Triangle>(pane));
    for (const int count : {1, 2, 4, 8}) {
        std::vector<Instance<Plain, Triangle>> instances;
        for (int k = 0; k < count; ++k) {
            Similarity placed;
            placed.translation = {0, 0, -0.3 * k};
            instances.push_back({&inner, pane, placed});
        }
        const auto h = build<Plain>(std::span<const Instance<Plain, Triangle>>(instances));
        View view = looking({0, 0, 3}, {}, 64);
        view.camera = Camera::perspective({0, 0, 3}, {}, {0, 1, 0}, 0.3f);
        const double right = 1 - std::pow(0.5, count), pixels = 64 * 64;
        CHECK(std::abs(coverage(picture(h, instances, view, ZBufferRenderer({.samples = 16}))) / pixels - right) <
              0.02);
        CHECK(std::abs(coverage(picture<CoverageRenderer>(h, instances, view)) / pixels - right) < 0.02);
        // The same in every frame, and in every viewer.
        CHECK(picture<CoverageRenderer>(h, instances, view) == picture<CoverageRenderer>(h, instances, view));
    }
}

TEST_CASE("corners as far away as single precision goes are clipped, from every side") {
    Random random(941);
    for (int round = 0; round < 300; ++round) {
        const float huge = std::ldexp(1.0f, int(random.below(150)) - 26);
        Triangles triangles = random_triangles(3, 942 + std::uint64_t(round), 1);
        for (Triangle& t : triangles) {
            t.vertices[random.below(3)][int(random.below(3))] = random.below(2) != 0 ? huge : -huge;
        }
        const auto h = build<Plain>(std::span<const Triangle>(triangles));
        View view = looking(random.in_cube(2), random.in_cube(2), 24);
        view.camera = Camera::perspective(random.in_cube(2), random.in_cube(2), random.direction(),
                                          random.below(2) != 0 ? 0.01f : 1.5f);
        view.camera.near_depth = std::array<float, 4>{0, 1e-38f, 0.0625f, 1e20f}[random.below(4)];
        INFO("round " << round);
        const Image one = picture(h, triangles, view, ZBufferRenderer({.samples = 64}));
        CHECK(one == picture(h, triangles, view, HierarchicalZRenderer({.samples = 64})));
        CHECK(one == picture<CoverageRenderer>(h, triangles, view));
    }
}

TEST_CASE("quadrilaterals that cross are drawn by masks as by a z-buffer, also pieces of them") {
    Random random(943);
    for (int round = 0; round < 150; ++round) {
        std::vector<Quadrilateral> quads;
        for (int i = 0; i < 2; ++i) {
            const glm::vec3 o = random.in_cube(0.3f), a = random.in_cube(1), b = random.in_cube(1);
            quads.push_back({{o - a - b, o + a - b, o + a + b, o - a + b}, random.color()});
        }
        View view = looking({3, 1, 2}, {}, 32);
        if (round % 3 == 1) view = looking(random.in_cube(0.5f), random.in_cube(1), 32);  // clipped
        if (round % 3 == 2) view = looking_orthographic({3, 1, 2}, {}, 2, 32);
        const ZBufferOptions options{.samples = 64, .light = DirectionalLight{}};
        const CoverageOptions masks{.light = DirectionalLight{}};
        INFO("round " << round);
        const auto h = build<Plain>(std::span<const Quadrilateral>(quads));
        CHECK(picture(h, quads, view, ZBufferRenderer(options)) == picture(h, quads, view, CoverageRenderer(masks)));
        const auto bsp = build<Bsp>(std::span<const Quadrilateral>(quads));
        CHECK(picture(bsp, quads, view, ZBufferRenderer(options)) ==
              picture(bsp, quads, view, CoverageRenderer(masks)));
    }
}

TEST_CASE("a scene in units of any power of two is drawn alike by every renderer, lit or not") {
    const Triangles triangles = mixed_triangles(600, 944);
    const auto h = build<Plain>(std::span<const Triangle>(triangles));
    const auto bsp = build<Bsp>(std::span<const Triangle>(triangles));
    const auto view_of = [](double unit, bool perspective) {
        return perspective ? looking(glm::dvec3(2, 3, 4) * unit, {}, 64)
                           : looking_orthographic(glm::dvec3(2, 3, 4) * unit, {}, float(2 * unit), 64);
    };
    const std::optional<DirectionalLight> light = DirectionalLight{};
    for (const int exponent : {-100, -66, -33, 36, 63, 100}) {
        const float unit = std::ldexp(1.0f, exponent);
        const Triangles other_triangles = moved(triangles, unit);
        const auto other = build<Plain>(std::span<const Triangle>(other_triangles));
        const auto other_bsp = build<Bsp>(std::span<const Triangle>(other_triangles));
        for (const bool perspective : {true, false}) {
            INFO("2^" << exponent << (perspective ? ", perspective" : ", orthographic"));
            const View here = view_of(1, perspective), there = view_of(double(unit), perspective);
            const auto same = [&](const auto& renderer) {
                CHECK(picture(h, triangles, here, renderer()) == picture(other, other_triangles, there, renderer()));
                CHECK(picture(bsp, triangles, here, renderer()) ==
                      picture(other_bsp, other_triangles, there, renderer()));
            };
            same([&] { return ZBufferRenderer({.samples = 4, .light = light}); });
            same([&] { return HierarchicalZRenderer({.samples = 4, .light = light}); });
            same([&] { return CoverageRenderer({.light = light}); });
        }
    }
}
