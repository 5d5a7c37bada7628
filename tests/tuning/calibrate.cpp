#include "farfield/tuning/calibrate.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "catch.hpp"
#include "farfield/build.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"

using namespace farfield;

namespace {

void check_prices(const MeasuredTime& prices) {
    for (const auto& named : detail::named_prices) {
        INFO(named.name << " " << prices.*named.price);
        CHECK(prices.*named.price > 0);
        CHECK(std::isfinite(prices.*named.price));
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

/// Keeps images, one slice at a time, and checks what is asked of it.
struct Keeping : Counting {
    static constexpr RendererFacts facts{.keeps_images = true};
    std::vector<bool> lives{true};
    std::uint64_t made = 0, shown = 0;
    bool is_open = false, is_wrong = false;
    using Counting::draw;
    void begin_image(const LocalView& view, float, int samples) {
        is_wrong = is_wrong || std::exchange(is_open, true) || view.width != view.height || samples != 1;
    }
    std::uint32_t end_image() {
        is_wrong = is_wrong || !std::exchange(is_open, false);
        ++made;
        lives.push_back(true);
        return std::uint32_t(lives.size() - 1);
    }
    void free_image(std::uint32_t image) {
        is_wrong = is_wrong || image == 0 || !lives[image];
        lives[image] = false;
    }
    std::size_t image_bytes(int, int) const { return 0; }
    void draw(std::span<const ImageQuad> quads) {
        for (const ImageQuad& q : quads) is_wrong = is_wrong || q.image == 0 || !lives[q.image];
        shown += quads.size();
    }
};
static_assert(Renderer<Keeping, Triangle>);

/// Its images cost 256 rounds of a loop each, and half a round for every texel.
struct Loops : Keeping {
    volatile unsigned spent = 0;
    int texels = 0;
    void begin_image(const LocalView& view, float depth, int samples) {
        texels = view.width * view.height;
        Keeping::begin_image(view, depth, samples);
    }
    std::uint32_t end_image() {
        for (int i = 0; i < 256 + texels / 2; ++i) spent = spent + 1;
        return Keeping::end_image();
    }
};

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

TEST_CASE("images are priced where a renderer keeps them, and all are freed") {
    Keeping renderer;
    const MeasuredTime prices = calibrate(renderer, quick);
    check_prices(prices);
    CHECK_FALSE(renderer.is_wrong);
    CHECK(renderer.made > 0);
    CHECK(renderer.shown > 0);
    CHECK(std::count(renderer.lives.begin() + 1, renderer.lives.end(), true) == 0);
    Counting without;
    const MeasuredTime other = calibrate(without, quick), defaults;
    CHECK(other.image == defaults.image);
    CHECK(other.texel == defaults.texel);
    CHECK(other.made_image == defaults.made_image);
    CHECK(other.made_texel == defaults.made_texel);
}

TEST_CASE("what an image takes is told from what its texels take") {
    // Whatever else runs on the machine, one of some tries comes near.
    bool is_near = false;
    for (int again = 0; again < 20 && !is_near; ++again) {
        Loops renderer;
        const MeasuredTime p = calibrate(renderer, {.seconds = 0.4, .repetitions = 25});
        const float ratio = p.made_image / p.made_texel;
        is_near = ratio > 128 && ratio < 2048;
    }
    CHECK(is_near);
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
