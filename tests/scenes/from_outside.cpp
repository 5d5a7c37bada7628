// A frame from outside: Shade et al. 1996, figure 3(c).
#include <cmath>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/image_cache.hpp"
#include "farfield/cost_model/measured_time.hpp"
#include "farfield/partition/octree.hpp"
#include "scenes/placed_scene.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::scenes;
using farfield::test::Random;

namespace {

/// Two rows of balls of small triangles, instances of one.
Scene rows_of_balls() {
    Random random(11);
    Group ball;
    for (int i = 0; i < 4000; ++i) {
        const glm::vec3 p = random.direction();
        ball.triangles.push_back({{p, p + 0.05f * random.direction(), p + 0.05f * random.direction()},
                                  {Rgba8{60, 60, 200, 255}, Rgba8{60, 60, 200, 255}, Rgba8{60, 60, 200, 255}}});
    }
    Scene scene{"balls", {ball, {}}};
    for (int i = 0; i < 12; ++i) {
        glm::mat4 place(1.0f);
        place[3] = glm::vec4(i % 2 ? 4 : -4, 0, -20 - 6 * i, 1);
        scene.groups[1].placements.push_back({0, place});
    }
    return scene;
}

}  // namespace

TEST_CASE("what a frame drew is seen from outside, with its frustum and its images outlined", "[scenes]") {
    using Cached = SpatialHierarchy<Octree, ImageCache<Exact>, MeasuredTime>;
    const PlacedScene<Cached> scene(
        rows_of_balls(), [](std::size_t) { return Octree{}; }, ImageCache<Exact>{});
    View view{.camera = Camera::perspective({0, 3, 0}, {0, 0, -50}, {0, 1, 0}, 0.8f), .width = 160, .height = 120};
    const auto plain = scene.viewer({}), onlooker = scene.viewer({.looks_on = true});
    std::uint64_t images = 0;
    for (int i = 0; i < 4; ++i) {
        view.camera.eye.x = 0.01 * i;
        images = onlooker->frame(view).images;
        plain->frame(view);
        CHECK(onlooker->image() == plain->image());
    }
    REQUIRE(images > 0);
    CHECK(plain->from_outside() == nullptr);
    const Image* const outside = onlooker->from_outside();
    REQUIRE(outside != nullptr);
    std::size_t red = 0, green = 0, blue = 0;
    for (const Rgba8 c : outside->pixels()) {
        red += c.r > 200 && c.g < 60;
        green += c.g > 120 && c.r < 60;
        blue += c.b > 60 && c.b > 2 * c.r;
    }
    CHECK(red > 50);
    CHECK(green > 50);
    CHECK(blue > 20);
    // It changes nothing of the next frame.
    plain->frame(view);
    onlooker->frame(view);
    CHECK(onlooker->image() == plain->image());
}

TEST_CASE("from outside nothing is shown of frames without images", "[scenes]") {
    using Plain = SpatialHierarchy<Octree, Exact, MeasuredTime>;
    const PlacedScene<Plain> scene(
        rows_of_balls(), [](std::size_t) { return Octree{}; }, Exact{});
    const auto viewer = scene.viewer({.looks_on = true});
    viewer->frame({.camera = Camera::perspective({0, 3, 0}, {0, 0, -50}, {0, 1, 0}, 0.8f), .width = 64, .height = 48});
    CHECK(viewer->from_outside() == nullptr);
}
