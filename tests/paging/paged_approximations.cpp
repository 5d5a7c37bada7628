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
PagedHierarchy<H, Triangle> paged_like(const H& h, const Triangles& triangles) {
    return open_pages_of<H, Triangle>(
        std::make_shared<Memory>(Memory{paged<H, Triangle>(h, triangles, {.page_bytes = 8192})}), "memory",
        {.loads_in_background = false});
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
        int holes = 0, pixels = 0, coarse_frames = 0;
        for (int i = 0; i < 6; ++i) {
            glm::dvec3 eye(random.in_cube(0.5f));
            if (&scene != &room) eye.y = 0.08;
            const double angle = random.between(0, 6.28f);
            const View v = looking(eye, eye + glm::dvec3(std::cos(angle), -0.3, std::sin(angle)), 64, 2);
            whole.frame(v);
            auto pages = paged_like(h, scene);
            auto viewer = make_viewer(pages, renderer);
            for (int frame = 0; frame < 8; ++frame) {
                if (viewer.frame(v).cells_missing == 0) break;
                ++coarse_frames;
                const auto seen = renderer.image().pixels(), wanted = whole_renderer.image().pixels();
                for (std::size_t p = 0; p < seen.size(); ++p) {
                    pixels += wanted[p].a == 255;
                    holes += wanted[p].a == 255 && seen[p].a == 0;
                }
                pages.load_wanted();
            }
        }
        INFO(holes << " of " << pixels << " pixels in " << coarse_frames << " frames");
        CHECK(coarse_frames > 6);
        // Contents reach a little beyond their boxes, which are those of cells.
        CHECK(holes <= pixels / 500);
    }
}
