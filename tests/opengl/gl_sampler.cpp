// Samples taken by OpenGL are those of GridSampler but at edges, and so are the color cubes made of them.
#include "opengl/gl_sampler.hpp"

#include <cstdlib>
#include <numeric>
#include <random>
#include <span>
#include <stdexcept>
#include <vector>

#include "farfield/approximation/color_cube.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/measure/flip.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/sampler/grid_sampler.hpp"
#include "farfield/viewer.hpp"
#include "opengl/setting.hpp"

using namespace farfield;
using namespace farfield::test;
using opengl::GlSampler;

static_assert(OrthographicSampler<GlSampler>);
static_assert(LightsPolygons<GlSampler> && TellsItsLight<GlSampler>);

namespace {

std::vector<Triangle> strewn(std::size_t count, float size, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> in(-1, 1);
    const auto point = [&] {
        const float x = in(random), y = in(random), z = in(random);
        return glm::vec3(x, y, z);
    };
    std::vector<Triangle> out(count);
    for (Triangle& t : out) {
        const glm::vec3 p = point(), q = p + size * point(), r = p + size * point();
        t.vertices = {p, q, r};
        const auto byte = [&] { return std::uint8_t(random() >> 8); };
        const std::uint8_t red = byte(), green = byte(), blue = byte();
        t.rgba = {red, green, blue, 255};
    }
    return out;
}

template <class Sampler>
std::vector<Rgba8> samples_of(Sampler& sampler, const SampleGrid& grid, const std::vector<Triangle>& triangles) {
    std::vector<Rgba8> out(grid.size(), Rgba8{1, 2, 3, 4});
    sampler.sample(
        grid,
        [&](auto&& sink) {
            for (const Triangle& t : triangles) sink(Polygon{t.vertices, {&t.rgba, 1}});
        },
        std::span(out));
    return out;
}

/// The part of samples that differ by more than rounding.
double part_that_differs(const std::vector<Rgba8>& a, const std::vector<Rgba8>& b) {
    std::size_t differ = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const Rgba8 p = a[i], q = b[i];
        differ += std::abs(p.r - q.r) > 1 || std::abs(p.g - q.g) > 1 || std::abs(p.b - q.b) > 1 || p.a != q.a;
    }
    return double(differ) / double(a.size());
}

}  // namespace

TEST_CASE("samples are those of the built-in sampler, of all sides and slabs, with light and without", "[opengl]") {
    OpenGl gl;
    if (!gl) return;
    {
        const std::vector<Triangle> triangles = strewn(60, 0.9f, 1);
        const Box box{{-0.7f, -0.5f, -0.9f}, {0.6f, 0.8f, 0.4f}};
        for (const bool is_lit : {false, true}) {
            const auto light = is_lit ? std::optional<DirectionalLight>(DirectionalLight{}) : std::nullopt;
            GlSampler ours(light);
            GridSampler exact;
            exact.light = light;
            for (const unsigned n : {1u, 4u, 16u, 64u}) {
                for (const unsigned slabs : {1u, 3u, 8u}) {
                    const SampleGrid grid{box, n, slabs};
                    const auto a = samples_of(ours, grid, triangles), b = samples_of(exact, grid, triangles);
                    CAPTURE(n, slabs, is_lit);
                    if (n >= 16) CHECK(part_that_differs(a, b) < 0.005);
                    CHECK(part_that_differs(a, b) < 0.2);
                }
            }
        }
    }
    gl.check_clean();
}

TEST_CASE("one triangle is seen from its two sides, in their light, and behind none", "[opengl]") {
    OpenGl gl;
    if (!gl) return;
    {
        const std::vector<Triangle> triangles{
            {{glm::vec3{-9, 0.25f, -9}, {-9, 0.25f, 9}, {19, 0.25f, 0}}, {200, 100, 50}},
            {{glm::vec3{-9, 0.75f, -9}, {-9, 0.75f, 9}, {19, 0.75f, 0}}, {0, 0, 99, 0}},
            {{glm::vec3{-9, 7, -9}, {-9, 7, 9}, {19, 7, 0}}, {1, 1, 1}}};
        const DirectionalLight light{{0, 1, 0}, 0.25f, 0.5f};
        GlSampler sampler(light);
        const SampleGrid grid{Box{{0, 0, 0}, {1, 1, 1}}, 2, 2};
        const auto samples = samples_of(sampler, grid, triangles);
        for (unsigned side = 0; side < 6; ++side) {
            for (unsigned slab = 0; slab < 2; ++slab) {
                for (unsigned at = 0; at < 4; ++at) {
                    const Rgba8 c = samples[grid.index(side, slab, at / 2, at % 2)];
                    CAPTURE(side, slab, at);
                    const bool is_seen = (side == 2 || side == 3) && slab == 0;
                    CHECK(c == (!is_seen ? Rgba8{0, 0, 0, 0} : scaled({200, 100, 50, 255}, side == 3 ? 0.75f : 0.25f)));
                }
            }
        }
        CHECK(samples_of(sampler, grid, {}) == std::vector<Rgba8>(grid.size(), Rgba8{0, 0, 0, 0}));
        // A box without extent along an axis.
        const SampleGrid flat{Box{{0, 0.25f, 0}, {1, 0.25f, 1}}, 2, 1};
        GridSampler exact(light);
        CHECK(samples_of(sampler, flat, triangles) == samples_of(exact, flat, triangles));
        CHECK_THROWS_AS(samples_of(sampler, SampleGrid{grid.box, 1u << 14, 1}, triangles), std::runtime_error);
    }
    gl.check_clean();
}

TEST_CASE("color cubes are built with the samples of OpenGL", "[opengl]") {
    OpenGl gl;
    if (!gl) return;
    {
        using Hierarchy = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
        const std::vector<Triangle> triangles = strewn(3000, 0.1f, 2);
        const auto exact = build<Hierarchy>(triangles);
        const auto ours = build<Hierarchy>(triangles, BuildOptions<Hierarchy, GlSampler>{.sampler = GlSampler()});
        REQUIRE(ours.nodes().size() == exact.nodes().size());
        const auto picture = [&](const Hierarchy& h) {
            ZBufferRenderer renderer;
            auto viewer = make_viewer(h, triangles, renderer);
            const auto camera = Camera::perspective({0, 1, 8}, {0, 0, 0}, {0, 1, 0}, 0.5f);
            const auto stats = viewer.frame({.camera = camera, .width = 128, .height = 96, .tolerance_px = 24});
            CHECK(stats.approximations > 10);
            return renderer.image();
        };
        CHECK(flip(picture(ours), picture(exact)) < 0.01);
    }
    gl.check_clean();
}
