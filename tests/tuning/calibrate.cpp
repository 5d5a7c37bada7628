#include "farfield/tuning/calibrate.hpp"

#include <cmath>
#include <random>

#include "catch.hpp"
#include "farfield/build.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"

using namespace farfield;

namespace {

void check_prices(const MeasuredTime& prices) {
    for (const auto& [name, price] : detail::named_prices) {
        INFO(name << " " << prices.*price);
        CHECK(prices.*price > 0);
        CHECK(std::isfinite(prices.*price));
    }
}

/// Draws nothing but triangles, and asks for nothing.
struct Counting {
    static constexpr RendererFacts facts{};
    std::uint64_t frames = 0, triangles = 0;
    void begin_frame(const LocalView&) {}
    void set_view(const LocalView&) {}
    void end_frame() { ++frames; }
    template <class P>
    void draw(const Source<P>& source, std::span<const Range> ranges) {
        for (const Range r : ranges) {
            for (std::uint32_t i = r.first; i < r.first + r.count; ++i) triangles += source[i].rgba.a == 255;
        }
    }
};
static_assert(Renderer<Counting, Triangle>);

constexpr CalibrationOptions quick{.seconds = 0.05, .repetitions = 5};

}  // namespace

TEST_CASE("prices of the z-buffer are those of work that takes time") {
    for (const int samples : {1, 4}) {
        ZBufferRenderer renderer({.samples = samples});
        const MeasuredTime prices = calibrate(renderer, quick);
        check_prices(prices);
        // Another program may take the processor from one measurement, hardly from each of five.
        bool near_is_dearer = prices.near_triangle > prices.small_triangle;
        for (int again = 0; again < 4 && !near_is_dearer; ++again) {
            const MeasuredTime p = calibrate(renderer, quick);
            near_is_dearer = p.near_triangle > p.small_triangle;
        }
        CHECK(near_is_dearer);
    }
}

TEST_CASE("prices of a renderer without a far field") {
    Counting renderer;
    const MeasuredTime prices = calibrate(renderer, quick);
    check_prices(prices);
    CHECK(renderer.frames > 0);
    CHECK(renderer.triangles > 0);
    CHECK(prices.face == MeasuredTime().face);
    CHECK(prices.splat == MeasuredTime().splat);
}

TEST_CASE("what was measured builds hierarchies") {
    ZBufferRenderer renderer;
    const MeasuredTime prices = calibrate(renderer, quick);
    std::mt19937 random(1);
    std::vector<Triangle> triangles(5000);
    for (Triangle& t : triangles) {
        for (glm::vec3& v : t.vertices) v = glm::vec3(float(random() % 64), float(random() % 64), float(random() % 64));
        t.vertices[1] = t.vertices[0] + 0.01f * t.vertices[1];
        t.vertices[2] = t.vertices[0] + 0.01f * t.vertices[2];
    }
    using H = SpatialHierarchy<Octree, ColorCube, MeasuredTime>;
    const auto h = build<H>(triangles, {.cost_model = prices});
    CHECK(h.item_count() == triangles.size());
    CHECK(h.cost_policy().splat == prices.splat);
    auto viewer = make_viewer(h, triangles, renderer);
    const auto stats = viewer.frame({.camera = Camera::perspective({32, 32, 200}, {32, 32, 32}, {0, 1, 0}, 1)});
    CHECK(stats.cells_visited > 0);
}
