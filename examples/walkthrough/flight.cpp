#include "flight.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>

#include "ground.hpp"
#include "scenes/camera_path.hpp"

namespace walkthrough {
namespace {

using farfield::Camera;

constexpr float field_of_view = std::numbers::pi_v<float> / 3;

/// Looks from the eye at the target, with the scene's up on top or, where that is the way it looks, its front.
Camera camera(glm::vec3 eye, glm::vec3 target, const FrameOfReference& frame) {
    if (eye == target) target = eye - frame.front;
    const glm::vec3 side = glm::cross(glm::normalize(target - eye), frame.up);
    const glm::vec3 up = glm::dot(side, side) > 0x1p-40f ? frame.up : frame.front;
    return Camera::perspective(frame.in_scene(eye), frame.in_scene(target), up, field_of_view);
}

/// What stands for the size of a scene without one: a unit of its own, unless its coordinates leave no sense to that.
float size_of_point(const FrameOfReference& frame) {
    return std::ldexp(1.0f, std::clamp(-frame.exponent, -10, 10));
}

/// Of a uniform cubic B-spline through a closed ring of control points; t from 0 to the number of points.
template <std::size_t n>
glm::vec3 on_spline(const std::array<glm::vec3, n>& ring, float t) {
    const auto first = std::size_t(t);
    const float u = t - float(first);
    const auto p = [&](std::size_t i) { return ring[(first + i) % n]; };
    const float v = 1 - u;
    return (p(0) * (v * v * v) + p(1) * (3 * u * u * u - 6 * u * u + 4) +
            p(2) * (-3 * u * u * u + 3 * u * u + 3 * u + 1) + p(3) * (u * u * u)) *
           (1.0f / 6);
}

farfield::Box in_units(const farfield::Box& bounds, const FrameOfReference& frame) {
    return {frame.in_units(bounds.lower), frame.in_units(bounds.upper)};
}

/// Half the largest side of bounds in units.
float radius_of(const farfield::Box& bounds, const FrameOfReference& frame) {
    const float half = 0.5f * bounds.largest_side();
    return half > 0 ? half : size_of_point(frame);
}

/// Where things are: the middle of what is placed, or else of the triangles, and its spread. Where all are in one
/// place, as the two triangles of a wall that begin at the same corner, it is the middle of the bounds.
struct Whereabouts {
    glm::vec2 middle{0};
    float spread = 0;  ///< root mean square distance from the middle

    Whereabouts(const Setting& setting, const FrameOfReference& frame) {
        const farfield::scenes::Group& root = setting.scene.groups.back();
        const auto each = [&](auto&& f) {
            for (const auto& p : root.placements) f(frame.plan(frame.in_units(glm::vec3(p.to_parent[3]))));
            if (!root.placements.empty()) return;
            for (const auto& t : root.triangles) f(frame.plan(frame.in_units(t.vertices[0])));
        };
        glm::dvec2 sum(0);
        double count = 0, squares = 0;
        each([&](glm::vec2 p) {
            sum += glm::dvec2(p);
            ++count;
        });
        middle = glm::vec2(sum / count);
        each([&](glm::vec2 p) { squares += double(glm::dot(p - middle, p - middle)); });
        spread = float(std::sqrt(squares / count));
        if (spread > 0) return;
        const farfield::Box bounds = in_units(setting.bounds, frame);
        middle = frame.plan(bounds.center());
        spread = radius_of(bounds, frame);
    }
};

constexpr std::size_t ring_size = 8;
constexpr float ring_step = 2 * std::numbers::pi_v<float> / ring_size;

glm::vec2 direction(float angle) {
    return {std::sin(angle), std::cos(angle)};
}

/// Through a wide scene, between its rim and its middle, over its ground.
std::vector<Camera> fly_over(const Setting& setting, const FrameOfReference& frame, int frames) {
    const Ground ground(setting.scene, frame);
    const Whereabouts where(setting, frame);
    std::array<glm::vec3, ring_size> ring;
    for (std::size_t i = 0; i < ring_size; ++i) {
        constexpr float radii[] = {4.0f, 1.3f, 0.5f, 1.3f}, heights[] = {0.80f, 0.20f, 0.10f, 0.20f};
        const glm::vec2 plan = where.middle + where.spread * radii[i % 4] * direction(ring_step * float(i));
        ring[i] = frame.at(plan, ground.height(plan) + where.spread * heights[i % 4]);
    }
    const float least_height = 0.02f * where.spread;
    std::vector<Camera> cameras;
    for (int i = 0; i < frames; ++i) {
        const float t = float(ring_size) * float(i) / float(frames);
        glm::vec3 eye = on_spline(ring, t);
        const float height = std::max(frame.height(eye), ground.height(frame.plan(eye)) + least_height);
        eye = frame.at(frame.plan(eye), height);
        // Ahead, and the farther off the more to the middle, where there is something to see.
        const glm::vec2 ahead = frame.plan(on_spline(ring, t + 1.2f));
        const float away = glm::length(frame.plan(eye) - where.middle);
        const glm::vec2 target = glm::mix(ahead, where.middle, away / (away + where.spread));
        cameras.push_back(camera(eye, frame.at(target, ground.height(target)), frame));
    }
    return cameras;
}

/// Around a scene that is about as high as wide, now near, now far.
std::vector<Camera> fly_around(const Setting& setting, const FrameOfReference& frame, int frames) {
    const farfield::Box bounds = in_units(setting.bounds, frame);
    const glm::vec3 center = bounds.center();
    const float radius = radius_of(bounds, frame);
    std::array<glm::vec3, ring_size> ring;
    for (std::size_t i = 0; i < ring_size; ++i) {
        constexpr float radii[] = {1.3f, 3.0f, 9.0f, 3.0f}, heights[] = {0.1f, 0.5f, 1.5f, 0.0f};
        const glm::vec2 plan = direction(ring_step * float(i)) * radius * radii[i % 4];
        ring[i] = center + frame.at(plan, radius * heights[i % 4]);
    }
    std::vector<Camera> cameras;
    for (int i = 0; i < frames; ++i) {
        cameras.push_back(camera(on_spline(ring, float(ring_size) * float(i) / float(frames)), center, frame));
    }
    return cameras;
}

/// Straight down from one camera to the other. Each frame is lower by the same factor, so that things grow evenly.
std::vector<Camera> fly_down(const Camera& from, const Camera& to, glm::dvec3 up, int frames) {
    const double high = glm::dot(from.eye, up), low = glm::dot(to.eye, up);
    std::vector<Camera> cameras;
    for (int i = 0; i < frames; ++i) {
        const double t = frames > 1 ? double(i) / (frames - 1) : 0;
        const double height = high * std::pow(low / high, t);
        const glm::dvec3 eye = glm::mix(to.eye, from.eye, (height - low) / (high - low));
        const glm::dvec3 forward = glm::mix(glm::dvec3(from.forward), glm::dvec3(to.forward), t);
        cameras.push_back(Camera::perspective(eye, eye + forward, glm::vec3(up), field_of_view));
    }
    return cameras;
}

Camera look_at_center(const Setting& setting, const FrameOfReference& frame, double distance, double angle_degrees) {
    const glm::dvec3 center(setting.bounds.center());
    const double radius = double(radius_of(in_units(setting.bounds, frame), frame)) * std::ldexp(1.0, frame.exponent);
    const double angle = angle_degrees * std::numbers::pi / 180;
    const glm::dvec3 off = glm::dvec3(frame.right) * std::sin(angle) + glm::dvec3(frame.front) * std::cos(angle);
    return Camera::perspective(center + off * (distance * radius), center, frame.up, field_of_view);
}

}  // namespace

Flight plan_flight(const Setting& setting, const Options& options) {
    const FrameOfReference frame(setting.scene.up, setting.bounds);
    Flight flight;
    if (options.distance) {
        flight.cameras.assign(std::size_t(options.frames),
                              look_at_center(setting, frame, *options.distance, options.angle_degrees));
        flight.quality_frames = {0};
        return flight;
    }
    if (setting.descent && !options.path) {
        const auto& [from, to] = *setting.descent;
        flight.cameras = fly_down(from, to, glm::dvec3(frame.up), options.frames);
        // Few, for exact frames of what one descends to may take seconds. The first and the last are among them.
        const int pictures = std::min(options.frames, 3);
        for (int i = 0; i < pictures; ++i) {
            flight.quality_frames.push_back(pictures > 1 ? i * (options.frames - 1) / (pictures - 1) : 0);
        }
        return flight;
    }
    const glm::vec3 size = in_units(setting.bounds, frame).size();
    const glm::vec3 absolute_up = glm::abs(frame.up);
    const float tall = glm::dot(size, absolute_up), wide = glm::dot(size, (glm::vec3(1) - absolute_up) * 0.5f);
    flight.cameras = options.path      ? farfield::scenes::read_camera_path(*options.path).cameras(options.frames)
                     : setting.path    ? setting.path(options.frames)
                     : wide > 2 * tall ? fly_over(setting, frame, options.frames)
                                       : fly_around(setting, frame, options.frames);
    const int pictures = std::min(options.frames, 8);
    for (int i = 0; i < pictures; ++i) {
        flight.quality_frames.push_back(int(std::int64_t(i) * options.frames / pictures));
    }
    return flight;
}

}  // namespace walkthrough
