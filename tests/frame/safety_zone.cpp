#include "farfield/frame/safety_zone.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <random>

#include "catch.hpp"
#include "farfield/view.hpp"
#include "farfield/view/local_view.hpp"

using namespace farfield;

namespace {

using Engine = std::mt19937;

float uniform(Engine& engine, float low, float high) {
    return std::uniform_real_distribution<float>(low, high)(engine);
}
glm::vec3 in_box(Engine& engine, glm::vec3 center, glm::vec3 half) {
    return center + half * glm::vec3(uniform(engine, -1, 1), uniform(engine, -1, 1), uniform(engine, -1, 1));
}

LocalView looking(glm::vec3 eye, glm::vec3 target, float vertical_fov = 1) {
    View view;
    view.width = 640;
    view.height = 480;
    view.camera = Camera::perspective(glm::dvec3(eye), glm::dvec3(target), {0, 1, 0}, vertical_fov);
    return LocalView(view, glm::dvec3(0), 100.0f);
}

/// Of a box, seen from an eye that looks somewhere near it.
ImagePlace image_of(const LocalView& view, glm::vec3 center, glm::vec3 half) {
    const float depth = view.depth(center), reach = glm::dot(glm::abs(view.forward), half);
    return {view.eye, view.forward, center, half, depth, depth - reach, depth + reach, view.is_perspective};
}

glm::vec3 image_point(const ImagePlace& place, glm::vec3 a) {
    const glm::vec3 p = a - place.eye;
    return place.eye + p * (place.depth / glm::dot(p, place.forward));
}

double sine_between(glm::dvec3 a, glm::dvec3 b) {
    return glm::length(glm::cross(a, b)) / (glm::length(a) * glm::length(b));
}

/// Pixels from the center of the axis; none behind the viewer.
std::optional<glm::dvec2> pixel(const LocalView& view, glm::dvec3 p) {
    const glm::dvec3 d = p - glm::dvec3(view.eye);
    const double depth = glm::dot(d, glm::dvec3(view.forward));
    if (!(depth > 0)) return {};
    return glm::dvec2(glm::dot(d, glm::dvec3(view.right)), glm::dot(d, glm::dvec3(view.up))) * double(view.focal_px) /
           depth;
}

}  // namespace

TEST_CASE("the paper's error is the largest angle between corners and their images", "[safety_zone]") {
    Engine engine(1);
    for (int round = 0; round < 200; ++round) {
        const glm::vec3 center = in_box(engine, {0, 0, -40}, {10, 5, 10}), half(uniform(engine, 0.5f, 4));
        const LocalView view = looking({0, 0, 0}, in_box(engine, center, {5, 5, 5}));
        const ImagePlace place = image_of(view, center, half);
        const glm::vec3 eye = in_box(engine, view.eye, glm::vec3(3));
        double largest = 0;
        for (unsigned i = 0; i < 8; ++i) {
            const glm::vec3 a = detail::corner_of(place, i);
            largest = std::max(largest, sine_between(glm::dvec3(a - eye), glm::dvec3(image_point(place, a) - eye)));
        }
        REQUIRE(std::sqrt(double(squared_sine_at_corners(place, eye))) == Approx(largest).epsilon(1e-3).margin(1e-6));
        REQUIRE(squared_sine_at_corners(place, view.eye) == 0);
    }
}

TEST_CASE("no point of a box is displaced by more than the conservative bound", "[safety_zone]") {
    Engine engine(2);
    double tightest = 0, worst_of_paper = 0;
    for (int round = 0; round < 400; ++round) {
        const glm::vec3 half(uniform(engine, 0.2f, 6), uniform(engine, 0.2f, 6), uniform(engine, 0.2f, 6));
        const glm::vec3 center = in_box(engine, {0, 0, -40}, {15, 10, 15});
        const LocalView made = looking({0, 0, 0}, in_box(engine, center, {12, 8, 5}), uniform(engine, 0.5f, 1.6f));
        const ImagePlace place = image_of(made, center, half);
        const glm::vec3 eye = in_box(engine, made.eye, glm::vec3(uniform(engine, 0.01f, 6)));
        const LocalView view = looking(eye, in_box(engine, center, {12, 8, 5}), uniform(engine, 0.5f, 1.6f));
        const double angle = double(sine_bound(place, eye)), bound = double(displacement_bound_px(place, view));
        const double paper = double(displacement_px(place, view));
        for (int i = 0; i < 200; ++i) {
            const glm::vec3 a = in_box(engine, center, half), image = image_point(place, a);
            if (!(glm::dot(a - place.eye, place.forward) > 0)) continue;
            REQUIRE(sine_between(glm::dvec3(a - eye), glm::dvec3(image - eye)) <= angle * (1 + 1e-4) + 1e-6);
            const auto at = pixel(view, glm::dvec3(a)), drawn = pixel(view, glm::dvec3(image));
            if (!at || !drawn || std::abs(at->x) > 320 || std::abs(at->y) > 240) continue;
            const double displaced = glm::distance(*at, *drawn);
            REQUIRE(displaced <= bound * (1 + 1e-4) + 1e-3);
            if (bound < 8) tightest = std::max(tightest, displaced / bound);
            if (paper > 0.1 && paper < 8) worst_of_paper = std::max(worst_of_paper, displaced / paper);
        }
    }
    CHECK(tightest > 0.5);        // it is a bound, and not any bound
    CHECK(worst_of_paper > 1.0);  // "not a conservative estimate": pixels off center are worth more
    CHECK(worst_of_paper < 2.5);
}

TEST_CASE("inside the sphere of equation 4 corners keep to the angle, and on it one reaches it", "[safety_zone]") {
    Engine engine(3);
    for (int round = 0; round < 100; ++round) {
        const glm::vec3 center = in_box(engine, {0, 0, -30}, {5, 5, 5}), half(uniform(engine, 0.5f, 4));
        const LocalView made = looking({0, 0, 0}, center);
        const ImagePlace place = image_of(made, center, half);
        const float sine = detail::sine_of_pixels(2, made), radius = safety_radius(place, sine);
        const float bound = conservative_radius(place, sine);
        REQUIRE(radius > 0);
        REQUIRE(bound <= radius * 1.0001f);
        double reached = 0;
        for (int i = 0; i < 400; ++i) {
            const glm::vec3 way = glm::normalize(in_box(engine, {0, 0, 0}, {1, 1, 1}));
            reached = std::max(reached, std::sqrt(double(squared_sine_at_corners(place, place.eye + way * radius))));
            REQUIRE(sine_bound(place, place.eye + way * bound) <= sine * 1.001f);
        }
        REQUIRE(reached <= double(sine) * 1.001);
        CHECK(reached > double(sine) * 0.8);
    }
}

TEST_CASE("the distance to the point alone, as equation 4 is printed, makes the zone too large", "[safety_zone]") {
    // The point lies behind the rectangle, so its image is the nearer of both.
    ImagePlace place{{0, 0, 0}, {0, 0, -1}, {0, 0, -20}, {0, 0, 0}, 10, 20, 20};
    const float sine = 0.02f, h = 20, apart = 10, r = apart / (2 * sine);
    const float printed = std::sqrt(h * h + r * r + 2 * h * r * sine) - r;
    double largest = 0, largest_of_ours = 0;
    for (int i = 0; i <= 1000; ++i) {
        const float angle = 3.14159265f * float(i) / 1000;
        const glm::vec3 way(std::sin(angle), 0, std::cos(angle));
        largest = std::max(largest, std::sqrt(double(squared_sine_at_corners(place, way * printed))));
        const float ours = safety_radius(place, sine);
        largest_of_ours = std::max(largest_of_ours, std::sqrt(double(squared_sine_at_corners(place, way * ours))));
    }
    CHECK(largest > 1.3 * double(sine));
    CHECK(largest_of_ours == Approx(double(sine)).epsilon(0.01));
}

TEST_CASE("a parallel view moved sideways displaces nothing, turned it does", "[safety_zone]") {
    const auto parallel = [](glm::dvec3 eye, glm::dvec3 target) {
        View view;
        view.camera = Camera::orthographic(eye, target, {0, 1, 0}, 20);
        return LocalView(view, glm::dvec3(0), 20.0f);
    };
    const LocalView made = parallel({0, 0, 20}, {0, 0, 0});
    const ImagePlace place = image_of(made, {0, 0, 0}, {2, 2, 2});
    CHECK(displacement_px(place, parallel({3, 1, 25}, {3, 1, 0})) == Approx(0).margin(1e-4));
    const LocalView turned = parallel({2, 0, 20}, {0, 0, 0});
    // The farthest points lie two before the rectangle and two behind; 512 pixels show 20.
    const double sine = 2 / std::sqrt(404.0);
    CHECK(displacement_px(place, turned) == Approx(2 * sine * 512 / 20).epsilon(1e-4));
    CHECK(displacement_bound_px(place, turned) == displacement_px(place, turned));
    CHECK(std::isinf(displacement_px(place, looking({0, 0, 20}, {0, 0, 0}))));
}

TEST_CASE("life spans are found by doubling and bisection", "[safety_zone]") {
    for (const std::uint32_t last : {0u, 1u, 2u, 3u, 7u, 100u, 1023u, 1024u}) {
        CHECK(life_span(1024, [&](std::uint32_t k) { return k <= last; }) == last);
    }
    CHECK(life_span(10, [](std::uint32_t) { return true; }) == 10);
    CHECK(frames_within(10, 1, 0, 1000) == 10);
    CHECK(frames_within(10, 0, 0.2f, 1000) == 10);
    CHECK(frames_within(0, 1, 1, 1000) == 0);
}
