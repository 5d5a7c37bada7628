// What comes and goes: pages, which are one source that changes, and what fades from one level into the next.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <vector>

#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/approximation/sample_set.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/measure/flip.hpp"
#include "farfield/paging/open_pages.hpp"
#include "farfield/paging/write_pages.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "opengl/culled_in_software.hpp"
#include "opengl/setting.hpp"
#include "support/image_walk.hpp"
#include "support/scenes.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;
using opengl::CulledInSoftware;
using opengl::GlRenderer;

namespace {

constexpr double most_flip = 0.03;

using Tensors = SpatialHierarchy<Octree, OpacityTensor, TriangleCount>;
using Cubes = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
using Samples = SpatialHierarchy<Octree, SampleSet<AreaSplat>, TriangleCount>;

struct Memory {
    std::vector<std::byte> bytes;
    std::uint64_t size() const noexcept { return bytes.size(); }
    ReadMerging merging() const noexcept { return {}; }
    ReadResult read(std::uint64_t offset, std::span<std::byte> to) noexcept {
        if (!farfield::detail::lies_within(size(), offset, to.size()))
            return farfield::detail::beyond_the_end("memory", size(), offset, to.size());
        if (!to.empty()) std::memcpy(to.data(), bytes.data() + offset, to.size());
        return {};
    }
};

template <class H>
PagedHierarchy<H, Triangle> paged_like(const H& h, const Triangles& triangles) {
    auto pages = open_pages_of<H, Triangle>(
        std::make_shared<Memory>(Memory{paged<H, Triangle>(h, triangles, {.page_bytes = 8192})}), "memory",
        {.loads_in_background = false});
    pages.wait_for_pages(true);
    return pages;
}

const Triangles& clusters() {
    static const Triangles triangles = mixed_triangles(12'000, 11);
    return triangles;
}

View seen(float distance, float tolerance) {
    return looking(glm::dvec3(0.3, 0.4, 1.0) * double(distance), glm::dvec3(0), 96, tolerance);
}

/// Calls frame(renderer, viewer) with one that draws by OpenGL alone, and one that software culls for.
template <class H, class Check>
void check_against_software(const H& hierarchy, int samples, Check&& check) {
    ZBufferRenderer reference(ZBufferOptions{.samples = samples});
    GlRenderer alone({.samples = samples}), shading({.samples = samples});
    CulledInSoftware culled(shading, ZBufferOptions{.samples = samples});
    const auto viewer_of = [&](auto& renderer) {
        if constexpr (PagedAtRunTime<H>) {
            return make_viewer(hierarchy, renderer);
        } else {
            return make_viewer(hierarchy, clusters(), renderer);
        }
    };
    auto expected = viewer_of(reference);
    auto by_one = viewer_of(alone);
    auto by_two = viewer_of(culled);
    check([&](const View& view) {
        const FrameStats stats = expected.frame(view);
        by_one.frame(view);
        by_two.frame(view);
        CHECK(flip(alone.image(), reference.image()) <= most_flip);
        CHECK(flip(shading.image(), reference.image()) <= most_flip);
        return stats;
    });
}

template <class H>
void check_pages_and_fading() {
    const H in_memory = build<H>(clusters());
    const auto pages = paged_like(in_memory, clusters());
    REQUIRE(pages.page_count() > 5);
    for (const int samples : {1, 4}) {
        std::uint64_t stand_ins = 0, primitives = 0;
        const auto look = [&](float fade) {
            return [&, fade](auto&& frame) {
                for (const float distance : {1.2f, 3.0f, 9.0f}) {
                    for (const float tolerance : {1.0f, 4.0f}) {
                        INFO(samples << " samples, distance " << distance << ", tolerance " << tolerance << ", fade "
                                     << fade);
                        View view = seen(distance, tolerance);
                        view.fade = fade;
                        view.tolerance_jitter = fade / 2;
                        const FrameStats stats = frame(view);
                        stand_ins += stats.approximations;
                        primitives += stats.primitives;
                    }
                }
            };
        };
        check_against_software(pages, samples, look(0));
        check_against_software(pages, samples, look(0.5f));
        check_against_software(in_memory, samples, look(0.5f));
        CHECK(stand_ins > 500);
        CHECK(primitives > 1000);
    }
}

}  // namespace

TEST_CASE("OpenGL draws pages and what fades as the z-buffer does: tensors", "[opengl]") {
    OpenGl gl;
    if (!gl) return;
    check_pages_and_fading<Tensors>();
    gl.check_clean();
}
TEST_CASE("OpenGL draws pages and what fades as the z-buffer does: cubes", "[opengl]") {
    OpenGl gl;
    if (!gl) return;
    check_pages_and_fading<Cubes>();
    gl.check_clean();
}
TEST_CASE("OpenGL draws pages and what fades as the z-buffer does: samples", "[opengl]") {
    OpenGl gl;
    if (!gl) return;
    check_pages_and_fading<Samples>();
    gl.check_clean();
}

TEST_CASE("OpenGL draws images that take one another's place as the z-buffer does", "[opengl]") {
    OpenGl gl;
    if (!gl) return;
    {
        const auto cached = build<CachedImages>(
            balls(), {.approximation = with({.least_items = 64, .most_overhead = 4, .fade_frames = 4}),
                      .cost_model = free_images()});
        ZBufferRenderer reference;
        GlRenderer shading;
        CulledInSoftware tested(shading);
        auto expected = make_viewer(cached, balls(), reference);
        auto viewer = make_viewer(cached, balls(), tested);
        std::uint64_t images = 0;
        double worst = 0;
        for (int f = 0; f < 40; ++f) {
            const View view = seen_from({0.2 * f, 0, 0});
            images += viewer.frame(view).images;
            expected.frame(view);
            worst = std::max(worst, flip(shading.image(), reference.image()));
        }
        CHECK(images > 100);
        CHECK(worst <= most_flip);
    }
    gl.check_clean();
}
