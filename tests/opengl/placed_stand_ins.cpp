// Stand-ins that are shaped on the GPU: the same picture as by the processor, and little to send.
#include <algorithm>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/vec3.hpp>
#include <iterator>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/measure/flip.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/instance.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/viewer.hpp"
#include "opengl/culled_in_software.hpp"
#include "opengl/setting.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;
using opengl::GlRenderer;

namespace {

/// Leaves in the left half, a closed surface in the right: all laws.
std::vector<Triangle> leaves_and_a_ball(std::size_t count, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> in(-1, 1);
    const auto point = [&] { return glm::vec3(in(random), in(random), in(random)); };
    std::vector<Triangle> out;
    for (std::size_t i = 0; i < count / 2; ++i) {
        const glm::vec3 p = 0.6f * point() - glm::vec3(0.8f, 0, 0);
        out.push_back({{p, p + 0.02f * point(), p + 0.02f * point()}, {std::uint8_t(random() >> 8), 150, 40, 255}});
    }
    const int rows = int(std::sqrt(float(count) / 4));
    const auto on_ball = [&](int i, int j) {
        const float u = 6.2831853f * float(i) / float(rows), v = 3.1415927f * float(j) / float(rows);
        return glm::vec3(0.8f, 0, 0) +
               0.6f * glm::vec3(std::sin(v) * std::cos(u), std::cos(v), std::sin(v) * std::sin(u));
    };
    for (int i = 0; i < rows; ++i) {
        for (int j = 0; j < rows; ++j) {
            const glm::vec3 a = on_ball(i, j), b = on_ball(i + 1, j), c = on_ball(i, j + 1), d = on_ball(i + 1, j + 1);
            const Rgba8 color{200, std::uint8_t(5 * (i % 40)), 90, 255};
            out.push_back({{a, b, d}, color});
            out.push_back({{a, d, c}, color});
        }
    }
    return out;
}

template <class A>
using HierarchyOf = SpatialHierarchy<Octree, A, TriangleCount>;

/// What is in one sorted list and not in the other.
std::size_t difference(const std::vector<std::uint32_t>& a, const std::vector<std::uint32_t>& b) {
    std::vector<std::uint32_t> out;
    std::set_symmetric_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(out));
    return out.size();
}

}  // namespace

TEMPLATE_TEST_CASE("OpenGL makes the splats of stand-ins that the processor makes", "[opengl]", OpacityTensor,
                   ColorCube) {
    OpenGl gl;
    if (!gl) return;
    {
        const auto triangles = leaves_and_a_ball(20'000, 1);
        TestType policy;
        const auto closed = GENERATE(false, true);
        if constexpr (requires { policy.closed_surfaces; }) policy.closed_surfaces = closed;
        const auto hierarchy = build<HierarchyOf<TestType>>(triangles, {.approximation = policy});
        View perspective = looking({3, 2, 10}, {}, 96, 2);
        View along = looking({14, 0.2, 0.1}, {}, 96, 2), inside = looking({-0.8, 0.1, 0.05}, {1, 0, 0}, 96, 2);
        View cut = perspective, mirrored = perspective, shifted = perspective;
        cut.camera.near_depth = 10.4f, cut.camera.far_depth = 11;
        mirrored.camera.right = -mirrored.camera.right;
        shifted.camera.off_center = {0.4, -0.3};
        View zoomed = looking({2e4, 1e4, 3e4}, {}, 96, 2);
        zoomed.camera.half_height = 4e-5f;
        const View parallel = looking_orthographic({1, 2, 3}, {}, 2, 96, 2), tile = perspective.tile(10, 20, 60, 50);
        for (const int samples : {1, 4}) {
            GlRenderer there({.samples = samples}), here({.samples = samples, .shapes_stand_ins = false});
            auto by_gpu = make_viewer(hierarchy, triangles, there),
                 by_processor = make_viewer(hierarchy, triangles, here);
            int i = 0;
            std::uint64_t splats = 0;
            for (View view : {perspective, along, inside, cut, mirrored, shifted, zoomed, parallel, tile}) {
                view.tolerance_px = samples == 1 ? 2.0f : 1.0f;  // as large as cubes are splats
                const FrameStats stats = by_gpu.frame(view);
                by_processor.frame(view);
                INFO("view " << i++ << ", " << samples << " samples, " << stats.splats << " splats, closed " << closed);
                splats += stats.splats;
                CHECK(mean_difference(there.image(), here.image()) < 0.0004);
                // A cube whose opacity is where one law ends may be rounded to the other.
                CHECK(flip(there.image(), here.image()) < 0.006);
            }
            CHECK(splats > (samples == 1 ? 2000 : 100));
        }
    }
    gl.check_clean();
}

TEST_CASE("OpenGL is sent what comes into the cut, and not what stays", "[opengl]") {
    OpenGl gl;
    if (!gl) return;
    {
        const auto triangles = leaves_and_a_ball(60'000, 2);
        const auto hierarchy = build<HierarchyOf<OpacityTensor>>(triangles);
        GlRenderer renderer;
        auto viewer = make_viewer(hierarchy, triangles, renderer);
        View view = looking({0.3, 0.4, 7}, {}, 300, 4);
        const auto cut_of = [&] {
            std::vector<std::uint32_t> nodes;
            viewer.select(view).for_each([&](const auto&, const Selected& s) {
                if (s.kind == Selected::Kind::stand_in) nodes.push_back(s.subtree.node);
            });
            std::sort(nodes.begin(), nodes.end());
            return nodes;
        };
        std::vector<std::uint32_t> before = cut_of();
        FrameStats stats = viewer.frame(view);
        REQUIRE(stats.splats > 1000);
        CHECK(renderer.stats().uploaded_bytes > 32 * stats.splats);
        const Image first = renderer.image();
        for (int i = 0; i < 3; ++i) {
            viewer.frame(view);
            CHECK(renderer.stats().uploaded_bytes == 0);
            CHECK(renderer.image() == first);
        }
        std::size_t changed = 0, all = 0, sent = 0;
        for (const double step : {1e-4, 1e-3, 3e-3, 1e-2}) {
            view.camera.eye += glm::dvec3(0.3, 0.1, -1) * step;
            stats = viewer.frame(view);
            const std::vector<std::uint32_t> now = cut_of();
            const std::size_t of_cut = difference(before, now);
            INFO(renderer.stats().uploaded_bytes << " bytes, where " << of_cut << " of " << now.size()
                                                 << " stand-ins are others");
            // A record, and the list of its chunk, where the cut is another; and the view, and commands that move up.
            CHECK(renderer.stats().uploaded_bytes < 200 * of_cut + 12'000);
            before = now;
            changed += of_cut;
            all += now.size();
            sent += renderer.stats().uploaded_bytes;
        }
        CHECK(changed > 10);
        CHECK(sent < 6 * all);
        // What was shown before is there still, but for lists.
        view.camera.eye -= glm::dvec3(0.3, 0.1, -1) * 1e-2;
        viewer.frame(view);
        CHECK(renderer.stats().uploaded_bytes < 12'000);
    }
    gl.check_clean();
}

TEST_CASE("OpenGL draws placed stand-ins that software does not hide", "[opengl]") {
    OpenGl gl;
    if (!gl) return;
    {
        const auto triangles = leaves_and_a_ball(20'000, 3);
        const auto tensors = build<HierarchyOf<OpacityTensor>>(triangles);
        const auto cubes = build<HierarchyOf<ColorCube>>(triangles);
        const auto compare = [&](const auto& hierarchy) {
            GlRenderer shading, alone;
            opengl::CulledInSoftware culled(shading, ZBufferOptions{});
            static_assert(decltype(culled)::facts.shapes_stand_ins);
            auto viewer = make_viewer(hierarchy, triangles, culled);
            auto reference = make_viewer(hierarchy, triangles, alone);
            for (const View& view : {looking({0.5, 1, 6}, {}, 120, 2), looking({5, 0, 0.3}, {}, 120, 3)}) {
                viewer.frame(view);
                reference.frame(view);
                CHECK(culled.stats().seen < culled.stats().stand_ins);
                CHECK(culled.stats().seen > 100);
                CHECK(flip(shading.image(), alone.image()) < 0.003);
            }
        };
        compare(tensors);
        compare(cubes);
    }
    gl.check_clean();
}

TEST_CASE("OpenGL is sent one view where a camera moves among instances, and sees them where they are", "[opengl]") {
    OpenGl gl;
    if (!gl) return;
    {
        using Inner = HierarchyOf<OpacityTensor>;
        using Placed = Instance<Inner, Triangle>;
        const auto triangles = leaves_and_a_ball(4'000, 4);
        const auto inner = build<Inner>(triangles);
        std::mt19937 random(5);
        std::uniform_real_distribution<float> in(-1, 1);
        std::vector<Placed> all;
        for (int i = 0; i < 900; ++i) {
            // Far from where the coordinates begin, turned and scaled.
            glm::dmat4 m =
                glm::translate(glm::dmat4(1), glm::dvec3(4e5 + 4 * (i % 30), 2 * double(in(random)), 4 * (i / 30)));
            m = glm::rotate(m, 3 * double(in(random)), glm::dvec3(0.2, 1, double(in(random))));
            m = glm::scale(m, glm::dvec3(1 + 0.5 * double(in(random))));
            all.push_back({.hierarchy = &inner, .primitives = triangles, .to_world = Similarity(m)});
        }
        const auto hierarchy = build<SpatialHierarchy<Octree, OpacityTensor, TriangleCount>>(all);
        const glm::dvec3 center(4e5 + 60, 0, 60);
        View above = looking(center + glm::dvec3(20, 70, 60), center, 160, 2),
             among = looking(center + glm::dvec3(2, 3, 2), center + glm::dvec3(30, 0, 30), 160, 2);
        View parallel = looking_orthographic(center + glm::dvec3(20, 70, 60), center, 60, 160, 2);
        GlRenderer renderer;
        ZBufferRenderer reference;
        auto viewer = make_viewer(hierarchy, all, renderer);
        auto by_processor = make_viewer(hierarchy, all, reference);
        for (View view : {above, among, parallel}) {
            FrameStats stats = viewer.frame(view);
            by_processor.frame(view);
            CHECK(stats.instances > 100);
            CHECK(flip(renderer.image(), reference.image()) < 0.03);
            for (const double step : {0.0, 0.002}) {
                view.camera.eye += glm::dvec3(step, 0, step);
                stats = viewer.frame(view);
                by_processor.frame(view);
                INFO(renderer.stats().uploaded_bytes << " bytes, " << stats.instances << " instances");
                CHECK(renderer.stats().uploaded_bytes <= (step == 0 ? 0 : 16 * stats.instances));
                CHECK(flip(renderer.image(), reference.image()) < 0.03);
            }
        }
    }
    gl.check_clean();
}
