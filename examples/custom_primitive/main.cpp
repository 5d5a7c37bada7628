// Primitives of your own, in three ways: by members (ball.hpp), by a specialization for a type that cannot be changed
// (survey_quad.hpp), and as instances within instances (brick.hpp). Exits with 1 if a picture is not what it should be.
#include <cmath>
#include <iostream>
#include <span>
#include <string_view>
#include <vector>

#include "ball.hpp"
#include "brick.hpp"
#include "farfield/build.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "survey_quad.hpp"

using namespace farfield;

// What the compiler says about a type before it says anything else.
static_assert(!Primitive<int>);
static_assert(BuildableFrom<Hierarchy, Ball> && BuildableFrom<Hierarchy, survey::Quad>);
static_assert(BuildableFrom<Hierarchy, Brick> && DrawableWith<Hierarchy, Brick, ZBufferRenderer>);

namespace {

bool all_good = true;

void check(bool good, std::string_view what) {
    if (!good) std::cerr << "wrong: " << what << "\n";
    all_good = all_good && good;
}

struct Drawn {
    FrameStats stats;
    Image image;
    int covered_px = 0;
};

template <class P>
Drawn draw(const Hierarchy& hierarchy, const std::vector<P>& primitives, const View& view) {
    ZBufferRenderer renderer({.light = DirectionalLight{}});
    auto viewer = make_viewer(hierarchy, primitives, renderer);
    Drawn drawn{viewer.frame(view), renderer.image()};
    for (const Rgba8 c : drawn.image.pixels()) drawn.covered_px += c.a > 127;
    return drawn;
}

template <class P>
Hierarchy hierarchy_of(const std::vector<P>& primitives) {
    return build<Hierarchy>(primitives, {.sampler = DirectionalLight{}});
}

View look(glm::dvec3 eye, glm::dvec3 target) {
    return {.camera = Camera::perspective(eye, target, {0, 1, 0}, 0.8f), .width = 160, .height = 120};
}

void draw_balls() {
    std::vector<Ball> balls;
    for (int i = 0; i < 1000; ++i) {
        const glm::vec3 place(i % 10, i / 10 % 10, i / 100);
        balls.push_back({place, 0.3f, {std::uint8_t(25 * (i % 10)), 120, 200}});
    }
    const Hierarchy hierarchy = hierarchy_of(balls);
    const Drawn near = draw(hierarchy, balls, look({4.5, 8, 25}, {4.5, 4.5, 4.5}));
    const Drawn far = draw(hierarchy, balls, look({4.5, 80, 250}, {4.5, 4.5, 4.5}));
    std::cout << "balls: " << near.stats.primitives << " near, and " << far.stats.primitives << " with "
              << far.stats.approximations << " stand-ins far\n";
    check(near.covered_px > 2000 && near.stats.primitives == balls.size(), "near balls are drawn, all of them");
    check(far.covered_px > 20 && far.stats.approximations > 0, "far balls have stand-ins");
}

/// Hills on a grid of 64 x 64 pieces of 2 m.
std::vector<survey::Quad> hills(double east, double south) {
    std::vector<survey::Quad> quads;
    for (int i = 0; i < 64 * 64; ++i) {
        survey::Quad quad{};
        for (int corner = 0; corner < 4; ++corner) {
            const int x = i % 64 + (corner == 1 || corner == 2), z = i / 64 + (corner < 2);
            quad.east[corner] = east + 2 * x;
            quad.height[corner] = 6 * std::sin(0.2 * x) * std::cos(0.15 * z);
            quad.south[corner] = south + 2 * z;
        }
        quad.vegetation = std::uint8_t(i * 37 % 256);
        quads.push_back(quad);
    }
    return quads;
}

void draw_survey() {
    const glm::dvec3 far_off(1e7, 0, -1e7), eye(64, 30, 180), target(64, 0, 64);
    const std::vector<survey::Quad> here = hills(0, 0), there = hills(far_off.x, far_off.z);
    const Drawn at_origin = draw(hierarchy_of(here), here, look(eye, target));
    const Drawn at_survey = draw(hierarchy_of(there), there, look(eye + far_off, target + far_off));
    std::cout << "survey: " << at_survey.stats.primitives << " quads over " << at_survey.covered_px << " pixels\n";
    check(at_survey.covered_px > 2000, "the survey is drawn");
    check(at_survey.image == at_origin.image, "ten thousand kilometers off it looks as it does at the origin");
}

void draw_instances() {
    // A pyramid of four triangles; a wall of 16 x 16 pyramids; a town of 8 x 8 walls.
    const glm::vec3 top(0, 1, 0), corners[] = {{-0.5f, 0, -0.5f}, {-0.5f, 0, 0.5f}, {0.5f, 0, 0.5f}, {0.5f, 0, -0.5f}};
    std::vector<Brick> pyramid, wall, town;
    for (int i = 0; i < 4; ++i) {
        const Rgba8 color{220, std::uint8_t(60 + 40 * i), 60};
        pyramid.push_back({Triangle{{top, corners[i], corners[(i + 1) % 4]}, color}});
    }
    const auto fill = [](std::vector<Brick>& outer, const Hierarchy& hierarchy, const std::vector<Brick>& inner,
                         int side, glm::dvec3 right, glm::dvec3 up) {
        for (int i = 0; i < side * side; ++i) {
            Similarity place;
            place.translation = right * double(i % side) + up * double(i / side);
            outer.push_back({Brick::Instance{&hierarchy, inner, place}});
        }
    };
    const Hierarchy pyramid_hierarchy = hierarchy_of(pyramid);
    fill(wall, pyramid_hierarchy, pyramid, 16, {1, 0, 0}, {0, 1, 0});
    const Hierarchy wall_hierarchy = hierarchy_of(wall);
    fill(town, wall_hierarchy, wall, 8, {20, 0, 0}, {0, 0, 20});
    const Hierarchy town_hierarchy = hierarchy_of(town);

    const Drawn near = draw(town_hierarchy, town, look({78, 40, 230}, {78, 8, 70}));
    const Drawn far = draw(town_hierarchy, town, look({78, 400, 2300}, {78, 8, 70}));
    std::cout << "instances: " << near.stats.instances << " entered near for " << near.stats.primitives
              << " triangles, " << far.stats.approximations << " stand-ins far\n";
    check(near.covered_px > 2000 && near.stats.instances > 64, "instances within instances are drawn");
    check(far.covered_px > 10 && far.stats.approximations > 0 && far.stats.primitives == 0,
          "far off, a stand-in is drawn for a wall and all that is in it");
}

}  // namespace

int main() {
    draw_balls();
    draw_survey();
    draw_instances();
    return all_good ? 0 : 1;
}
