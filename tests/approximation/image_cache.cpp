#include "farfield/approximation/image_cache.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <new>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/measured_time.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/renderer/coverage_renderer.hpp"
#include "farfield/renderer/hierarchical_z_renderer.hpp"
#include "farfield/renderer/painter_renderer.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/storage/open.hpp"
#include "farfield/storage/save.hpp"
#include "farfield/viewer.hpp"
#include "support/image_walk.hpp"
#include "support/recorder.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

/// As a ZBufferRenderer, but for images, of which it makes none, or none after so many.
class FailingRenderer {
  public:
    static constexpr RendererFacts facts{.keeps_sources = true, .keeps_images = true};
    explicit FailingRenderer(const ZBufferOptions& options) : inner_(options) {}
    template <PrimitiveWithPolygons P>
    std::uint32_t upload(const Source<P>& source) {
        return inner_.upload(source);
    }
    void release(std::uint32_t id) { inner_.release(id); }
    void begin_frame(const LocalView& view) { inner_.begin_frame(view); }
    void set_view(const LocalView& view) { inner_.set_view(view); }
    void end_frame() { inner_.end_frame(); }
    template <class P>
    void draw(const Source<P>& source, std::span<const Range> ranges) {
        inner_.draw(source, ranges);
    }
    void begin_image(const LocalView& view, float depth, int samples) {
        ++asked;
        inner_.begin_image(view, depth, samples);
    }
    std::uint32_t end_image() {
        const std::uint32_t image = inner_.end_image();
        if (left_to_make > 0) {
            --left_to_make;
            return image;
        }
        inner_.free_image(image);
        return 0;
    }
    void free_image(std::uint32_t image) { inner_.free_image(image); }
    std::size_t image_bytes(int width, int height) const { return inner_.image_bytes(width, height); }
    void draw(std::span<const ImageQuad> quads) { inner_.draw(quads); }
    const Image& image() const { return inner_.image(); }

    int left_to_make = 0;
    int asked = 0;

  private:
    ZBufferRenderer inner_;
};

/// Images have red and blue changed.
class ShadesImages : public ZBufferRenderer {
  public:
    static constexpr RendererFacts facts = slice_by_slice;
    using ZBufferRenderer::ZBufferRenderer;
    void begin_image(const LocalView& view, float depth, int samples) {
        ZBufferRenderer::begin_image(view, depth, samples);
    }
    std::uint32_t end_image() {
        return end_shaded_image([](Image& image) {
            for (Rgba8& c : image.pixels()) std::swap(c.r, c.b);
        });
    }
};

}  // namespace

TEST_CASE("a hierarchy that caches images wants a renderer that keeps them", "[image_cache]") {
    STATIC_REQUIRE(DrawableWith<CachedImages, Triangle, ZBufferRenderer>);
    STATIC_REQUIRE(DrawableWith<CachedImages, Triangle, HierarchicalZRenderer>);
    using Forgetful = BasicRecorder<RendererFacts{.keeps_sources = true}>;
    STATIC_REQUIRE(!DrawableWith<CachedImages, Triangle, Forgetful>);
    STATIC_REQUIRE(DrawableWith<Plain, Triangle, Forgetful>);
    // What paints, or clips to coverage masks, has no depths to put an image among.
    STATIC_REQUIRE(!DrawableWith<CachedImages, Triangle, PainterRenderer>);
    STATIC_REQUIRE(!DrawableWith<CachedImages, Triangle, CoverageRenderer>);
}

TEST_CASE("image caches whose options make no sense are refused by name", "[image_cache]") {
    CHECK_THROWS_WITH(build<CachedImages>(balls(), {.approximation = with({.slices = 9})}),
                      Catch::Matchers::Contains("ImageCache: slices must be 1 to 8"));
    CHECK_THROWS_WITH(build<CachedImages>(balls(), {.approximation = with({.threshold_px = -1})}),
                      Catch::Matchers::Contains("threshold_px"));
    CHECK_THROWS_WITH(build<CachedImages>(balls(), {.approximation = with({.most_ahead = 1.5f})}),
                      Catch::Matchers::Contains("most_ahead"));
}

TEMPLATE_TEST_CASE("standing still makes images once, and no pixel changes", "[image_cache]", ZBufferRenderer,
                   HierarchicalZRenderer) {
    Walk<TestType> walk({.least_items = 64, .most_overhead = 4});  // the first frame may make all of them
    const View view = seen_from({0, 0, 0});
    const FrameStats first = walk.frame(view);
    CHECK(first.images_made > 0);
    CHECK(first.images >= first.images_made);
    const Image image = walk.image();
    // Texels lie where the samples lay, so the image of a cell is the cell.
    CHECK(difference(image, walk.exact(view)) < 1.0);
    for (int i = 0; i < 5; ++i) {
        const FrameStats stats = walk.frame(view);
        CHECK(stats.images_made == 0);
        CHECK(stats.images == first.images);
        CHECK(walk.image() == image);
    }
}

TEST_CASE("a renderer may shade an image before it is kept", "[image_cache]") {
    Walk<ShadesImages> walk({.least_items = 64, .most_overhead = 4}, free_images());
    const View view = seen_from({0, 0, 0});
    CHECK(walk.frame(view).images_made > 0);
    const Image& exact = walk.exact(view);
    int covered = 0, shaded = 0, other = 0;
    for (std::size_t i = 0; i < exact.pixels().size(); ++i) {
        const Rgba8 seen = walk.image().pixels()[i], was = exact.pixels()[i];
        if (was == Rgba8{90, 120, 160, 255}) continue;
        ++covered;
        if (seen == Rgba8{was.b, was.g, was.r, was.a}) {
            ++shaded;
        } else {
            other += seen != was;
        }
    }
    // A triangle at the edge of an image may win a pixel that another had.
    CHECK(covered > 500);
    CHECK(shaded > covered / 2);
    CHECK(other < covered / 50);
}

TEST_CASE("whatever a frame may make, a viewer that stands still soon makes no more", "[image_cache]") {
    for (const float overhead : {0.0f, 0.02f, 0.25f}) {
        for (const float making : {2e5f, 1e9f}) {
            Walk<> walk({.least_items = 64, .most_making = making, .most_overhead = overhead});
            const View view = seen_from({0.1, 0, 0});
            walk.frame(seen_from({0, 0, 0}));
            for (int i = 0; i < 100; ++i) walk.frame(view);
            const Image image = walk.image();
            for (int i = 0; i < 5; ++i) {
                CHECK(walk.frame(view).images_made == 0);
                CHECK(walk.image() == image);
            }
        }
    }
}

TEST_CASE("renewals are spread over frames, and cost little", "[image_cache]") {
    std::uint64_t total[2] = {0, 0}, most[2] = {0, 0};
    double squares[2] = {0, 0};
    for (const bool early : {false, true}) {
        Walk<> walk({.least_items = 64, .most_overhead = 4, .most_early = early ? 0.25f : 0.0f}, free_images());
        for (int f = 0; f < 300; ++f) {
            const double x = 0.06 * f - 9;
            const std::uint64_t made = walk.frame(seen_from({x, 0, 0}, {x, 0, -50})).images_made;
            if (f == 0) continue;
            total[early] += made;
            most[early] = std::max(most[early], made);
            squares[early] += double(made * made);
        }
    }
    INFO(total[0] << " made, at most " << most[0] << ", squares " << squares[0]);
    INFO("early: " << total[1] << " made, at most " << most[1] << ", squares " << squares[1]);
    CHECK(total[0] > 10);
    CHECK(total[1] >= total[0]);
    CHECK(most[1] <= most[0]);
    CHECK(double(total[1]) < 1.4 * double(total[0]));
}

TEST_CASE("images outlive frames while the viewer moves", "[image_cache]") {
    Walk<> walk;
    std::uint64_t made = 0, drawn = 0;
    double worst = 0, moved = 0;
    Image last;
    for (int f = 0; f < 60; ++f) {
        const View view = seen_from({0.02 * f, 0.01 * f, -0.02 * f});
        const FrameStats stats = walk.frame(view);
        made += stats.images_made;
        drawn += stats.images;
        worst = std::max(worst, difference(walk.image(), walk.exact(view)));
        if (f == 0) last = walk.exact(view);
    }
    moved = difference(last, walk.exact(seen_from({0.02 * 59, 0.01 * 59, -0.02 * 59})));
    CHECK(drawn > 4 * made);
    CHECK(worst < moved);  // so images do follow the viewer
}

TEST_CASE("a viewer that circles on the edge of a safety zone makes few images", "[image_cache]") {
    Walk<> walk;
    walk.frame(seen_from({0, 0, 0}));
    const std::uint64_t cells = walk.frame(seen_from({0, 0, 0})).images;
    std::uint64_t made = 0;
    for (int f = 0; f < 200; ++f) {
        const double a = 0.4 * f;
        // One image after another fails on the circle; a new one serves all around, or the old one again.
        made += walk.frame(seen_from({0.5 * std::cos(a), 0.5 * std::sin(a), 0})).images_made;
    }
    CHECK(made <= 200 * cells / 8);
}

TEST_CASE("a jump, another field of view and another size draw what is there", "[image_cache]") {
    Walk<> walk;
    for (int f = 0; f < 3; ++f) walk.frame(seen_from({0, 0, 0}));
    const auto settles = [&](const View& view) {
        for (int f = 0; f < 3; ++f) walk.frame(view);
        CHECK(difference(walk.image(), walk.exact(view)) < 1.0);
    };
    SECTION("jump") {
        settles(seen_from({60, 20, -50}));
    }
    SECTION("field of view") {
        View view = seen_from({0, 0, 0});
        view.camera = Camera::perspective({0, 0, 0}, {0, 0, -50}, {0, 1, 0}, 0.25f);
        const FrameStats stats = walk.frame(view);
        CHECK(difference(walk.image(), walk.exact(view)) < 1.0);  // no texel is magnified
        CHECK(stats.image_bytes > 0);
        settles(view);
    }
    SECTION("resolution") {
        View view = seen_from({0, 0, 0});
        view.width = 320;
        view.height = 240;
        settles(view);
    }
}

TEST_CASE("a viewer inside of a cell, and cells larger than the picture, are drawn as they are", "[image_cache]") {
    for (const double z : {-29.0, -30.0, -31.0, -35.0, -50.0}) {
        Walk<> walk;
        const View view = seen_from({0, 0, z}, {1, 1, z - 10});
        walk.frame(view);
        CHECK(difference(walk.image(), walk.exact(view)) < 1.0);
    }
    Walk<> walk;
    View small = seen_from({0, 0, -25});
    small.width = 16;
    small.height = 12;
    walk.frame(small);
    CHECK(difference(walk.image(), walk.exact(small)) < 1.0);
}

TEST_CASE("images never take more memory than the budget", "[image_cache]") {
    Walk<> plenty;
    std::uint64_t working_set = 0;
    for (int f = 0; f < 40; ++f) {
        working_set = std::max(working_set, plenty.frame(seen_from({0.2 * f, 0, 0})).image_bytes);
    }
    for (const std::uint64_t budget : {std::uint64_t(0), working_set / 8, working_set / 2}) {
        Walk<> walk({.least_items = 64, .budget_bytes = budget});
        for (int f = 0; f < 40; ++f) {
            const View view = seen_from({0.2 * f, 0, 0});
            REQUIRE(walk.frame(view).image_bytes <= budget);
            if (budget == 0) CHECK(walk.image() == walk.exact(view));
        }
        // A working set that does not fit is not made again and again.
        const View last = seen_from({8, 0, 0});
        for (int f = 0; f < 3; ++f) walk.frame(last);
        for (int f = 0; f < 5; ++f) CHECK(walk.frame(last).images_made == 0);
    }
}

TEST_CASE("a frame makes no more images than it may", "[image_cache]") {
    Walk<> walk({.least_items = 64, .most_made = 3});
    const View view = seen_from({0, 0, 0});
    std::uint64_t made = 0;
    for (int f = 0; f < 60; ++f) {
        const FrameStats stats = walk.frame(view);
        CHECK(stats.images_made <= 3);
        made += stats.images_made;
        CHECK(difference(walk.image(), walk.exact(view)) < 1.0);
    }
    CHECK(made > 3);
    CHECK(walk.frame(view).images_made == 0);
}

TEST_CASE("where a renderer fails to make an image, geometry is drawn", "[image_cache]") {
    Walk<FailingRenderer> walk;
    const View view = seen_from({0, 0, 0});
    const FrameStats stats = walk.frame(view);
    CHECK(walk.renderer.asked > 0);
    CHECK(stats.images == 0);
    CHECK(stats.images_made == 0);
    CHECK(walk.image() == walk.exact(view));
    // Cells below are asked for in its place, one level in a frame, and then none for a while.
    for (int f = 0; f < 12; ++f) walk.frame(view);
    const int asked = walk.renderer.asked;
    for (int f = 0; f < 40; ++f) walk.frame(view);
    CHECK(walk.renderer.asked == asked);
    CHECK(walk.image() == walk.exact(view));
}

TEST_CASE("two viewers on two threads draw what each draws alone", "[image_cache]") {
    const CachedImages hierarchy = build<CachedImages>(balls(), {.approximation = with({.least_items = 64})});
    const auto walk = [&](double sign) {
        ZBufferRenderer renderer;
        Viewer<CachedImages, Triangle, ZBufferRenderer> viewer(hierarchy, balls(), renderer);
        std::vector<Image> images;
        for (int f = 0; f < 10; ++f) {
            viewer.frame(seen_from({sign * 0.3 * f, 0, 0}));
            images.push_back(renderer.image());
        }
        return images;
    };
    const auto left = walk(-1), right = walk(1);
    std::vector<Image> left_again, right_again;
    std::thread other([&] { left_again = walk(-1); });
    right_again = walk(1);
    other.join();
    CHECK(left == left_again);
    CHECK(right == right_again);
}

TEST_CASE("a known path makes images that serve along it", "[image_cache]") {
    // The last motion leads away; what comes is known to stay. Parts of balls live through either.
    const ImageCacheOptions of_balls{.least_items = 500};
    Walk<> guesses(of_balls), knows(of_balls);
    std::uint64_t guessed = 0, known = 0;
    std::vector<glm::dvec3> stays(64, {20, 0, 0});
    for (int f = 0; f < 2; ++f) {
        const View view = seen_from({20.0 * f, 0, 0});
        if (f == 1) knows.viewer.expect(stays);
        guessed = guesses.frame(view).images_made;
        known = knows.frame(view).images_made;
    }
    CHECK(known > guessed);
}

TEST_CASE("images made ahead serve a steady viewer for longer, and follow one that turns back", "[image_cache]") {
    for (const bool turns_back : {false, true}) {
        std::uint64_t made[2] = {0, 0};
        double worst[2] = {0, 0};
        for (const bool ahead : {false, true}) {
            Walk<> walk({.least_items = 64, .most_overhead = 4, .most_ahead = ahead ? 0.75f : 0.0f}, free_images());
            for (int f = 0; f < 160; ++f) {
                const double x = 0.06 * (turns_back && f > 80 ? 160 - f : f) - 4;
                const View view = seen_from({x, 0, 0}, {x, 0, -50});
                made[ahead] += walk.frame(view).images_made;
                if (f % 8 == 0) worst[ahead] = std::max(worst[ahead], difference(walk.image(), walk.exact(view)));
            }
        }
        INFO(made[0] << " made, ahead " << made[1] << "; worst " << worst[0] << ", " << worst[1]);
        CHECK(made[0] > 10);
        CHECK(double(made[1]) < (turns_back ? 1.1 : 0.85) * double(made[0]));
        CHECK(worst[1] < 1.3 * worst[0]);
    }
}

TEST_CASE("whatever throws while an image is made, no slice of it stays", "[image_cache]") {
    CountedImages renderer{ZBufferOptions{}};
    std::vector<glm::dvec3> path;  // sideways, so that slices pay
    for (int i = 1; i < 60; ++i) path.push_back({0.3 * i, 0, 0});
    {
        const auto hierarchy = build<CachedImages>(
            balls(), {.approximation = with({.slices = 4, .least_items = 64}), .cost_model = free_images()});
        auto viewer = make_viewer(hierarchy, balls(), renderer);
        for (const int before : {0, 1, 2, 3, 7}) {
            viewer.forget_images();
            REQUIRE(renderer.alive == 0);
            renderer.left_to_make = before;
            viewer.expect(path);
            CHECK_THROWS_AS(viewer.frame(seen_from({0, 0, 0})), std::bad_alloc);
            CHECK(renderer.alive <= before);  // those of images that were finished
            viewer.forget_images();
            CHECK(renderer.alive == 0);
            renderer.left_to_make = 1'000'000;
            viewer.expect(path);
            const FrameStats stats = viewer.frame(seen_from({0, 0, 0}));
            CHECK(stats.images_made > 0);
            CHECK(renderer.alive > int(stats.images_made));  // there are slices
        }
    }
    CHECK(renderer.alive == 0);
}

TEST_CASE("where a renderer stops making images, the rest is geometry", "[image_cache]") {
    Walk<FailingRenderer> walk;
    walk.renderer.left_to_make = 3;
    const View view = seen_from({0, 0, 0});
    for (int f = 0; f < 3; ++f) {
        CHECK(walk.frame(view).images == 3);
        CHECK(difference(walk.image(), walk.exact(view)) < 1.0);
    }
}

TEMPLATE_TEST_CASE("depth slices hold what one image holds", "[image_cache]", ZBufferRenderer, HierarchicalZRenderer) {
    for (const int slices : {2, 4, 8}) {
        Walk<TestType> walk({.slices = slices, .least_items = 64}, free_images());
        const View view = seen_from({0, 0, 0});
        CHECK(walk.frame(view).images > 0);
        CHECK(difference(walk.image(), walk.exact(view)) < 1.0);
        const Image first = walk.image();
        CHECK(walk.frame(view).images_made == 0);
        CHECK(walk.image() == first);
    }
}

TEST_CASE("little opens between cells and depth slices of a surface that goes through all of them", "[image_cache]") {
    // A floor seen at a slant, and farther away nothing.
    const Triangles floor = sheet({-5, -2, -20}, {10, 0, 0}, {0, 1, -30}, 120, 120, {200, 180, 40, 255});
    const CachedImages cached = build<CachedImages>(
        floor, {.approximation = with({.slices = 4, .least_items = 1024}), .cost_model = free_images()});
    const Plain plain = build<Plain>(floor);
    ZBufferRenderer renderer, plain_renderer;
    auto viewer = make_viewer(cached, floor, renderer);
    auto plain_viewer = make_viewer(plain, floor, plain_renderer);
    std::uint64_t images = 0;
    int most = 0;
    for (int f = 0; f < 40; ++f) {
        const View view = seen_from({0.05 * f, 0.02 * f, 0}, {0, -2, -35});
        images += viewer.frame(view).images;
        plain_viewer.frame(view);
        most = std::max(most, covered_pixels(plain_renderer.image(), renderer.image()).lost);
    }
    CHECK(images > 30);
    CHECK(most <= 160);
}

TEST_CASE("a watertight wall shows its background no more than the threshold lets it", "[image_cache]") {
    // Split into cells with an image each, which move against one another by twice the threshold at most; the cells
    // are flat, so that it is far less.
    const Triangles surface = wall();
    const auto lost_at = [&](float threshold) {
        const CachedImages cached =
            build<CachedImages>(surface, {.approximation = with({.threshold_px = threshold, .least_items = 256})});
        ZBufferRenderer renderer;
        auto viewer = make_viewer(cached, surface, renderer);
        int lost = 0;
        for (int f = 0; f < 30; ++f) {
            const View view = seen_from({0.1 * f, 0.03 * f, 0}, {0, 0, -33});
            viewer.frame(view);
            for (int y = 30; y < 90; ++y) {
                for (int x = 40; x < 120; ++x) lost += renderer.image().at(x, y).a == 0 ? 1 : 0;
            }
        }
        return lost;
    };
    CHECK(lost_at(0) == 0);
    CHECK(lost_at(0.25f) <= 30 * 4);
    CHECK(lost_at(2) <= 30 * 96);
}

TEST_CASE("a bound of work bounds what a frame makes", "[image_cache]") {
    Walk<> all, some({.least_items = 64, .most_making = 120000}), none({.least_items = 64, .most_making = 0});
    const View view = seen_from({0, 0, 0});
    const std::uint64_t at_once = all.frame(view).images_made;
    CHECK(none.frame(view).images_made == 0);
    CHECK(none.image() == none.exact(view));
    std::uint64_t made = 0;
    for (int f = 0; f < 40; ++f) {
        const std::uint64_t now = some.frame(view).images_made;
        CHECK(now < at_once);
        made += now;
        CHECK(difference(some.image(), some.exact(view)) < 1.0);
    }
    CHECK(made > 0);
}

TEST_CASE("images that are dear to make are not made, whatever drawing them costs") {
    MeasuredTime dear = free_images();
    for (float MeasuredTime::*price : {&MeasuredTime::made_image, &MeasuredTime::made_texel}) {
        dear = free_images();
        dear.*price = 1e12f;
        Walk walk({.least_items = 64}, dear);
        for (int i = 0; i < 3; ++i) CHECK(walk.frame(seen_from({0, 0, 0.01 * i})).images_made == 0);
    }
    Walk walk({.least_items = 64}, free_images());
    CHECK(walk.frame(seen_from({0, 0, 0})).images_made > 0);
}

TEST_CASE("bounds of the motion decide how long an image lives", "[image_cache]") {
    const View view = seen_from({0, 0, 0});
    // Standing, images pay by the last motion; a viewer that may be anywhere in the next frame wants none.
    Walk<> leaps({.least_items = 64, .most_speed = 1e6f}), creeps({.least_items = 64, .most_speed = 1e-4f}),
        starts({.least_items = 64, .most_speed = 1e-4f, .most_acceleration = 1e6f});
    CHECK(leaps.frame(view).images_made == 0);
    CHECK(starts.frame(view).images_made == 0);
    CHECK(creeps.frame(view).images_made > 0);
    CHECK_THROWS_WITH(build<CachedImages>(balls(), {.approximation = with({.most_speed = -1})}),
                      Catch::Matchers::Contains("most_speed"));
}

TEST_CASE("images serve orthographic views, from wherever they look along one direction", "[image_cache]") {
    Walk<> walk;
    std::uint64_t made = 0, drawn = 0;
    for (int f = 0; f < 20; ++f) {
        View view = seen_from({0, 0, 0});
        const double x = 0.25 * f;
        view.camera = Camera::orthographic({x, 0, 0}, {x, 0, -50}, {0, 1, 0}, 20);
        const FrameStats stats = walk.frame(view);
        if (f > 0) made += stats.images_made;
        drawn += stats.images;
        CHECK(stats.images > 0);
        CHECK(difference(walk.image(), walk.exact(view)) < 25.0);
        if (f == 0) CHECK(difference(walk.image(), walk.exact(view)) < 1.0);
    }
    CHECK(10 * made <= drawn);  // what came into the picture
}

TEST_CASE("conservative images displace nothing by more than the threshold", "[image_cache]") {
    // Dots in colors of their own, alone in the picture.
    constexpr std::size_t dot_count = 45;
    Triangles dots;
    for (int i = 0; i < int(dot_count); ++i) {
        const int cluster = i / 9, in_cluster = i % 9;
        const float depth = 20 + 4 * float(cluster) + 0.4f * float(i * 7 % 9);
        const glm::vec2 at(float(cluster % 5) * 0.13f - 0.26f + 0.035f * float(in_cluster % 3),
                           float(cluster / 5) * 0.2f - 0.15f + 0.035f * float(in_cluster / 3));
        const float size = 0.012f * depth;
        const Triangles dot = sheet(glm::vec3(at * depth, -depth), {size, 0, 0}, {0, size, 0}, 8, 8,
                                    {std::uint8_t(10 + 5 * i), 255, std::uint8_t(250 - 5 * i), 255});
        dots.insert(dots.end(), dot.begin(), dot.end());
    }
    const auto centers = [&](const Image& image) {
        std::vector<glm::dvec3> sums(dot_count);
        for (int y = 0; y < image.height(); ++y) {
            for (int x = 0; x < image.width(); ++x) {
                const Rgba8 c = image.at(x, y);
                if (c.a != 255) continue;
                const auto i = std::size_t(std::max(c.r - 10 + 2, 0) / 5);
                if (i < sums.size()) sums[i] += glm::dvec3(x, y, 1);
            }
        }
        return sums;
    };
    for (const int slices : {1, 4}) {
        const CachedImages cached = build<CachedImages>(
            dots, {.approximation = with({.is_conservative = true, .slices = slices, .least_items = 2}),
                   .cost_model = free_images()});
        const Plain plain = build<Plain>(dots);
        FailingRenderer renderer{ZBufferOptions{}};
        renderer.left_to_make = 1 << 20;
        ZBufferRenderer plain_renderer;
        auto viewer = make_viewer(cached, dots, renderer);
        auto plain_viewer = make_viewer(plain, dots, plain_renderer);
        double worst = 0;
        std::size_t compared = 0;
        std::uint64_t images = 0, made = 0;
        for (int f = 0; f < 120; ++f) {
            View view = seen_from({0.01 * f, 0.005 * f, -9 + 0.06 * f}, {0.01 * f, 0, -40});
            view.width = 480;
            view.height = 360;
            const FrameStats stats = viewer.frame(view);
            images += stats.images;
            made += stats.images_made;
            plain_viewer.frame(view);
            const auto seen = centers(renderer.image()), truth = centers(plain_renderer.image());
            for (std::size_t i = 0; i < dot_count; ++i) {
                if (seen[i].z < 3 || truth[i].z < 3) continue;
                const glm::dvec2 d = glm::dvec2(seen[i]) / seen[i].z - glm::dvec2(truth[i]) / truth[i].z;
                worst = std::max(worst, std::sqrt(d.x * d.x + d.y * d.y));
                ++compared;
            }
        }
        CHECK(images > 2 * made);
        // Two pixels, and half of one that dots are rounded to.
        CHECK(worst <= 2.5);
        CHECK(worst > 0.25);
        CHECK(compared > 1000);
    }
}

TEST_CASE("hierarchies that cache images are stored as what they cache", "[image_cache]") {
    using OfCubes = SpatialHierarchy<Octree, ColorCube, MeasuredTime>;
    using CachedCubes = SpatialHierarchy<Octree, ImageCache<ColorCube>, MeasuredTime>;
    const auto saved = [](const auto& hierarchy) {
        std::vector<std::byte> bytes(saved_size(hierarchy));
        save(hierarchy, std::span<std::byte>(bytes));
        return bytes;
    };
    const std::vector<std::byte> bytes = saved(build<CachedCubes>(balls()));
    CHECK(bytes == saved(build<OfCubes>(balls())));
    const auto again = open<CachedCubes>(std::span<const std::byte>(bytes));
    CHECK(again.approximation_policy().images().threshold_px == ImageCacheOptions{}.threshold_px);
    CHECK(again.item_count() == balls().size());
}
