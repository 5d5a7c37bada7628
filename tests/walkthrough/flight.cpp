#include "flight.hpp"

#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "catch.hpp"
#include "setting.hpp"

using namespace walkthrough;
using farfield::Camera;
using farfield::VertexColoredTriangle;

namespace {

Setting setting_of(std::vector<VertexColoredTriangle> triangles, glm::vec3 up = {0, 1, 0}) {
    Setting setting;
    setting.scene.groups = {{std::move(triangles), {}}};
    setting.scene.up = up;
    setting.bounds = farfield::scenes::bounds(setting.scene);
    return setting;
}

Options frames(int count) {
    Options options;
    options.frames = count;
    return options;
}

bool is_camera(const Camera& c) {
    const auto is_unit = [](glm::vec3 v) { return std::abs(glm::length(v) - 1) < 1e-4f; };
    return std::isfinite(c.eye.x) && std::isfinite(c.eye.y) && std::isfinite(c.eye.z) && is_unit(c.right) &&
           is_unit(c.up) && is_unit(c.forward);
}

/// Whether the middle of the scene is within 45 degrees of where the camera looks.
bool looks_at(const Camera& c, const farfield::Box& bounds) {
    const glm::dvec3 to = glm::dvec3(bounds.center()) - c.eye;
    return glm::dot(to, glm::dvec3(c.forward)) > 0.7 * glm::length(to);
}

std::vector<VertexColoredTriangle> wall(glm::vec3 across, glm::vec3 up) {
    return {{{glm::vec3(0), across, across + up}, {}}, {{glm::vec3(0), across + up, up}, {}}};
}

}  // namespace

TEST_CASE("a descent begins and ends where the setting says, and sinks all the way") {
    Setting setting = setting_of(wall({10, 0, 0}, {0, 1, 0}));
    const Camera from = Camera::perspective({0, 800, 1100}, {0, 0, 0}, {0, 1, 0}, 1),
                 to = Camera::perspective({0, 7, 514}, {50, 7, 0}, {0, 1, 0}, 1);
    setting.descent = {from, to};
    const Flight flight = plan_flight(setting, frames(24));
    REQUIRE(flight.cameras.size() == 24);
    CHECK(glm::length(flight.cameras.front().eye - from.eye) < 1e-6);
    CHECK(glm::length(flight.cameras.back().eye - to.eye) < 1e-6);
    CHECK(glm::length(flight.cameras.back().forward - to.forward) < 1e-5f);
    for (std::size_t i = 0; i < 24; ++i) {
        CHECK(is_camera(flight.cameras[i]));
        if (i > 0) CHECK(flight.cameras[i].eye.y < flight.cameras[i - 1].eye.y);
    }
    CHECK(flight.quality_frames == std::vector<int>{0, 11, 23});
    CHECK(plan_flight(setting, frames(1)).quality_frames == std::vector<int>{0});
    CHECK(plan_flight(setting, frames(2)).quality_frames == std::vector<int>{0, 1});
}

TEST_CASE("a setting's own path is flown as it is") {
    Setting setting = setting_of(wall({10, 0, 0}, {0, 1, 0}));
    setting.path = [](int frames) {
        std::vector<Camera> cameras;
        for (int i = 0; i < frames; ++i) {
            cameras.push_back(Camera::perspective({double(i), 0, 5}, {5, 0, 0}, {0, 1, 0}, 1));
        }
        return cameras;
    };
    const Flight flight = plan_flight(setting, frames(16));
    REQUIRE(flight.cameras.size() == 16);
    for (std::size_t i = 0; i < 16; ++i) CHECK(flight.cameras[i].eye.x == double(i));
    CHECK(flight.quality_frames == std::vector<int>{0, 2, 4, 6, 8, 10, 12, 14});
}

TEST_CASE("a wall, a floor, a line and a point are flown around") {
    const std::vector<std::vector<VertexColoredTriangle>> scenes{
        wall({10, 0, 0}, {0, 1, 0}),
        wall({0, 0, 10}, {0, 1, 0}),
        wall({10, 0, 0}, {0, 0, 10}),
        wall({10, 0, 0}, {0, 0, 1e-40f}),
        wall({10, 0, 0}, {5, 0, 0}),
        wall({0, 0, 0}, {0, 0, 0}),
        {{{glm::vec3(1e30f), glm::vec3(1e30f), glm::vec3(1e30f)}, {}}}};
    for (const auto& triangles : scenes) {
        const Setting setting = setting_of(triangles);
        const Flight flight = plan_flight(setting, frames(48));
        REQUIRE(flight.cameras.size() == 48);
        int seen = 0;
        for (const Camera& c : flight.cameras) {
            CHECK(is_camera(c));
            seen += looks_at(c, setting.bounds);
        }
        CHECK(seen > 12);
    }
}

TEST_CASE("a flight does not depend on the unit of its scene") {
    const auto flat = wall({10, 0, 0}, {0, 1, 3}), tall = wall({10, 0, 0}, {0, 12, 3});
    for (const auto& triangles : {flat, tall}) {
        const Flight once = plan_flight(setting_of(triangles), frames(8));
        for (const int exponent : {-100, -40, 40, 100}) {
            auto scaled = triangles;
            for (auto& t : scaled) {
                for (glm::vec3& v : t.vertices) v *= std::ldexp(1.0f, exponent);
            }
            const Flight again = plan_flight(setting_of(scaled), frames(8));
            for (std::size_t i = 0; i < 8; ++i) {
                CHECK(again.cameras[i].eye == once.cameras[i].eye * std::ldexp(1.0, exponent));
                CHECK(again.cameras[i].forward == once.cameras[i].forward);
            }
        }
    }
}

TEST_CASE("random flat, thin, huge, tiny and far scenes have a flight") {
    std::mt19937 random(400);
    const auto number = [&] { return float(random() % 20001) / 10000 - 1; };
    const auto size = [&] {
        const unsigned kind = random() % 4;
        return kind == 0 ? 0.0f : std::ldexp(1.0f, int(random() % (kind == 1 ? 240 : 20)) - (kind == 1 ? 120 : 10));
    };
    for (int scene = 0; scene < 400; ++scene) {
        const glm::vec3 extent(size(), size(), size());
        const glm::vec3 at = random() % 2 ? glm::vec3(0) : glm::vec3(number(), number(), number()) * size();
        std::vector<VertexColoredTriangle> triangles(1 + random() % 20);
        for (auto& t : triangles) {
            for (glm::vec3& v : t.vertices) v = at + extent * glm::vec3(number(), number(), number());
        }
        const Setting setting = setting_of(triangles, random() % 2 ? glm::vec3(0, 1, 0) : glm::vec3(0, 0, 1));
        INFO("scene " << scene);
        Options options = frames(int(1 + random() % 12));
        std::size_t wrong = 0;
        for (const Camera& c : plan_flight(setting, options).cameras) wrong += !is_camera(c);
        options.distance = 0.5 + double(random() % 100);
        options.angle_degrees = double(random() % 360);
        for (const Camera& c : plan_flight(setting, options).cameras) {
            wrong += !is_camera(c) || !looks_at(c, setting.bounds);
        }
        CHECK(wrong == 0);
    }
}
