// Memory may run out at any allocation. What was built, drawn or saved before is then as it was, and the next frame is
// that of a renderer and a viewer that never failed. allocation.cpp replaces operator new.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <iterator>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/merged_viewer.hpp"
#include "farfield/partition/nested.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/partition/polygon_bsp.hpp"
#include "farfield/primitive/instance.hpp"
#include "farfield/renderer/coverage_renderer.hpp"
#include "farfield/renderer/hierarchical_z_renderer.hpp"
#include "farfield/renderer/painter_renderer.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/storage/open.hpp"
#include "farfield/storage/save.hpp"
#include "farfield/viewer.hpp"
#include "scenes/renderers/coverage_tilers.hpp"
#include "support/allocations.hpp"
#include "support/scenes.hpp"
#include "support/variants.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

using Tensors = SpatialHierarchy<Octree, OpacityTensor, TriangleCount>;
using Cubes = SpatialHierarchy<SharedOctree, ColorCube, TriangleCount>;
using Bsp = SpatialHierarchy<PolygonBsp, Exact, TriangleCount>;
using OctreeOfBsps = SpatialHierarchy<Nested<Octree, PolygonBsp>, Exact, TriangleCount>;
using Forest = SpatialHierarchy<Octree, OpacityTensor, TriangleCount>;
template <class H>
using Placed = Instance<H, Triangle>;

/// The one before, the one that fails, and one of another shape.
std::array<View, 3> views() {
    std::array<View, 3> v{looking({3, 1, 2}, {}, 20, 2), looking({2, 1.5, 2.5}, {}, 90, 3),
                          looking_orthographic({3, 4, 5}, {}, 3, 50, 2)};
    v[2].width = 71;
    return v;
}

std::size_t different(const Image& a, const Image& b) {
    return a == b ? 0 : 1;
}

/// `make()` gives an object with frame(view) and image(). Fails each allocation of a frame, the first or the second of
/// its viewer, and draws each of the views after that.
template <class Make>
void check_frames(const std::string& name, Make&& make) {
    INFO(name);
    std::array<Image, 3> right;
    for (std::size_t i = 0; i < right.size(); ++i) {
        const auto fresh = make();
        fresh->frame(views()[i]);
        right[i] = fresh->image();
    }
    std::size_t wrong = 0, failures = 0;
    for (const bool is_first : {false, true}) {
        for (std::size_t next = 0; next < right.size(); ++next) {
            for (std::size_t n = 1;; ++n) {
                const auto subject = make();
                if (!is_first) subject->frame(views()[0]);
                const bool failed = fails_for_memory(n, [&] { subject->frame(views()[1]); });
                if (!failed) {
                    wrong += different(subject->image(), right[1]);
                    break;
                }
                ++failures;
                subject->frame(views()[next]);
                wrong += different(subject->image(), right[next]);
                subject->frame(views()[1]);
                wrong += different(subject->image(), right[1]);
            }
        }
    }
    CHECK(wrong == 0);
    CHECK(failures > 6);
}

/// A renderer and a viewer, with their options.
template <class H, class P, class R>
struct Framed {
    R renderer;
    Viewer<H, P, R> viewer;

    template <class Options>
    Framed(const H& h, std::span<const P> primitives, const Options& options)
        : renderer(options), viewer(h, primitives, renderer) {}
    void frame(const View& view) { viewer.frame(view); }
    const Image& image() const { return renderer.image(); }
};

/// The same, in two steps.
template <class H, class P, class R>
struct SelectedAndDrawn : Framed<H, P, R> {
    using Framed<H, P, R>::Framed;
    Selection<H, P> selection;
    void frame(const View& view) {
        this->viewer.select(view, selection);
        this->viewer.draw(selection);
    }
};

template <class R, class H, class P, class Options>
void check_viewers(const std::string& name, const H& h, const std::vector<P>& primitives, const Options& options) {
    const std::span<const P> all(primitives);
    check_frames(name + ", frame", [&] { return std::make_unique<Framed<H, P, R>>(h, all, options); });
    check_frames(name + ", select and draw",
                 [&] { return std::make_unique<SelectedAndDrawn<H, P, R>>(h, all, options); });
}

/// A far field and single triangles.
Triangles leaves() {
    Triangles t = random_triangles(900, 1201, 0.06f);
    t[3].rgba.a = 120;
    return t;
}

const DirectionalLight light{};

bool are_same(const Triangles& a, const Triangles& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Triangle& t, const Triangle& u) {
        return t.vertices == u.vertices && t.rgba == u.rgba;
    });
}

}  // namespace

TEST_CASE("after a frame that ran out of memory the next is right, in every renderer") {
    const Triangles triangles = leaves(), few = random_triangles(60, 1202, 0.6f);
    const auto tensors = build<Tensors>(triangles, {.sampler = light});
    const auto cubes = build<Cubes>(triangles, {.sampler = light});
    const auto bsp = build<Bsp>(few);
    const auto nested = build<OctreeOfBsps>(few);
    SECTION("z-buffer") {
        for (const int samples : {1, 4}) {
            for (const bool deposits : {false, true}) {
                const ZBufferOptions options{.samples = samples, .light = light, .deposits_small_triangles = deposits};
                const std::string name = std::to_string(samples) + (deposits ? " samples, deposits" : " samples");
                check_viewers<ZBufferRenderer>("tensors, " + name, tensors, triangles, options);
                check_viewers<ZBufferRenderer>("shared cubes, " + name, cubes, triangles, options);
            }
        }
    }
    SECTION("hierarchical z") {
        for (const int samples : {1, 4}) {
            const ZBufferOptions options{.samples = samples, .background = {9, 8, 7, 255}, .light = light};
            check_viewers<HierarchicalZRenderer>("tensors", tensors, triangles, options);
            check_viewers<HierarchicalZRenderer>("bsp", bsp, few, options);
        }
    }
    SECTION("masks in any order") {
        for (const FarCoverage far_coverage : {FarCoverage::samples, FarCoverage::area_law}) {
            const CoverageOptions options{.light = light, .far_coverage = far_coverage};
            check_viewers<CoverageRenderer>("tensors", tensors, triangles, options);
            check_viewers<CoverageRenderer>("shared cubes", cubes, triangles, options);
        }
    }
    SECTION("masks in strict order") {
        check_viewers<StrictCoverageRenderer>("bsp", bsp, few, CoverageOptions{});
        check_viewers<StrictCoverageRenderer>("octree of BSPs", nested, few, CoverageOptions{});
    }
    SECTION("painter") {
        for (const int samples : {1, 4}) {
            check_viewers<PainterRenderer>("bsp", bsp, few, PainterOptions{.samples = samples});
        }
    }
}

TEST_CASE("after a frame that ran out of memory the next is right, over every variant") {
    struct Any {
        ZBufferRenderer renderer{{.samples = 4}};
        std::unique_ptr<AnyViewer> viewer;
        explicit Any(const AnyHierarchy& h) : viewer(h.viewer(renderer)) {}
        void frame(const View& view) { viewer->frame(view); }
        const Image& image() const { return renderer.image(); }
    };
    const Triangles triangles = random_triangles(150, 1203, 0.2f);
    for (const Variant& variant : all_variants()) {
        const auto h = variant.build(triangles);
        check_frames(variant.name, [&] { return std::make_unique<Any>(*h); });
    }
}

TEST_CASE("after a frame of instances that ran out of memory the next is right") {
    const Triangles triangles = leaves();
    const auto tree = build<Tensors>(triangles);
    std::vector<Placed<Tensors>> trees;
    for (int i = 0; i < 4; ++i) {
        const glm::dvec3 at(i % 2 - 0.5, 0.3 * i, i / 2 - 0.5);
        trees.push_back({&tree, triangles, {glm::mat3(1.0f), 0.4f, at}});
    }
    const auto forest = build<Forest>(trees);
    check_viewers<ZBufferRenderer>("z-buffer", forest, trees, ZBufferOptions{.samples = 4});
    check_viewers<CoverageRenderer>("masks", forest, trees, CoverageOptions{});
}

TEST_CASE("after a frame of moving bodies that ran out of memory the next is right") {
    const Triangles a = random_triangles(16, 1204, 0.5f), b = sphere({}, 0.8f, 4, {200, 0, 0, 255});
    const auto ha = build<OctreeOfBsps>(a), hb = build<OctreeOfBsps>(b, {.partition = {.largest_leaf = 8}});
    std::vector<Placed<OctreeOfBsps>> bodies{{&ha, a, {}}, {&hb, b, {}}, {&hb, b, {}}};
    bodies[2].to_world.translation = {0.5, 0.1, 0.3};
    const auto check = [&]<class R>(const char* name, std::in_place_type_t<R>) {
        struct Merged {
            R renderer;
            MergedViewer<OctreeOfBsps, Triangle, R> viewer;
            explicit Merged(std::span<const Placed<OctreeOfBsps>> all) : viewer(all, renderer) {}
            void frame(const View& view) { viewer.frame(view); }
            const Image& image() const { return renderer.image(); }
        };
        check_frames(name, [&] { return std::make_unique<Merged>(bodies); });
    };
    check("strict masks", std::in_place_type<StrictCoverageRenderer>);
    check("masks", std::in_place_type<CoverageRenderer>);
}

TEST_CASE("frames of sizes that no memory holds, or no integer, are refused and the next is right") {
    const Triangles triangles = leaves();
    const auto h = build<Tensors>(triangles);
    constexpr int most = std::numeric_limits<int>::max(), least = std::numeric_limits<int>::min();
    const auto check = [&](auto& renderer, int large) {
        auto viewer = make_viewer(h, triangles, renderer);
        const View view = views()[1];
        viewer.frame(view);
        const Image right = renderer.image();
        for (const auto& [width, height] :
             {std::pair(0, 9), std::pair(9, 0), std::pair(-1, 9), std::pair(9, -5), std::pair(least, least),
              std::pair(most, most), std::pair(most, 1), std::pair(1, most), std::pair(65536, 65536)}) {
            View other = view;
            other.width = width;
            other.height = height;
            INFO(width << " x " << height);
            CHECK_THROWS_AS(viewer.frame(other), std::invalid_argument);
            viewer.frame(view);
            CHECK(renderer.image() == right);
        }
        View other = view;
        other.width = other.height = large;
        for (const std::size_t largest : {1u << 16, 1u << 20, 1u << 22}) {
            allocations().largest = largest;
            CHECK_THROWS_AS(viewer.frame(other), std::bad_alloc);
            CHECK_THROWS_AS(viewer.frame(other), std::bad_alloc);
            viewer.frame(view);
            allocations().largest = std::numeric_limits<std::size_t>::max();
            CHECK(renderer.image() == right);
        }
    };
    for (const int samples : {1, 16, 64}) {
        ZBufferRenderer z_buffer(ZBufferOptions{.samples = samples});
        check(z_buffer, 15000 / int(std::sqrt(samples)));
        HierarchicalZRenderer hierarchical(ZBufferOptions{.samples = samples});
        check(hierarchical, 15000 / int(std::sqrt(samples)));
    }
    CoverageRenderer masks;
    check(masks, 3800);
}

TEST_CASE("a build that ran out of memory leaves primitives as they were, and the next is right") {
    const Triangles given = random_triangles(40, 1205, 0.3f);
    const auto bytes_of = [](const auto& h) {
        std::vector<std::byte> bytes(saved_size(h));
        save(h, std::span<std::byte>(bytes));
        return bytes;
    };
    SECTION("in place") {
        using Exactly = SpatialHierarchy<Octree, Exact, TriangleCount>;
        Triangles in_order = given;
        const auto right = build_in_place<Exactly>(in_order, {.partition = {.uniform_depth = 2}});
        REQUIRE(!are_same(in_order, given));
        std::size_t wrong = 0, n = 1;
        for (;; ++n) {
            Triangles triangles = given;
            std::optional<Exactly> h;
            const auto attempt = [&] { h = build_in_place<Exactly>(triangles, {.partition = {.uniform_depth = 2}}); };
            if (!fails_for_memory(n, attempt)) break;
            wrong += !are_same(triangles, given);
            attempt();
            wrong += !are_same(triangles, in_order) || bytes_of(*h) != bytes_of(right);
        }
        CHECK(wrong == 0);
        CHECK(n > 5);
    }
    SECTION("cut, with options that live on") {
        const BuildOptions<Bsp> options{};
        const auto right = build<Bsp>(given, options);
        std::size_t wrong = 0, n = 1;
        for (;; ++n) {
            std::optional<Bsp> h;
            if (!fails_for_memory(n, [&] { h = build<Bsp>(given, options); })) break;
            wrong += h.has_value();
            if (n % 16 == 0) wrong += bytes_of(build<Bsp>(given, options)) != bytes_of(right);
        }
        CHECK(wrong == 0);
        CHECK(n > 50);
    }
}

TEST_CASE("a viewer that cannot be made leaves nothing in the renderer") {
    const Triangles a = random_triangles(40, 1206), b = random_triangles(50, 1207);
    const auto ha = build<Cubes>(a), hb = build<Cubes>(b);
    std::vector<Placed<Cubes>> both{{&ha, a, {}}, {&hb, b, {}}};
    const auto h = build<Cubes>(both);
    const auto check = [&](auto& renderer) {
        std::size_t wrong = 0, n = 1;
        for (;; ++n) {
            if (!fails_for_memory(n, [&] { make_viewer(h, both, renderer); })) break;
            wrong += renderer.uploaded_bytes() != 0;
            auto viewer = make_viewer(h, both, renderer);
            wrong += renderer.uploaded_bytes() == 0;
        }
        CHECK(wrong == 0);
        CHECK(n > 6);
    };
    ZBufferRenderer z_buffer;
    check(z_buffer);
    CoverageRenderer masks;
    check(masks);
}

TEST_CASE("a file that cannot be saved for want of memory is the old one, and nothing lies beside it") {
    const auto directory = std::filesystem::temp_directory_path() / "farfield_out_of_memory";
    std::filesystem::remove_all(directory);
    std::filesystem::create_directory(directory);
    const auto path = directory / "hierarchy";
    const Triangles triangles = random_triangles(40, 1208, 0.3f), more = random_triangles(70, 1209, 0.3f);
    using Exactly = SpatialHierarchy<Octree, Exact, TriangleCount>;
    const auto old = build<Exactly>(triangles), young = build<Exactly>(more);
    save(old, path);
    std::size_t wrong = 0, n = 1;
    while (fails_for_memory(n, [&] { save(young, path); })) {
        const auto files = std::filesystem::directory_iterator(directory);
        wrong += std::distance(begin(files), end(files)) != 1;
        wrong += open<Exactly>(path).primitive_count() != old.primitive_count();
        ++n;
    }
    CHECK(open<Exactly>(path).primitive_count() == young.primitive_count());
    CHECK(n > 2);
    for (n = 1; fails_for_memory(n, [&] { open<Exactly>(path); }); ++n) {
        wrong += open<Exactly>(path).primitive_count() != young.primitive_count();
    }
    CHECK(wrong == 0);
    std::filesystem::remove_all(directory);
}
