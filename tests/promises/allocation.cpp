// No frame allocates once buffers have grown to what the scene needs. Counts calls of operator new in this program.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <new>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/image_cache.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/measured_time.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/frame/frame_budget.hpp"
#include "farfield/merged_viewer.hpp"
#include "farfield/partition/nested.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/partition/polygon_bsp.hpp"
#include "farfield/primitive/instance.hpp"
#include "farfield/renderer/coverage_renderer.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/tuning/error_table.hpp"
#include "farfield/tuning/sampled_error_table.hpp"
#include "farfield/tuning/tuned_viewer.hpp"
#include "farfield/viewer.hpp"
#include "scenes/renderers/coverage_tilers.hpp"
#include "support/allocations.hpp"
#include "support/pictures.hpp"
#include "support/scenes.hpp"
#include "support/variants.hpp"

namespace farfield::test {

Allocations& allocations() {
    static thread_local Allocations of_thread;
    return of_thread;
}

}  // namespace farfield::test

namespace {

using farfield::test::allocations;

bool may_allocate(std::size_t size) {
    farfield::test::Allocations& a = allocations();
    return ++a.count != a.failing && size <= a.largest;
}
void* counted(std::size_t size) {
    if (void* p = may_allocate(size) ? std::malloc(size ? size : 1) : nullptr) return p;
    throw std::bad_alloc();
}
void* counted(std::size_t size, std::align_val_t alignment) {
    const std::size_t step = std::size_t(alignment);
    if (void* p = may_allocate(size) ? std::aligned_alloc(step, (size + step - 1) / step * step) : nullptr) return p;
    throw std::bad_alloc();
}

}  // namespace

void* operator new(std::size_t size) {
    return counted(size);
}
void* operator new[](std::size_t size) {
    return counted(size);
}
void* operator new(std::size_t size, std::align_val_t alignment) {
    return counted(size, alignment);
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
    return counted(size, alignment);
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
    return may_allocate(size) ? std::malloc(size ? size : 1) : nullptr;
}
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept {
    return may_allocate(size) ? std::malloc(size ? size : 1) : nullptr;
}
void operator delete(void* p, const std::nothrow_t&) noexcept {
    std::free(p);
}
void operator delete[](void* p, const std::nothrow_t&) noexcept {
    std::free(p);
}
void operator delete(void* p) noexcept {
    std::free(p);
}
void operator delete[](void* p) noexcept {
    std::free(p);
}
void operator delete(void* p, std::size_t) noexcept {
    std::free(p);
}
void operator delete[](void* p, std::size_t) noexcept {
    std::free(p);
}
void operator delete(void* p, std::align_val_t) noexcept {
    std::free(p);
}
void operator delete[](void* p, std::align_val_t) noexcept {
    std::free(p);
}
void operator delete(void* p, std::size_t, std::align_val_t) noexcept {
    std::free(p);
}
void operator delete[](void* p, std::size_t, std::align_val_t) noexcept {
    std::free(p);
}

using namespace farfield;
using namespace farfield::test;

namespace {

std::vector<View> path() {
    std::vector<View> views;
    for (int i = 0; i < 6; ++i)
        views.push_back(looking({9 * std::cos(i), 1, 8 * std::sin(i)}, {0.1, 0, 0}, 100, 2 * float(i % 3)));
    views.push_back(looking({0.1, 0.2, 0}, {1, 0, 0}, 100, 3));
    views.push_back(looking_orthographic({3, 4, 5}, {}, 4, 100, 2));
    return views;
}

}  // namespace

TEST_CASE("the third time along a path no frame allocates") {
    const Triangles triangles = mixed_triangles(5000, 120);
    const std::vector<View> views = path();
    const std::size_t before_anything = allocations().count;
    ::operator delete(::operator new(1));
    const std::size_t counts = allocations().count - before_anything;
    REQUIRE(counts == 1);
    for (const Variant& variant : all_variants()) {
        const auto h = variant.build(triangles, DirectionalLight{});
        for (const int samples : {1, 4}) {
            ZBufferRenderer renderer(ZBufferOptions{.samples = samples, .light = DirectionalLight{}});
            const auto viewer = h->viewer(renderer);
            for (int round = 0; round < 2; ++round) {
                for (const View& view : views) viewer->frame(view);
            }
            const std::size_t before = allocations().count;
            for (const View& view : views) viewer->frame(view);
            const std::size_t during = allocations().count - before;
            INFO(variant.name << ", " << samples << " samples");
            CHECK(during == 0);
        }
    }
}

namespace {

/// Stand-ins are replayed; keeps nothing itself.
struct Blind {
    static constexpr RendererFacts facts{.far_field_order = VisitOrder::back_to_front, .draws_faces = true};
    void begin_frame(const LocalView&) {}
    void set_view(const LocalView&) {}
    void end_frame() {}
    template <class P>
    void draw(const Source<P>&, std::span<const Range>) {}
    void draw(std::span<const Face> f) { faces += f.size(); }
    std::size_t faces = 0;
};

}  // namespace

TEST_CASE("replayed stand-ins do not allocate either") {
    using Cubes = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
    const Triangles triangles = random_triangles(8000, 121, 0.02f);
    const Cubes h = build<Cubes>(triangles);
    Blind renderer;
    auto viewer = make_viewer(h, triangles, renderer);
    std::size_t before = 0;
    for (int round = 0; round < 3; ++round) {
        before = allocations().count;
        for (const View& view : path()) viewer.frame(view);
        before = allocations().count - before;
    }
    const std::size_t of_path = [] {
        const std::size_t b = allocations().count;
        path();
        return allocations().count - b;
    }();
    CHECK(before == of_path);
    CHECK(renderer.faces > 1000);
}

TEST_CASE("frames within a budget do not allocate") {
    using Cubes = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
    const Triangles triangles = random_triangles(8000, 122, 0.02f);
    const Cubes h = build<Cubes>(triangles);
    const std::vector<View> views = path();
    ZBufferRenderer renderer;
    auto viewer = make_viewer(h, triangles, renderer);
    Refinement refinement;
    const auto draw_all = [&] {
        for (const View& view : views) {
            viewer.frame(view, FrameBudget{.prices = FramePrices::of_primitives(), .most = 2000}, refinement);
        }
    };
    draw_all();
    draw_all();
    const std::size_t before = allocations().count;
    draw_all();
    CHECK(allocations().count == before);
}

TEST_CASE("frames of errors that change, by a table, do not allocate") {
    using Cubes = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
    const Triangles triangles = random_triangles(4000, 122, 0.02f);
    const Cubes h = build<Cubes>(triangles);
    const std::vector<View> views = path();
    const SampledErrorTable table(
        {{1, 1, ErrorTable({{0, 0.08, 1}, {2, 0.1, 0.2}})}, {4, 3, ErrorTable({{0, 0.005, 1}, {1, 0.01, 0.5}})}});
    auto viewer = make_tuned_viewer(h, triangles, table, [](int n) { return ZBufferRenderer({.samples = n}); });
    const auto draw_all = [&] {
        for (View view : views) {
            for (const double rmse : {0.1, 0.01, 0.0}) {
                view.wanted.rmse = rmse;
                viewer.frame(view);
            }
        }
    };
    draw_all();
    draw_all();
    const std::size_t before = allocations().count;
    draw_all();
    CHECK(allocations().count == before);
}

TEST_CASE("frames of masks do not allocate, those of moving bodies neither") {
    using Bsp = SpatialHierarchy<Nested<Octree, PolygonBsp>, Exact, TriangleCount>;
    const Triangles a = random_triangles(300, 1, 0.5f), b = sphere({}, 0.8f, 12, {200, 0, 0, 255});
    const Bsp ha = build<Bsp>(a), hb = build<Bsp>(b, {.partition = {.largest_leaf = 32}});
    std::vector<Instance<Bsp, Triangle>> bodies{{&ha, a, {}}, {&hb, b, {}}, {&hb, b, {}}};
    bodies[2].to_world.translation = {0.5, 0.1, 0.3};
    StrictCoverageRenderer strict;
    auto merged = make_merged_viewer(bodies, strict);
    CoverageRenderer lazy;
    auto viewer = make_viewer(ha, a, lazy);
    const View view = looking({3, 1, 2});
    std::size_t pieces = 0, during = 0;
    for (int round = 0; round < 3; ++round) {
        const std::size_t before = allocations().count;
        pieces = merged.frame(view).pieces;
        viewer.frame(view);
        during = allocations().count - before;
    }
    CHECK(pieces > 10);
    CHECK(during == 0);
}

TEST_CASE("frames that make no image of a cell do not allocate, and most do not") {
    const Triangles triangles = mixed_triangles(8000, 123);
    using Cached = SpatialHierarchy<Octree, ImageCache<Exact>, MeasuredTime>;
    ImageCache<Exact> images;
    images.image_options.least_items = 64;
    images.image_options.most_overhead = 4;
    MeasuredTime prices;
    prices.image = prices.texel = prices.made_image = prices.made_texel = 0;
    for (const std::uint32_t fade_frames : {0u, 4u}) {
        images.image_options.fade_frames = fade_frames;
        const Cached h = build<Cached>(triangles, {.approximation = images, .cost_model = prices});
        ZBufferRenderer renderer;
        auto viewer = make_viewer(h, triangles, renderer);
        int without = 0, with_images = 0;
        for (int round = 0; round < 4; ++round) {
            for (int f = 0; f < 60; ++f) {
                const View view = looking({0.01 * f, 1, 9}, {0.01 * f, 0, 0}, 100);
                const std::size_t before = allocations().count;
                const FrameStats stats = viewer.frame(view);
                const std::size_t during = allocations().count - before;
                if (round < 2) continue;
                with_images += stats.images > 0;
                if (stats.images_made > 0) continue;
                ++without;
                CHECK(during == 0);
            }
        }
        CHECK(with_images > 100);
        CHECK(without > 30);
    }
}
