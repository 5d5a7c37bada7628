// Lazy masks show what a z-buffer of 64 samples a pixel shows, bit for bit, whatever the order of polygons and
// whichever hierarchy they come from.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
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
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

/// A quadrilateral as two triangles, either diagonal, each beginning anywhere.
void add_quadrilateral(Triangles& out, Random& random, const std::array<glm::vec3, 4>& q, Rgba8 color) {
    const unsigned first = random.below(4);
    const auto add = [&](unsigned a, unsigned b, unsigned c) {
        const std::array<unsigned, 3> of{a, b, c};
        const unsigned turn = random.below(3);
        Triangle t;
        for (unsigned i = 0; i < 3; ++i) t.vertices[i] = q[(first + of[(turn + i) % 3]) % 4];
        t.rgba = color;
        out.push_back(t);
    };
    add(0, 1, 2);
    add(0, 2, 3);
}

void add_box(Triangles& out, Random& random, glm::vec3 lower, glm::vec3 upper) {
    for (int axis = 0; axis < 3; ++axis) {
        for (const bool is_upper : {false, true}) {
            const int u = (axis + 1) % 3, v = (axis + 2) % 3;
            std::array<glm::vec3, 4> q;
            q.fill(lower);
            for (glm::vec3& corner : q) corner[axis] = is_upper ? upper[axis] : lower[axis];
            q[1][u] = q[2][u] = upper[u];
            q[2][v] = q[3][v] = upper[v];
            if (!is_upper) std::swap(q[1], q[3]);
            add_quadrilateral(out, random, q, random.color());
        }
    }
}

/// A floor and walls, and furniture that stands on it and touches.
Triangles furnished(Random& random) {
    Triangles out;
    add_box(out, random, {-1, -1.1f, -1}, {1, -1, 1});
    add_box(out, random, {-1.1f, -1, -1}, {-1, 1, 1});
    add_box(out, random, {-1, -1, -1.1f}, {1, 1, -1});
    for (int i = 0; i < 12; ++i) {
        const glm::vec3 at(random.between(-0.9f, 0.6f), -1, random.between(-0.9f, 0.6f));
        const glm::vec3 size(random.between(0.1f, 0.4f), random.between(0.1f, 0.8f), random.between(0.1f, 0.4f));
        add_box(out, random, at, at + size);
        if (i % 3 == 0) add_box(out, random, at + glm::vec3(0, size.y, 0), at + size + glm::vec3(0, 0.2f, 0));
    }
    return out;
}

/// Boxes that nothing touches.
Triangles apart(Random& random) {
    Triangles out;
    for (int i = 0; i < 27; ++i) {
        const glm::vec3 cell = glm::vec3(float(i % 3), float(i / 3 % 3), float(i / 9)) * 0.66f - 1.0f;
        const glm::vec3 lower =
            cell + glm::vec3(random.between(0.02f, 0.2f), random.between(0.02f, 0.2f), random.between(0.02f, 0.2f));
        add_box(
            out, random, lower,
            lower + glm::vec3(random.between(0.05f, 0.4f), random.between(0.05f, 0.4f), random.between(0.05f, 0.4f)));
    }
    return out;
}

/// Fifty layers in one plane, of rectangles and of triangles turned in it, some of them the same.
Triangles layers(Random& random) {
    Triangles out;
    const glm::vec3 u(0.9f, 0.1f, 0.3f), v(-0.2f, 0.8f, 0.1f);
    for (int i = 0; i < 50; ++i) {
        const auto at = [&] { return u * random.between(-1, 1) + v * random.between(-1, 1); };
        if (i % 2 == 0) {
            out.push_back({{at(), at(), at()}, random.color()});
            continue;
        }
        const float a = random.between(-1, 0), b = random.between(0.1f, 1), c = random.between(-1, 0),
                    d = random.between(0.1f, 1);
        add_quadrilateral(out, random, {u * a + v * c, u * b + v * c, u * b + v * d, u * a + v * d}, random.color());
        if (i % 10 == 1) {
            out.push_back(out.back());
            out.back().rgba = random.color();
        }
    }
    return out;
}

/// Blades around a center, each over the next one, through a cloud of triangles that go through each other.
Triangles in_circles(Random& random) {
    Triangles out = random_triangles(40, random.bits(), 0.6f);
    for (int i = 0; i < 6; ++i) {
        const float turn = 1.0471976f * float(i);
        const auto at = [&](float along, float across, float z) {
            return glm::vec3(along * std::cos(turn) - across * std::sin(turn),
                             along * std::sin(turn) + across * std::cos(turn), z);
        };
        add_quadrilateral(out, random, {at(-1, 0.1f, -0.3f), at(1, 0.1f, 0.3f), at(1, 0.5f, 0.3f), at(-1, 0.5f, -0.3f)},
                          random.color());
    }
    return out;
}

/// Quadrilaterals, plane and bent, near each other.
Triangles quadrilaterals(Random& random) {
    Triangles out;
    for (int i = 0; i < 50; ++i) {
        const glm::vec3 at = random.in_cube(0.7f), u = random.in_cube(0.6f), v = random.in_cube(0.6f);
        std::array<glm::vec3, 4> q{at, at + u, at + u + v, at + v};
        if (i % 4 == 1) q[2] = at + 0.51f * (u + v);
        if (i % 4 == 2) q[2] += random.in_cube(0.01f);
        if (i % 8 == 3) q[2] = at + 0.3f * (u + v);
        add_quadrilateral(out, random, q, random.color());
    }
    return out;
}

constexpr std::size_t scene_count = 5;
Triangles scene_of(std::size_t kind, Random& random) {
    Triangles t = kind == 0   ? furnished(random)
                  : kind == 1 ? layers(random)
                  : kind == 2 ? in_circles(random)
                  : kind == 3 ? quadrilaterals(random)
                              : apart(random);
    for (Triangle& one : t) one.rgba.a = 255;
    return t;
}

View view_of(Random& random, std::size_t kind) {
    const glm::dvec3 eye = kind == 0
                               ? glm::dvec3(random.between(-0.5f, 2), random.between(-0.8f, 1), random.between(0.8f, 3))
                               : glm::dvec3(random.in_cube(1)) * 1.5 + glm::dvec3(0.1, 0.2, 2.0);
    View view = random.below(4) == 0 ? looking_orthographic(eye, glm::dvec3(random.in_cube(0.3f)))
                                     : looking(eye, glm::dvec3(random.in_cube(0.3f)));
    view.width = 40 + int(random.below(60));
    view.height = 40 + int(random.below(60));
    return view;
}

template <class R, class H, class P, class Options>
Image picture(const H& hierarchy, const P& primitives, const View& view, const Options& options) {
    R renderer(options);
    auto viewer = make_viewer(hierarchy, primitives, renderer);
    viewer.frame(view);
    return renderer.image();
}

template <class Partition>
using Exactly = SpatialHierarchy<Partition, Exact, TriangleCount>;

}  // namespace

TEMPLATE_TEST_CASE("lazy masks are a z-buffer, whatever crosses, touches, and comes when", "[promises]",
                   Exactly<Octree>, Exactly<SharedOctree>, Exactly<PolygonBsp>, (Exactly<Nested<Octree, PolygonBsp>>)) {
    Random random(4100);
    for (std::size_t kind = 0; kind < scene_count; ++kind) {
        for (int round = 0; round < 3; ++round) {
            Triangles triangles = scene_of(kind, random);
            for (const int order : {0, 1, 2}) {
                if (order == 1) std::reverse(triangles.begin(), triangles.end());
                if (order == 2) random.shuffle(triangles);
                const auto hierarchy = build<TestType>(triangles);
                for (int i = 0; i < 3; ++i) {
                    const View view = view_of(random, kind);
                    const Image expected =
                        picture<ZBufferRenderer>(hierarchy, triangles, view, ZBufferOptions{.samples = 64});
                    const Image masks = picture<CoverageRenderer>(hierarchy, triangles, view, CoverageOptions{});
                    INFO("kind " << kind << ", round " << round << ", order " << order << ", view " << i);
                    CHECK(different_pixels(masks, expected) == 0);
                }
            }
        }
    }
}

TEMPLATE_TEST_CASE("strict masks are a z-buffer where nothing crosses and nothing ties", "[promises]",
                   Exactly<PolygonBsp>, (Exactly<Nested<Octree, PolygonBsp>>)) {
    Random random(4200);
    for (int round = 0; round < 12; ++round) {
        const Triangles triangles = scene_of(4, random);
        const auto hierarchy = build<TestType>(triangles);
        REQUIRE(hierarchy.keeps_strict_order());
        for (int i = 0; i < 3; ++i) {
            const View view = view_of(random, 4);
            const Image expected = picture<ZBufferRenderer>(hierarchy, triangles, view, ZBufferOptions{.samples = 64});
            const Image masks = picture<StrictCoverageRenderer>(hierarchy, triangles, view, CoverageOptions{});
            INFO("round " << round << ", view " << i);
            CHECK(different_pixels(masks, expected) == 0);
        }
    }
}
