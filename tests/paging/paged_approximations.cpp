// Everything that can be stored can be paged, and whatever draws what changes draws it.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>
#include <span>
#include <type_traits>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/area_splat.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/approximation/sample_set.hpp"
#include "farfield/approximation/sided_tensor.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/paging/open_pages.hpp"
#include "farfield/paging/write_pages.hpp"
#include "farfield/partition/gap_bsp.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/partition/polygon_bsp.hpp"
#include "farfield/renderer/coverage_renderer.hpp"
#include "farfield/renderer/hierarchical_z_renderer.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "support/pictures.hpp"
#include "support/random.hpp"
#include "support/scenes.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

struct Memory {
    std::vector<std::byte> bytes;
    std::uint64_t size() const noexcept { return bytes.size(); }
    ReadMerging merging() const noexcept { return {}; }
    ReadResult read(std::uint64_t offset, std::span<std::byte> to) noexcept {
        if (!detail::lies_within(size(), offset, to.size())) {
            return detail::beyond_the_end("memory", size(), offset, to.size());
        }
        if (!to.empty()) std::memcpy(to.data(), bytes.data() + offset, to.size());
        return {};
    }
};

template <class H>
PagedHierarchy<H, Triangle> paged_like(const H& h, const Triangles& triangles, PageCacheOptions cache = {}) {
    cache.loads_in_background = false;
    return open_pages_of<H, Triangle>(
        std::make_shared<Memory>(Memory{paged<H, Triangle>(h, triangles, {.page_bytes = 8192})}), "memory", cache);
}

/// Pixels that one picture covers all of and another has nothing in.
int holes_in(const Image& seen, const Image& wanted) {
    int holes = 0;
    for (std::size_t p = 0; p < wanted.pixels().size(); ++p) {
        holes += wanted.pixels()[p].a == 255 && seen.pixels()[p].a == 0;
    }
    return holes;
}

/// In memory, waiting, and frame by frame until nothing is missing.
template <class R, class H>
void check_pictures(const H& h, const Triangles& triangles, bool same_choice = true) {
    R renderer, waiting_renderer, walking_renderer;
    auto viewer = make_viewer(h, triangles, renderer);
    auto pages = paged_like(h, triangles);
    REQUIRE(pages.page_count() > 5);
    auto walking = make_viewer(pages, walking_renderer);
    auto waiting_pages = pages;
    waiting_pages.wait_for_pages(true);
    auto waiting = make_viewer(waiting_pages, waiting_renderer);
    for (const float tolerance : {0.0f, 1.0f, 4.0f}) {
        for (const float distance : {0.3f, 2.0f, 12.0f}) {
            const View v = looking(glm::dvec3(0.3, 0.4, 1.0) * double(distance), glm::dvec3(0), 96, tolerance);
            INFO("tolerance " << tolerance << ", distance " << distance);
            int frames = 0;
            while (walking.frame(v).cells_missing != 0 && ++frames < 100) pages.load_wanted();
            CHECK(frames < 100);
            CHECK(waiting.frame(v).cells_missing == 0);
            CHECK(waiting_renderer.image() == walking_renderer.image());
            viewer.frame(v);
            if (same_choice) {
                CHECK(different_pixels(renderer.image(), waiting_renderer.image()) <= 5);
            } else {
                CHECK(rms_difference(renderer.image(), waiting_renderer.image()) < 0.03);
            }
        }
    }
}

template <class Partition_, class A>
using Over = SpatialHierarchy<Partition_, A, TriangleCount>;

static_assert(Pageable<Over<Octree, ColorCube>> && Pageable<Over<Octree, SampleSet<OpacityTensor>>>);
// Planes that cut polygons leave pieces, which lie in several cells.
static_assert(Pageable<Over<GapBsp, ColorCube>> && !Pageable<Over<PolygonBsp, ColorCube>>);

}  // namespace

TEMPLATE_TEST_CASE("Every approximation that can be stored is drawn from pages as from memory", "",
                   (Over<Octree, ColorCube>), (Over<Octree, OpacityTensor>), (Over<Octree, SidedTensor>),
                   (Over<Octree, AreaSplat>), (Over<Octree, SampleSet<>>), (Over<Octree, SampleSet<OpacityTensor>>),
                   (Over<GapBsp, ColorCube>)) {
    const Triangles triangles = mixed_triangles(6000, 41);
    const auto h = build<TestType>(triangles);
    check_pictures<ZBufferRenderer>(h, triangles, !TestType::approximation_type::facts.samples_primitives);
}

TEMPLATE_TEST_CASE("Renderers that read what changes draw pages as memory", "", HierarchicalZRenderer,
                   CoverageRenderer) {
    const Triangles triangles = mixed_triangles(6000, 43);
    const auto h = build<Over<Octree, OpacityTensor>>(triangles);
    check_pictures<TestType>(h, triangles);
}

TEMPLATE_TEST_CASE("Whoever is inside a scene sees no hole where pages are missing", "", (Over<Octree, OpacityTensor>),
                   (Over<Octree, SidedTensor>), (Over<Octree, ColorCube>), (Over<Octree, AreaSplat>),
                   (Over<Octree, SampleSet<AreaSplat>>)) {
    const Rgba8 color{90, 160, 60, 255};
    Triangles flat = sheet({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, 90, 90, color), hills = flat;
    for (Triangle& t : hills) {
        for (glm::vec3& v : t.vertices) v.y = 0.05f * std::sin(7 * v.x) * std::cos(9 * v.z);
    }
    Triangles room = sphere(glm::vec3(0), 1, 70, color);
    Random random(3);
    for (const Triangles& scene : {std::ref(flat), std::ref(hills), std::ref(room)}) {
        const auto h = build<TestType>(scene);
        ZBufferRenderer whole_renderer, renderer;
        auto whole = make_viewer(h, scene, whole_renderer);
        int holes = 0, coarse_frames = 0;
        for (int i = 0; i < 6; ++i) {
            glm::dvec3 eye(random.in_cube(0.5f));
            if (&scene != &room) eye.y = 0.08;
            const double angle = double(random.between(0, 6.28f));
            const View v = looking(eye, eye + glm::dvec3(std::cos(angle), -0.3, std::sin(angle)), 64, 2);
            whole.frame(v);
            auto pages = paged_like(h, scene);
            auto viewer = make_viewer(pages, renderer);
            for (int frame = 0; frame < 8; ++frame) {
                if (viewer.frame(v).cells_missing == 0) break;
                ++coarse_frames;
                holes += holes_in(renderer.image(), whole_renderer.image());
                pages.load_wanted();
            }
        }
        INFO("in " << coarse_frames << " frames");
        CHECK(coarse_frames > 6);
        CHECK(holes == 0);
    }
}

TEMPLATE_TEST_CASE("A cache that is too small leaves no hole", "", (Over<Octree, OpacityTensor>),
                   (Over<Octree, SidedTensor>), (Over<Octree, ColorCube>), (Over<Octree, AreaSplat>),
                   (Over<Octree, SampleSet<AreaSplat>>), (Over<Octree, SampleSet<OpacityTensor>>),
                   (Over<GapBsp, ColorCube>)) {
    const Rgba8 color{90, 160, 60, 255};
    // Squares of no round side lie across the borders of cells.
    const Triangles flat = sheet({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, 110, 110, color);
    Triangles floors = flat, leaning = flat;
    for (int i = 1; i < 4; ++i) append(floors, moved(flat, 1, {0, 0.013f * float(i), 0}));
    for (Triangle& t : leaning) {
        for (glm::vec3& v : t.vertices) v.y = 0.4f * v.x - 0.3f * v.z + 0.02f * std::sin(30 * v.x);
    }
    const Triangles ball = sphere(glm::vec3(0), 1, 60, color);
    // Of single polygons in large cells so little was drawn that it was rounded to nothing.
    const Triangles clutter = mixed_triangles(3400, 1), thin = mixed_triangles(3800, 2);
    for (const Triangles& scene : {std::cref(flat), std::cref(floors), std::cref(leaning), std::cref(ball),
                                   std::cref(clutter), std::cref(thin)}) {
        const double turn = &scene == &clutter ? 0.37 : &scene == &thin ? 0.74 : 0;
        const bool walks = &scene == &flat || &scene == &floors;
        const auto view = [&](int i) {
            if (i == 4) return looking_orthographic({1, 0.3, 1.2}, {}, 1.2f, 96, 2);
            if (walks) {
                // Close to the ground it is seen at a grazing angle.
                const glm::dvec3 eye(0.013, &scene == &flat && i % 2 == 0 ? 0.004 : 0.06, 0.9 - 0.15 * i);
                return looking(eye, eye + glm::dvec3(0.1 * i, -2 * eye.y, -1), 96, 2);
            }
            const glm::dvec3 direction(std::cos(i + turn), 0.4 + 0.27 * turn, std::sin(i + turn));
            return looking((0.9 + 0.4 * i) * direction, glm::dvec3(0), 96, 2);
        };
        constexpr int frames = 5;
        const auto h = build<TestType>(scene);
        auto all = paged_like(h, scene);
        all.wait_for_pages(true);
        ZBufferRenderer all_renderer, renderer;
        auto waiting = make_viewer(all, all_renderer);
        for (int i = 0; i < frames; ++i) waiting.frame(view(i));
        const double working_set = double(all.cache_stats().loads) * all.page_bytes();
        for (const double part : {0.05, 0.25, 0.5}) {
            const std::size_t most = std::size_t(part * working_set) + (std::size_t(48) << 10);
            auto pages = paged_like(h, scene, {.most_bytes = most});
            auto viewer = make_viewer(pages, renderer);
            int holes = 0;
            std::uint64_t missing = 0;
            for (int i = 0; i < frames; ++i) {
                waiting.frame(view(i));
                missing += viewer.frame(view(i)).cells_missing;
                holes += holes_in(renderer.image(), all_renderer.image());
                pages.load_wanted();
            }
            INFO("scene of " << scene.size() << ", cache of " << most << " bytes");
            CHECK(missing > 0);
            CHECK(holes == 0);
        }
    }
}
