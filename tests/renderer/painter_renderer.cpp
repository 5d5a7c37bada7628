// Where order is right, the painter's picture is the z-buffer's.
#include "farfield/renderer/painter_renderer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "support/pictures.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

/// Halves along z, to the last item: a strict order for whatever is flat in z.
struct Layers {
    struct node_data {
        float z = 0;
    };
    static constexpr PartitionFacts facts{.offers = Assignment::unique,
                                          .ordering = OrderGuarantee::primitives,
                                          .splits_for_order = true,
                                          .file_tag = 0x4c415945u};

    Cell root(const Box& b) const {
        Cell c;
        c.center = c.bounds_center = b.center();
        c.half = c.bounds_half = 0.5f * b.size();
        return c;
    }
    Split choose(const Cell&, std::span<const Item> items, node_data& data) const {
        if (items.size() < 2) return Split::no;
        std::vector<float> z;
        for (const Item& item : items) z.push_back(item.bounds.center().z);
        std::nth_element(z.begin(), z.begin() + std::ptrdiff_t(z.size() / 2), z.end());
        data.z = z[z.size() / 2];
        return Split::always;
    }
    template <class Touches, class Emit>
    void place(const Cell&, const node_data& data, const Item& item, Touches&&, Emit&& emit) const {
        emit(item.bounds.center().z < data.z ? 0u : 1u);
    }
    Cell child(const Cell& cell, const node_data& data, unsigned child) const {
        const float low = child == 0 ? cell.center.z - cell.half.z : data.z;
        const float high = child == 0 ? data.z : cell.center.z + cell.half.z;
        Cell c = cell;
        c.center.z = 0.5f * (low + high);
        c.half.z = 0.5f * (high - low);
        c.bounds_center = c.center;
        c.bounds_half = c.half;
        c.bounds_half.z *= 1.001f;
        ++c.depth;
        return c;
    }
    void front_to_back(const Cell&, const node_data& data, glm::vec4 viewpoint, ChildOrder& order) const {
        const bool above = viewpoint.z - data.z * viewpoint.w > 0;
        order = above ? ChildOrder{1, 0, 2, 3, 4, 5, 6, 7} : ChildOrder{0, 1, 2, 3, 4, 5, 6, 7};
    }
};
using LayeredHierarchy = SpatialHierarchy<Layers, Exact, TriangleCount>;
using ExactHierarchy = SpatialHierarchy<Octree, Exact, TriangleCount>;

/// Each at a depth of its own, farthest first for whoever looks from above.
template <class P = Triangle>
std::vector<P> layers(std::size_t count, std::uint64_t seed, float size) {
    std::vector<P> out;
    for (const Triangle& t : random_triangles(count, seed, size)) {
        P p;
        p.vertices = t.vertices;
        for (glm::vec3& v : p.vertices) v.z = -1 + 2 * float(out.size()) / float(count);
        if constexpr (std::is_same_v<P, Triangle>) p.rgba = t.rgba;
        out.push_back(p);
    }
    return out;
}

template <class P>
Image painted(const std::vector<P>& primitives, const View& view, const PainterOptions& options = {},
              std::vector<Range> ranges = {}) {
    const LocalView local = local_view<P>(primitives, view);
    PainterRenderer renderer(options);
    Source<P> source{primitives, {}, std::uint32_t(primitives.size()), {}, 0};
    source.id = renderer.upload(source);
    renderer.begin_frame(local);
    renderer.set_view(local);
    if (ranges.empty()) ranges = {{0, source.item_count}};
    renderer.draw(source, std::span<const Range>(ranges));
    renderer.end_frame();
    return renderer.image();
}

ZBufferOptions as_z_buffer(const PainterOptions& o) {
    return {.samples = o.samples, .background = o.background, .light = o.light, .culls_back_faces = o.culls_back_faces};
}

View sized(View view, int width, int height) {
    view.width = width;
    view.height = height;
    return view;
}

/// All look down on the layers.
std::vector<View> views() {
    View near_plane = looking({0.1, 0.2, 1.3}, {0.3, 0.1, 0}, 60);
    near_plane.camera.near_depth = 0.8f;
    return {sized(looking({0.3, 0.2, 4}), 97, 61),
            looking({0.9, -0.8, 1.2}, {-0.5, 0.5, -0.5}, 64),
            near_plane,
            looking_orthographic({1, 1, 5}, {0.2, 0, 0}, 2.5f, 75),
            sized(looking({0, 0, 4}), 1, 1),
            sized(looking({0.3, 0, 4}), 5, 131)};
}

}  // namespace

static_assert(DrawableWith<LayeredHierarchy, Triangle, PainterRenderer>);
static_assert(!DrawableWith<ExactHierarchy, Triangle, PainterRenderer>, "the order of cells is not strict enough");

TEST_CASE("painter: back to front the picture is the z-buffer's", "[raster]") {
    Triangles triangles = layers(1500, 300, 0.2f);
    const Triangles large = layers(40, 301, 3);
    for (std::size_t i = 0; i < large.size(); ++i) triangles[i * 37] = large[i];
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        for (glm::vec3& v : triangles[i].vertices) v.z = -1 + float(i) / 750;
    }
    int n = 0;
    for (const View& view : views()) {
        for (const int samples : {1, 4, 9, 64}) {
            const PainterOptions options{.samples = samples,
                                         .background = {9, 8, 7, 6},
                                         .light = n % 2 == 0 ? std::optional(DirectionalLight{}) : std::nullopt,
                                         .culls_back_faces = n % 3 == 2,
                                         .simd = Simd(n % 4)};
            ++n;
            INFO(view.width << " x " << view.height << ", " << samples << " samples");
            CHECK(painted(triangles, view, options) == plain_picture<Triangle>(triangles, view, as_z_buffer(options)));
        }
    }
}

TEST_CASE("painter: vertex colors and translucent primitives too", "[raster]") {
    Random random(302);
    auto triangles = layers<VertexColoredTriangle>(900, 303, 0.4f);
    for (VertexColoredTriangle& t : triangles) {
        for (Rgba8& c : t.rgba) c = random.color();
        if (random.below(3) == 0) {
            for (Rgba8& c : t.rgba) c.a = std::uint8_t(random.below(256));
        }
        if (random.below(10) == 0) t.vertices[2] = t.vertices[0] + (t.vertices[1] - t.vertices[0]) * random.unit();
    }
    for (const View& view : views()) {
        for (const Simd simd : {Simd::scalar, Simd::four_lanes, Simd::eight_lanes, Simd::automatic}) {
            const PainterOptions options{.samples = 4, .light = DirectionalLight{}, .simd = simd};
            CHECK(painted(triangles, view, options) ==
                  plain_picture<VertexColoredTriangle>(triangles, view, as_z_buffer(options)));
        }
    }
}

TEST_CASE("painter: the last one stays, however far away", "[raster]") {
    Triangles walls = sheet({-9, -9, 1}, {18, 0, 0}, {0, 18, 0}, 1, 1, {250, 0, 0, 255});
    append(walls, sheet({-9, -9, -1}, {18, 0, 0}, {0, 18, 0}, 1, 1, {0, 250, 0, 255}));
    const View view = looking({0, 0, 3}, {}, 8);
    CHECK(painted(walls, view).at(4, 4) == Rgba8{0, 250, 0, 255});
    // In the order of ranges, not of positions; ranges may begin and end anywhere.
    CHECK(painted(walls, view, {}, {{2, 2}, {0, 2}}).at(4, 4) == Rgba8{250, 0, 0, 255});
    CHECK(painted(walls, view, {}, {{3, 0}}).at(4, 4).a == 0);
    CHECK(coverage(painted(walls, view, {}, {{0, 1}})) < 64);
}

TEST_CASE("painter: a viewer over a hierarchy that orders primitives", "[raster]") {
    Triangles triangles = layers(800, 304, 0.5f);
    Random random(305);
    random.shuffle(triangles);
    const LayeredHierarchy hierarchy = build<LayeredHierarchy>(triangles);
    std::vector<View> from = views();
    from.push_back(looking({0.2, 0.4, -3}, {}, 66));  // from below
    from.push_back(looking({3, 0.4, 0.1}, {0, 0, 0}, 66));
    from.push_back(looking({0.1, 0.1, 0.1}, {1, 0.4, 0.9}, 66));  // from between
    for (const View& view : from) {
        PainterRenderer renderer;
        auto viewer = make_viewer(hierarchy, triangles, renderer);
        for (int i = 0; i < 2; ++i) {
            viewer.frame(view);
            CHECK(different_pixels(renderer.image(), plain_picture<Triangle>(triangles, view)) == 0);
        }
    }
}

TEST_CASE("painter: one frame after the other is as good as each by a renderer of its own", "[raster]") {
    const Triangles triangles = layers(300, 306, 0.2f);
    Random random(307);
    const PainterOptions options{.samples = 4, .background = {30, 10, 50, 200}};
    PainterRenderer kept(options);
    Source<Triangle> source{triangles, {}, std::uint32_t(triangles.size()), {}, 0};
    source.id = kept.upload(source);
    for (int frame = 0; frame < 40; ++frame) {
        const glm::dvec3 eye = glm::dvec3(random.in_cube(3)), target = glm::dvec3(random.in_cube(1));
        View view = sized(looking(eye, target), 64, 48);
        if (frame % 7 == 6) view.camera.forward = -view.camera.forward;  // often nothing in sight
        if (frame % 11 == 10) view.width = 40 + int(random.below(30));
        const LocalView local = local_view<Triangle>(triangles, view);
        const Range some{random.below(150), random.below(150)};
        kept.begin_frame(local);
        kept.set_view(local);
        kept.draw(source, std::span<const Range>(&some, 1));
        kept.end_frame();
        INFO("frame " << frame);
        CHECK(kept.image() == painted(triangles, view, options, {some}));
    }
}

TEST_CASE("painter: degenerate triangles, and sources that come and go", "[raster]") {
    Triangles triangles = layers(30, 308, 0.3f);
    for (std::size_t i = 0; i < 20; ++i) triangles[i].vertices[1] = triangles[i].vertices[i % 3];
    for (const View& view : views()) CHECK(painted(triangles, view) == plain_picture<Triangle>(triangles, view));
    PainterRenderer renderer;
    Source<Triangle> a{triangles, {}, 10, {}, 0}, b{triangles, {}, 20, {}, 0};
    a.id = renderer.upload(a);
    b.id = renderer.upload(b);
    CHECK(a.id != b.id);
    renderer.release(a.id);
    CHECK(renderer.upload(a) == a.id);
}

TEST_CASE("painter: only squares of 1 to 8 are numbers of samples, and pictures have a size", "[raster]") {
    for (const int samples : {-1, 0, 2, 3, 65, 81}) {
        CHECK_THROWS_AS(PainterRenderer(PainterOptions{.samples = samples}), std::invalid_argument);
    }
    const Triangles triangles = layers(3, 309, 1);
    for (const int width : {-1, 0, 16001}) {
        CHECK_THROWS_AS(painted(triangles, sized(looking({3, 1, 2}), width, 10)), std::invalid_argument);
    }
}
