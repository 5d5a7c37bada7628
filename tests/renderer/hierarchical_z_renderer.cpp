// The picture is the z-buffer's, whatever the order, and what it calls hidden holds nothing that can be seen.
#include "farfield/renderer/hierarchical_z_renderer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/instance.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "support/pictures.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

using ExactHierarchy = SpatialHierarchy<Octree, Exact, TriangleCount>;

Cell cell_of(glm::vec3 center, glm::vec3 half) {
    return {.center = center, .half = half, .bounds_center = center, .bounds_half = half};
}

/// A frame driven by hand, in ranges of any kind.
template <class R, class P = Triangle>
class Frame {
  public:
    Frame(const std::vector<P>& primitives, const View& view, const ZBufferOptions& options = {})
        : renderer(options), primitives_(primitives), local_(local_view<P>(primitives, view)) {
        source_ = {primitives_, {}, std::uint32_t(primitives.size()), {}, 0};
        source_.id = renderer.upload(source_);
        renderer.begin_frame(local_);
        renderer.set_view(local_);
    }
    void draw(Range r) { renderer.draw(source_, std::span<const Range>(&r, 1)); }
    const Image& done() {
        renderer.end_frame();
        return renderer.image();
    }
    const LocalView& view() const { return local_; }
    R renderer;

  private:
    std::vector<P> primitives_;
    LocalView local_;
    Source<P> source_;
};

/// In pieces, the pieces in any order, questions between them.
template <class P>
Image in_pieces(const std::vector<P>& primitives, const View& view, const ZBufferOptions& options, Random& random) {
    Frame<HierarchicalZRenderer, P> frame(primitives, view, options);
    std::vector<Range> pieces;
    for (std::uint32_t first = 0; first < primitives.size();) {
        const std::uint32_t count = std::min(1 + random.below(70), std::uint32_t(primitives.size()) - first);
        pieces.push_back({first, count});
        first += count;
    }
    random.shuffle(pieces);
    for (const Range& r : pieces) {
        frame.draw(r);
        const glm::vec3 center = random.in_cube(2), half(random.unit());
        frame.renderer.hidden(cell_of(center, half), {});
    }
    return frame.done();
}

View sized(View view, int width, int height) {
    view.width = width;
    view.height = height;
    return view;
}

/// From outside, from inside with the near plane across everything, orthographic, and small odd images.
std::vector<View> views() {
    View near_plane = looking({0.3, 0.2, 0.1}, {1, 0.4, 0.3}, 70);
    near_plane.camera.near_depth = 0.4f;
    return {sized(looking({2.5, 1, 2}), 97, 61),
            looking({0.2, 0.1, 0.1}, {1, 0.2, 0.3}, 64),
            near_plane,
            looking_orthographic({2, 2, 3}, {0, 0, 0}, 2.5f, 75),
            looking_orthographic({0, 0, 0}, {1, 1, 0}, 2, 50),
            sized(looking({3, 1, 2}), 1, 1),
            sized(looking({3, 1, 2}), 7, 129)};
}

}  // namespace

TEST_CASE("hierarchical z: the picture is the z-buffer's for any order and number of samples", "[raster]") {
    Random random(400);
    // Small ones, and large ones that go through each other.
    Triangles triangles = mixed_triangles(2500, 401);
    append(triangles, random_triangles(120, 402, 0.7f));
    append(triangles, random_triangles(6, 403, 4));
    std::size_t n = 0;
    for (const View& view : views()) {
        for (const int samples : {1, 4, 9, 64}) {
            const ZBufferOptions options{.samples = samples,
                                         .background = {1, 2, 3, 4},
                                         .light = n % 2 == 0 ? std::optional(DirectionalLight{}) : std::nullopt,
                                         .culls_back_faces = n % 5 == 4,
                                         .simd = Simd(n % 4)};
            ++n;
            INFO(view.width << " x " << view.height << ", " << samples << " samples, near " << view.camera.near_depth);
            CHECK(in_pieces(triangles, view, options, random) == plain_picture<Triangle>(triangles, view, options));
        }
    }
}

TEST_CASE("hierarchical z: vertex colors and translucent primitives too", "[raster]") {
    Random random(404);
    std::vector<VertexColoredTriangle> triangles;
    for (const Triangle& t : mixed_triangles(1500, 405)) {
        triangles.push_back({t.vertices, {random.color(), random.color(), random.color()}});
        if (random.below(4) == 0) {
            for (Rgba8& c : triangles.back().rgba) c.a = std::uint8_t(random.below(256));
        }
        // Slivers, whose colors between corners are whatever rounding makes of them.
        if (random.below(10) == 0) {
            auto& v = triangles.back().vertices;
            v[2] = v[0] + (v[1] - v[0]) * (1 + random.between(-1e-6f, 1e-6f));
        }
    }
    for (const View& view : views()) {
        for (const Simd simd : {Simd::scalar, Simd::four_lanes, Simd::eight_lanes, Simd::automatic}) {
            const ZBufferOptions options{.samples = 4, .light = DirectionalLight{}, .simd = simd};
            CHECK(in_pieces(triangles, view, options, random) ==
                  plain_picture<VertexColoredTriangle>(triangles, view, options));
        }
    }
}

TEST_CASE("hierarchical z: what it calls hidden changes no sample", "[raster]") {
    Random random(406);
    int hidden = 0, seen = 0, wrong = 0;
    for (int round = 0; round < 40; ++round) {
        Triangles occluders = random_triangles(300, 407 + std::uint64_t(round), 0.5f);
        append(occluders, random_triangles(4, 500 + std::uint64_t(round), 3));
        const std::vector<View> from = views();
        const View view = sized(from[std::size_t(round) % from.size()], 30 + round, 41);
        const ZBufferOptions options{.samples = round % 3 == 0 ? 4 : 1};
        Frame<HierarchicalZRenderer> frame(occluders, view, options);
        frame.draw({0, std::uint32_t(occluders.size())});
        for (int i = 0; i < 150; ++i) {
            const float size = std::pow(10.0f, random.between(-4, 0.3f));
            const glm::vec3 center = random.in_cube(i % 3 == 0 ? 1.0f : 4.0f);
            const glm::vec3 half = glm::abs(random.in_cube(size));
            if (!frame.renderer.hidden(cell_of(center, half), {})) {
                ++seen;
                continue;
            }
            ++hidden;
            // Its faces, and triangles from any of its points to any other.
            Triangles with = occluders;
            const auto inside = [&] {
                glm::vec3 p = center;
                for (int axis = 0; axis < 3; ++axis) {
                    const float at = random.between(-1.5f, 1.5f);
                    p[axis] += half[axis] * std::clamp(at, -1.0f, 1.0f);
                }
                return p;
            };
            for (int k = 0; k < 30; ++k) {
                const glm::vec3 a = inside(), b = inside(), c = inside();
                with.push_back({{a, b, c}, {255, 255, 255, 255}});
            }
            // The view as it was, for its near plane depends on what is in the scene.
            Frame<ZBufferRenderer> all(with, view, options), without(occluders, view, options);
            all.renderer.begin_frame(frame.view());
            all.renderer.set_view(frame.view());
            all.draw({0, std::uint32_t(with.size())});
            without.draw({0, std::uint32_t(occluders.size())});
            wrong += all.done() != without.done();
        }
    }
    INFO(hidden << " hidden, " << seen << " not");
    CHECK(wrong == 0);
    CHECK(hidden > 500);
    CHECK(seen > 500);
}

TEST_CASE("hierarchical z: a wall hides what lies behind it, and nothing else", "[raster]") {
    for (const bool perspective : {true, false}) {
        for (const int samples : {1, 64}) {
            const Triangles wall = sheet({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 3, 3, {9, 9, 9, 255});
            const View view =
                perspective ? looking({0, 0, 3}, {0, 0, 0}, 80) : looking_orthographic({0, 0, 3}, {}, 3, 80);
            Frame<HierarchicalZRenderer> frame(wall, view, {.samples = samples});
            HierarchicalZRenderer& r = frame.renderer;
            const Cell behind = cell_of({0, 0, -0.5f}, glm::vec3(0.4f));
            CHECK_FALSE(r.hidden(behind, {}));
            frame.draw({0, std::uint32_t(wall.size())});
            CHECK(r.hidden(behind, {}));
            CHECK(r.hidden(cell_of({0.7f, -0.7f, -0.01f}, glm::vec3(0.005f)), {}));
            CHECK_FALSE(r.hidden(cell_of({0, 0, 0}, glm::vec3(0.4f)), {}));         // stands in it
            CHECK_FALSE(r.hidden(cell_of({0, 0, 0.5f}, glm::vec3(0.1f)), {}));      // before
            CHECK_FALSE(r.hidden(cell_of({1.2f, 0, -0.5f}, glm::vec3(0.4f)), {}));  // looks out beside it
            CHECK_FALSE(r.hidden(cell_of({0, 0, -0.5f}, {0.4f, 0.4f, 9}), {}));     // and reaches beyond the eye
            CHECK_FALSE(r.hidden(cell_of({0, 0, 0}, glm::vec3(1e6f)), {}));
            CHECK(r.hidden(cell_of({40, 0, -0.5f}, glm::vec3(0.4f)), {}));  // not in the picture at all
            frame.done();
        }
    }
}

TEST_CASE("hierarchical z: a gap of one sample shows what is behind", "[raster]") {
    for (const int samples : {1, 4, 64}) {
        const View view = looking_orthographic({0, 0, 3}, {}, 2, 64);
        const int side = int(std::lround(std::sqrt(samples))), n = 64 * side;
        // Samples are 2 / n wide; the wall lacks one column of them.
        const float gap = 2.0f * float(n / 2 + 5) / float(n) - 1, width = 2.0f / float(n);
        for (const bool with_gap : {false, true}) {
            Triangles wall = sheet({-1, -1, 0}, {gap + 1, 0, 0}, {0, 2, 0}, 1, 1, {9, 9, 9, 255});
            const float right = with_gap ? gap + width : gap;
            append(wall, sheet({right, -1, 0}, {1 - right, 0, 0}, {0, 2, 0}, 1, 1, {9, 9, 9, 255}));
            Frame<HierarchicalZRenderer> frame(wall, view, {.samples = samples});
            frame.draw({0, std::uint32_t(wall.size())});
            CHECK(frame.renderer.hidden(cell_of({0, 0, -1}, glm::vec3(0.7f)), {}) == !with_gap);
        }
    }
}

TEST_CASE("hierarchical z: a viewer leaves out what is hidden and the picture stays", "[raster]") {
    Random random(410);
    // Shelves of small things behind walls.
    Triangles scene;
    for (int floor = 0; floor < 12; ++floor) {
        append(scene, moved(random_triangles(2500, 411 + std::uint64_t(floor), 0.02f), 0.9f,
                            {0, 0, -3.0f * float(floor) - 1.5f}));
        append(scene, sheet({-1.5f, -1.5f, -3.0f * float(floor)}, {3, 0, 0}, {0, 3, 0}, 4, 4, {200, 90, 30, 255}));
    }
    const ExactHierarchy hierarchy = build<ExactHierarchy>(scene);
    for (const View& view : {looking({0.1, 0.2, 2.5}, {0, 0, -9}, 120), looking({0.1, 0.2, -16.3}, {0, 0, -30}, 77),
                             looking_orthographic({0, 0, 5}, {0, 0, 0}, 2.5f, 100)}) {
        HierarchicalZRenderer renderer;
        auto viewer = make_viewer(hierarchy, scene, renderer);
        const FrameStats stats = viewer.frame(view);
        CHECK(different_pixels(renderer.image(), plain_picture<Triangle>(scene, view)) == 0);
        CHECK(stats.cells_hidden > 0);
        CHECK(stats.primitives < scene.size() / 2);
    }
}

TEST_CASE("hierarchical z: instances of any scale hide each other", "[raster]") {
    using Inner = ExactHierarchy;
    Random random(412);
    Triangles things = random_triangles(3000, 413, 0.05f);
    append(things, sphere({0, 0, 0}, 1.1f, 24, {90, 120, 200, 255}));
    const Inner inner = build<Inner>(things);
    using Placed = Instance<Inner, Triangle>;
    std::vector<Placed> placed;
    for (int i = 0; i < 30; ++i) {
        const float scale = std::pow(10.0f, random.between(-0.5f, 0.5f));
        const glm::dvec3 at = glm::dvec3(random.in_cube(2)) + glm::dvec3(0, 0, -4.0 * i);
        placed.push_back(Placed{&inner, things, {glm::mat3(1.0f), scale, at}});
    }
    const auto outer = build<SpatialHierarchy<Octree, Exact, TriangleCount>>(placed);
    for (const View& view :
         {looking({0, 1, 12}, {0, 0, -20}, 100), looking_orthographic({3, 1, 12}, {0, 0, -20}, 12, 90)}) {
        HierarchicalZRenderer renderer;
        ZBufferRenderer reference;
        auto viewer = make_viewer(outer, placed, renderer);
        auto plain = make_viewer(outer, placed, reference);
        const FrameStats stats = viewer.frame(view);
        plain.frame(view);
        CHECK(renderer.image() == reference.image());
        CHECK(stats.cells_hidden > 0);
    }
}

TEST_CASE("hierarchical z: the far field over it is the z-buffer's", "[raster]") {
    Random random(414);
    const Triangles triangles = mixed_triangles(900, 415);
    for (int round = 0; round < 30; ++round) {
        const View view = views()[std::size_t(round) % 7];
        const ZBufferOptions options{.samples = round % 4 == 0 ? 9 : 1, .background = {30, 10, 50, 200}};
        Frame<HierarchicalZRenderer> frame(triangles, view, options);
        Frame<ZBufferRenderer> plain(triangles, view, options);
        for (int i = 0; i < 20; ++i) {
            Range some{random.below(600), random.below(300)};
            if (i % 4 != 0) some.law = AreaLaw(i % 3);
            const glm::vec3 low = random.in_cube(1), center = random.in_cube(1);
            const Face face{low, low + glm::vec3(0.2f, 0.2f, 0), {100, 100, 20, 120}, std::uint8_t(5)};
            const Splat splat{center, glm::vec2(0.03f), 0.8f, {200, 100, 50, std::uint8_t(i % 3)}};
            const auto draw = [&](auto& to) {
                to.draw(some);
                if (round % 2 == 0) to.renderer.draw(std::span<const Face>(&face, 1));
                if (round % 3 == 0) to.renderer.draw(std::span<const Splat>(&splat, 1));
            };
            draw(frame);
            draw(plain);
            // Whoever asks changes nothing.
            frame.renderer.hidden(cell_of(center, glm::vec3(0.1f)), {});
        }
        INFO("round " << round);
        CHECK(frame.done() == plain.done());
    }
}

TEST_CASE("hierarchical z: stand-ins and triangles of one hierarchy", "[raster]") {
    const Triangles triangles = sphere({0, 0, 0}, 1, 60, {200, 120, 60, 255});
    using Cubes = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
    const Cubes hierarchy = build<Cubes>(triangles);
    for (const float tolerance : {0.0f, 1.0f, 8.0f}) {
        HierarchicalZRenderer renderer;
        ZBufferRenderer reference;
        auto viewer = make_viewer(hierarchy, triangles, renderer);
        auto plain = make_viewer(hierarchy, triangles, reference);
        const View view = looking({3, 1, 2}, {}, 128, tolerance);
        viewer.frame(view);
        plain.frame(view);
        // What hides earlier closes fewer samples: here and there a deposit more or less.
        INFO("tolerance " << tolerance << ", RMS " << rms_difference(renderer.image(), reference.image()));
        CHECK(rms_difference(renderer.image(), reference.image()) <= (tolerance > 0 ? 0.01 : 0.0));
    }
}

TEST_CASE("hierarchical z: one frame after the other is as good as each by a renderer of its own", "[raster]") {
    const Triangles triangles = mixed_triangles(1200, 416);
    Random random(417);
    const ZBufferOptions options{.samples = 4, .background = {30, 10, 50, 200}};
    HierarchicalZRenderer kept(options);
    Source<Triangle> source{triangles, {}, std::uint32_t(triangles.size()), {}, 0};
    source.id = kept.upload(source);
    for (int frame = 0; frame < 40; ++frame) {
        const glm::dvec3 eye = glm::dvec3(random.in_cube(4)), target = glm::dvec3(random.in_cube(1));
        View view = sized(looking(eye, target), 64, 48);
        if (frame % 11 == 10) view.width = 40 + int(random.below(30));
        const LocalView local = local_view<Triangle>(triangles, view);
        kept.begin_frame(local);
        kept.set_view(local);
        const Range some{random.below(600), random.below(600)};
        kept.draw(source, std::span<const Range>(&some, 1));
        kept.end_frame();
        Frame<ZBufferRenderer> fresh(triangles, view, options);
        fresh.draw(some);
        INFO("frame " << frame);
        CHECK(kept.image() == fresh.done());
    }
}

TEST_CASE("hierarchical z: degenerate triangles and cells", "[raster]") {
    Triangles triangles = random_triangles(40, 418, 0.3f);
    for (std::size_t i = 0; i < 20; ++i) triangles[i].vertices[1] = triangles[i].vertices[i % 3];
    triangles.push_back({{glm::vec3(0), glm::vec3(0), glm::vec3(0)}, {1, 2, 3, 255}});
    triangles.push_back({{glm::vec3(-3e6f, 0, -1), glm::vec3(3e6f, 0, -1), glm::vec3(0, 2e6f, -2)}, {1, 2, 3, 255}});
    Random random(419);
    for (const View& view : views()) {
        CHECK(in_pieces(triangles, view, {}, random) == plain_picture<Triangle>(triangles, view));
        Frame<HierarchicalZRenderer> frame(triangles, view);
        frame.draw({0, 0});
        frame.draw({0, std::uint32_t(triangles.size())});
        const float infinity = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
        // Of what is no box nothing is said.
        CHECK_FALSE(frame.renderer.hidden(cell_of(glm::vec3(0), glm::vec3(infinity)), {}));
        CHECK_FALSE(frame.renderer.hidden(cell_of(glm::vec3(nan), glm::vec3(1)), {}));
        CHECK_FALSE(frame.renderer.hidden(cell_of(glm::vec3(0), glm::vec3(nan)), {}));
        CHECK_FALSE(frame.renderer.hidden(cell_of(frame.view().eye, glm::vec3(1)), {}));
    }
}

TEST_CASE("hierarchical z: only squares of 1 to 8 are numbers of samples, and pictures have a size", "[raster]") {
    for (const int samples : {-1, 0, 2, 3, 65, 81}) {
        CHECK_THROWS_AS(HierarchicalZRenderer(ZBufferOptions{.samples = samples}), std::invalid_argument);
    }
    HierarchicalZRenderer renderer;
    for (const int width : {-1, 0, 16001}) {
        const Triangles triangles = random_triangles(3, 420);
        CHECK_THROWS_AS(renderer.begin_frame(local_view<Triangle>(triangles, sized(looking({3, 1, 2}), width, 10))),
                        std::invalid_argument);
    }
}
