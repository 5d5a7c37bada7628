// Software says what is hidden and another renderer shades: the same picture of less.
#include "opengl/culled_in_software.hpp"

#include <cstdint>
#include <vector>

#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/measure/flip.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "opengl/setting.hpp"

using namespace farfield;
using namespace farfield::test;
using opengl::CulledByCoverage;
using opengl::CulledInSoftware;
using opengl::GlRenderer;

static_assert(Renderer<CulledByCoverage<GlRenderer>, Triangle>);
static_assert(Renderer<CulledInSoftware<GlRenderer>, Triangle>);
static_assert(CulledInSoftware<GlRenderer>::facts.slices_images && CulledInSoftware<GlRenderer>::facts.shares_sources);

namespace {

/// Walls one behind the other, of many triangles, each a little larger than the one before it.
std::vector<Triangle> walls(int count, int squares) {
    std::vector<Triangle> out;
    for (int wall = 0; wall < count; ++wall) {
        const float z = -float(wall), half = 1 + 0.02f * float(wall);
        const auto at = [&](int x, int y) {
            return glm::vec3(half * (2 * float(x) / float(squares) - 1), half * (2 * float(y) / float(squares) - 1), z);
        };
        for (int y = 0; y < squares; ++y) {
            for (int x = 0; x < squares; ++x) {
                const auto shade = std::uint8_t(60 + (x * 31 + y * 17 + wall * 7) % 190);
                const Rgba8 color{shade, std::uint8_t(255 - shade), std::uint8_t(40 * wall % 256), 255};
                out.push_back({{at(x, y), at(x + 1, y), at(x + 1, y + 1)}, color});
                out.push_back({{at(x, y), at(x + 1, y + 1), at(x, y + 1)}, color});
            }
        }
    }
    return out;
}

const View view{.camera = Camera::perspective({0.1, 0.2, 3}, {0, 0, 0}, {0, 1, 0}, 0.9f), .width = 160, .height = 120};

template <class H, class R>
FrameStats draw(const H& hierarchy, const std::vector<Triangle>& triangles, R& renderer) {
    auto viewer = make_viewer(hierarchy, triangles, renderer);
    return viewer.frame(view);
}

/// By one alone and with what is hidden left out.
template <class H, class R>
void check_less_of_the_same(const H& hierarchy, const std::vector<Triangle>& triangles, R& renderer) {
    const FrameStats all = draw(hierarchy, triangles, renderer);
    const Image alone = renderer.image();
    CulledByCoverage culled(renderer);
    const FrameStats seen = draw(hierarchy, triangles, culled);
    CHECK(flip(renderer.image(), alone) < 0.001);
    CHECK(seen.cells_hidden > 0);
    CHECK(seen.primitives + seen.approximations < (all.primitives + all.approximations) / 2);
}

}  // namespace

TEST_CASE("what coverage masks say is hidden is not shaded, and not missed", "[opengl]") {
    const std::vector<Triangle> triangles = walls(12, 24);
    const auto exact = build<SpatialHierarchy<Octree, Exact, TriangleCount>>(triangles);
    SECTION("by a renderer of the library") {
        ZBufferRenderer renderer;
        check_less_of_the_same(exact, triangles, renderer);
    }
    SECTION("by OpenGL") {
        OpenGl gl;
        if (!gl) return;
        {
            GlRenderer renderer;
            check_less_of_the_same(exact, triangles, renderer);
        }
        gl.check_clean();
    }
}

TEST_CASE("stand-ins are shaded too", "[opengl]") {
    OpenGl gl;
    if (!gl) return;
    {
        const std::vector<Triangle> triangles = walls(12, 24);
        const auto cubes = build<SpatialHierarchy<Octree, ColorCube, TriangleCount>>(triangles);
        GlRenderer renderer;
        CulledByCoverage culled(renderer);
        auto viewer = make_viewer(cubes, triangles, culled);
        View far_off = view;
        far_off.tolerance_px = 40;
        CHECK(viewer.frame(far_off).approximations > 0);
        const Image by_both = renderer.image();
        auto plain = make_viewer(cubes, triangles, renderer);
        plain.frame(far_off);
        CHECK(flip(by_both, renderer.image()) < 0.01);
    }
    gl.check_clean();
}

TEST_CASE("deposits hide what stands in behind them", "[opengl]") {
    OpenGl gl;
    if (!gl) return;
    {
        // Too small for geometry to hide any.
        const std::vector<Triangle> triangles = walls(40, 24);
        const auto tensors = build<SpatialHierarchy<Octree, OpacityTensor, TriangleCount>>(triangles);
        View far_off = view;
        far_off.camera = Camera::perspective({9, 12, 180}, {0, 0, -20}, {0, 1, 0}, 0.2f);
        far_off.tolerance_px = 1.5f;
        for (const int samples : {1, 4}) {
            GlRenderer alone({.samples = samples}), shading({.samples = samples});
            CulledInSoftware culled(shading, ZBufferOptions{.samples = samples});
            auto plain = make_viewer(tensors, triangles, alone);
            auto viewer = make_viewer(tensors, triangles, culled);
            const std::uint64_t all = plain.frame(far_off).splats;
            viewer.frame(far_off);
            INFO(samples << " samples, " << all << " splats, of which come " << culled.stats().stand_ins
                         << " and are seen " << culled.stats().seen);
            CHECK(culled.stats().seen > 0);
            CHECK(culled.stats().seen < all / 2);
            CHECK(culled.stats().seen <= culled.stats().stand_ins);
            CHECK(flip(shading.image(), alone.image()) < 0.005);
            // What is drawn exactly is not drawn twice, and nothing is missing.
            View exactly = far_off;
            exactly.tolerance_px = 0;
            plain.frame(exactly);
            CHECK(viewer.frame(exactly).cells_hidden == 0);
            CHECK(shading.image() == alone.image());
        }
    }
    gl.check_clean();
}
