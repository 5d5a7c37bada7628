#include "farfield/banded_viewer.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/color_cube_cluster.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/coverage/pixels/cosine_hump_filter.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/partition/polygon_bsp.hpp"
#include "farfield/primitive/instance.hpp"
#include "farfield/renderer/coverage_renderer.hpp"
#include "farfield/renderer/hierarchical_z_renderer.hpp"
#include "farfield/renderer/painter_renderer.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "support/random.hpp"
#include "support/scenes.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

using Tensors = SpatialHierarchy<Octree, OpacityTensor, TriangleCount>;
using SharedTensors = SpatialHierarchy<SharedOctree, OpacityTensor, TriangleCount>;
using Cubes = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
using Clusters = SpatialHierarchy<Octree, ColorCubeCluster<2>, TriangleCount>;
using Bsp = SpatialHierarchy<PolygonBsp, Exact, TriangleCount>;
using Placed = Instance<Tensors, Triangle>;

constexpr DirectionalLight light{};

/// Large ones, small ones, translucent ones, and a closed surface that hides some.
Triangles things() {
    Triangles all = mixed_triangles(1500, 271);
    append(all, random_triangles(2500, 272, 0.03f));
    for (std::size_t i = 0; i < all.size(); i += 7) all[i].rgba.a = 128;
    append(all, sphere({0, 0, 0}, 0.4f, 24, {200, 100, 50, 255}));
    return all;
}

struct World {
    Triangles triangles = things();
    Tensors tensors = build<Tensors>(triangles, {.sampler = light});
    SharedTensors shared = build<SharedTensors>(triangles, {.sampler = light});
    Cubes cubes = build<Cubes>(triangles, {.sampler = light});
    Clusters clusters = build<Clusters>(triangles, {.sampler = light});
    Triangles few = random_triangles(80, 273, 0.7f);
    Bsp bsp = build<Bsp>(few);
    std::vector<Placed> placed = [&] {
        Random random(274);
        std::vector<Placed> all;
        for (int i = 0; i < 20; ++i) {
            all.push_back({&tensors, triangles, {}});
            all.back().to_world.translation = glm::dvec3(random.in_cube(3));
        }
        return all;
    }();
    Tensors forest = build<Tensors>(placed, {.sampler = light});
};

const World& world() {
    static const World w;
    return w;
}

struct CosineHump : LazyCoverage {
    using samples = PixelSamples<CosineHumpFilter>;
};
struct Jittered : StrictCoverage {
    static constexpr MaskSource masks = MaskSource::jittered;
};

/// Compares a frame in bands, and in a tile, to one at once.
template <class R, class Options, class H, class P>
void check_bands(const std::string& name, const Options& options, const H& h, const std::vector<P>& primitives,
                 const View& view, Random& random) {
    INFO(name << ", " << view.width << " x " << view.height << ", tolerance " << view.tolerance_px);
    R at_once(options);
    make_viewer(h, primitives, at_once).frame(view);
    const std::size_t bands = 1 + random.below(12);
    INFO(bands << " bands");
    auto viewer = make_banded_viewer(h, primitives, bands, [&](std::size_t) { return R(options); });
    const unsigned threads[] = {1, 2, 3, 8};
    viewer.frame(view, ThreadExecutor(threads[random.below(4)]));
    CHECK(viewer.image() == at_once.image());
    if constexpr (requires { R::reach_px; }) {
        if (R::reach_px != 0) return;
    }
    const int w = 1 + int(random.below(std::uint32_t(view.width))),
              rows = 1 + int(random.below(std::uint32_t(view.height)));
    const int left = int(random.below(std::uint32_t(view.width - w + 1))),
              top = int(random.below(std::uint32_t(view.height - rows + 1)));
    R tile(options);
    make_viewer(h, primitives, tile).frame(view.tile(left, top, w, rows));
    int different = 0;
    for (int y = 0; y < rows; ++y) {
        for (int x = 0; x < w; ++x) different += tile.image().at(x, y) != at_once.image().at(left + x, top + y);
    }
    INFO("tile of " << w << " x " << rows << " at " << left << ", " << top);
    CHECK(different == 0);
}

void check_all(const View& view, Random& random) {
    const World& w = world();
    const ZBufferOptions one{.light = light};
    ZBufferOptions four = one, whole = one, in_place = one;
    four.samples = 4;
    whole.deposits_small_triangles = false;
    in_place.copies_sources = false;
    const CoverageOptions masks{.light = light}, area{.light = light, .far_coverage = FarCoverage::area_law};
    check_bands<ZBufferRenderer>("tensors", one, w.tensors, w.triangles, view, random);
    check_bands<ZBufferRenderer>("tensors, 4 samples", four, w.tensors, w.triangles, view, random);
    check_bands<ZBufferRenderer>("tensors, nothing small deposited", whole, w.tensors, w.triangles, view, random);
    check_bands<ZBufferRenderer>("tensors, read in place", in_place, w.tensors, w.triangles, view, random);
    check_bands<ZBufferRenderer>("tensors in instances", one, w.forest, w.placed, view, random);
    check_bands<ZBufferRenderer>("cubes", one, w.cubes, w.triangles, view, random);
    check_bands<HierarchicalZRenderer>("hierarchical z, tensors", one, w.tensors, w.triangles, view, random);
    check_bands<HierarchicalZRenderer>("hierarchical z, cubes", four, w.cubes, w.triangles, view, random);
    check_bands<CoverageRenderer>("masks, tensors", masks, w.tensors, w.triangles, view, random);
    check_bands<CoverageRenderer>("masks, tensors by area", area, w.tensors, w.triangles, view, random);
    check_bands<CoverageRenderer>("masks, instances", masks, w.forest, w.placed, view, random);
    check_bands<StrictCoverageRenderer>("strict masks", masks, w.bsp, w.few, view, random);
    check_bands<PainterRenderer>("painter", PainterOptions{.light = light}, w.bsp, w.few, view, random);
#if !defined(FARFIELD_FEW_VARIANTS)
    check_bands<ZBufferRenderer>("tensors, shared items", one, w.shared, w.triangles, view, random);
    check_bands<ZBufferRenderer>("clusters", four, w.clusters, w.triangles, view, random);
    check_bands<CoverageRenderer>("masks, cubes by area", area, w.cubes, w.triangles, view, random);
    check_bands<CoverageRenderer>("lazy masks, BSP", masks, w.bsp, w.few, view, random);
    check_bands<BasicCoverageRenderer<Jittered>>("jittered masks", masks, w.bsp, w.few, view, random);
    check_bands<BasicCoverageRenderer<CosineHump>>("filtered masks", masks, w.tensors, w.triangles, view, random);
#endif
}

}  // namespace

TEST_CASE("bands and tiles are the whole picture, byte for byte, in every renderer and on any number of threads") {
    Random random(275);
    for (int i = 0; i < 24; ++i) {
        const float distance = std::exp(3.5f * random.unit() - 0.5f);
        const glm::dvec3 eye = glm::dvec3(random.direction()) * double(distance);
        View view = i % 4 == 3 ? looking_orthographic(eye, {}, 0.5f + 4 * random.unit()) : looking(eye);
        view.width = 1 + int(random.below(i % 5 == 0 ? 400 : 100));
        view.height = 1 + int(random.below(150));
        const float tolerances[] = {0, 0.7f, 1, 2, 4};
        view.tolerance_px = tolerances[random.below(5)];
        if (i % 2 == 1) view.camera.off_center = {double(random.unit()) - 0.5, 2 * double(random.unit()) - 1};
        check_all(view, random);
    }
}

TEST_CASE("a picture of one pixel, and one of one row, come in one band") {
    Random random(276);
    for (const auto& [width, height] : {std::array{1, 1}, std::array{70, 1}, std::array{1, 9}}) {
        View view = looking({0, 0, 2.5});
        view.width = width;
        view.height = height;
        view.tolerance_px = 1;
        check_all(view, random);
    }
}

TEST_CASE("an empty scene gives an empty picture in bands too") {
    const Triangles none;
    const auto h = build<Tensors>(none);
    auto viewer = make_banded_viewer(h, none, 5, [](std::size_t) {
        return ZBufferRenderer({.background = {1, 2, 3, 255}});
    });
    View view = looking({0, 0, 2});
    view.width = view.height = 33;
    const FrameStats stats = viewer.frame(view, ThreadExecutor(3));
    CHECK(stats.primitives == 0);
    CHECK(viewer.image() == Image(33, 33, {1, 2, 3, 255}));
}

TEST_CASE("frames of changing sizes and views follow one another in one banded viewer") {
    const World& w = world();
    Random random(277);
    const ZBufferOptions options{.light = light};
    auto viewer = make_banded_viewer(w.tensors, w.triangles, 6, [&](std::size_t) { return ZBufferRenderer(options); });
    ZBufferRenderer at_once(options);
    auto plain = make_viewer(w.tensors, w.triangles, at_once);
    for (int i = 0; i < 20; ++i) {
        View view = looking(glm::dvec3(random.direction()) * double(1.2f + 4 * random.unit()));
        view.width = i % 3 == 0 ? 1 + int(random.below(90)) : 64;
        view.height = i % 3 == 0 ? 1 + int(random.below(90)) : 48;
        view.tolerance_px = 1.5f;
        const FrameStats sum = viewer.frame(view, ThreadExecutor(2)), stats = plain.frame(view);
        CHECK(viewer.image() == at_once.image());
        CHECK(sum.approximations >= stats.approximations);
    }
}

TEST_CASE("bands keep one copy of what they draw") {
    const World& w = world();
    const auto copies = [&](auto make) {
        using R = decltype(make(std::size_t(0)));
        R alone = make(0);
        const auto plain = make_viewer(w.tensors, w.triangles, alone);
        auto viewer = make_banded_viewer(w.tensors, w.triangles, 7, make);
        // The first holds it, and the others name the same bytes.
        for (std::size_t band = 0; band < viewer.bands(); ++band) {
            CHECK(viewer.renderer(band).uploaded_bytes() == alone.uploaded_bytes());
        }
    };
    copies([](std::size_t) { return ZBufferRenderer({.light = light}); });
    copies([](std::size_t) { return HierarchicalZRenderer({.light = light}); });
    copies([](std::size_t) { return CoverageRenderer({.light = light}); });
}

namespace {

/// Fails in the frames of some bands.
struct FailingRenderer : ZBufferRenderer {
    FailingRenderer(std::size_t number, const ZBufferOptions& options, const bool& fails)
        : ZBufferRenderer(options), band(number), on(fails) {}
    std::size_t band;
    const bool& on;

    void end_frame() {
        if (on && band >= 2) throw std::runtime_error("band " + std::to_string(band));
        ZBufferRenderer::end_frame();
    }
};

}  // namespace

TEST_CASE("what a band throws reaches the caller, and the next frame is right") {
    const World& w = world();
    bool fails = true;
    auto viewer = make_banded_viewer(w.tensors, w.triangles, 8,
                                     [&](std::size_t band) { return FailingRenderer(band, {.light = light}, fails); });
    View view = looking({0.3, 0.9, 2});
    view.tolerance_px = 1;
    for (const unsigned threads : {1u, 2u, 3u, 8u}) {
        fails = true;
        CHECK_THROWS_WITH(viewer.frame(view, ThreadExecutor(threads)), "band 2");
        fails = false;
        viewer.frame(view, ThreadExecutor(threads));
        ZBufferRenderer at_once({.light = light});
        make_viewer(w.tensors, w.triangles, at_once).frame(view);
        CHECK(viewer.image() == at_once.image());
    }
    View wrong = view;
    wrong.height = 0;
    CHECK_THROWS_AS(viewer.frame(wrong), std::invalid_argument);
    CHECK_THROWS_AS(
        make_banded_viewer(w.tensors, w.triangles, 0, [](std::size_t) { return ZBufferRenderer({.light = light}); }),
        std::invalid_argument);
}

TEST_CASE("an executor may draw bands in any order") {
    const World& w = world();
    const ZBufferOptions options{.light = light};
    auto viewer = make_banded_viewer(w.cubes, w.triangles, 5, [&](std::size_t) { return ZBufferRenderer(options); });
    ZBufferRenderer at_once(options);
    View view = looking({0.3, 0.9, 2});
    view.tolerance_px = 2;
    make_viewer(w.cubes, w.triangles, at_once).frame(view);
    const AnyExecutor backwards = [](std::size_t count, const std::function<void(std::size_t)>& f) {
        for (std::size_t i = count; i-- > 0;) f(i);
    };
    viewer.frame(view, backwards);
    CHECK(viewer.image() == at_once.image());
}
