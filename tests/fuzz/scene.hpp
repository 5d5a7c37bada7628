// Scenes and cameras that nobody would model, made from bytes: flat, huge, tiny, far from the origin, one in another.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/mat4x4.hpp>
#include <utility>
#include <vector>

#include "farfield/view.hpp"
#include "fuzz/input.hpp"
#include "scenes/scene.hpp"

namespace farfield::fuzz {

inline VertexColoredTriangle triangle(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, Input& in) {
    VertexColoredTriangle t{{a, b, c}, {}};
    t.rgba.fill({in.byte(), in.byte(), in.byte(), 255});
    return t;
}

/// Appends some triangles within [-1, 1] each way.
inline void add_patch(std::vector<VertexColoredTriangle>& out, Input& in) {
    const unsigned kind = in.below(10);
    const unsigned count = in.one_in(8) ? 64 + in.below(256) : 1 + in.below(24);
    const float size = in.one_in(3) ? 1.0f : std::ldexp(1.0f, -int(in.below(20)));
    const glm::vec3 at = in.point();
    const auto within = [&](const glm::vec3& p) { return glm::clamp(p, -1.0f, 1.0f); };
    const auto near_by = [&] { return within(at + size * in.point()); };
    for (unsigned i = 0; i < count; ++i) {
        glm::vec3 a = near_by(), b = near_by(), c = near_by();
        switch (kind) {
            case 0:  // any
                break;
            case 1: {  // in a plane of an axis
                const int axis = int(in.below(3));
                a[axis] = b[axis] = c[axis] = at[axis];
                break;
            }
            case 2:  // in an oblique plane
                for (glm::vec3* p : {&a, &b, &c}) p->z = 0.3f * p->x - 0.7f * p->y;
                break;
            case 3:  // on a line
                for (glm::vec3* p : {&a, &b, &c}) *p = at * p->x;
                break;
            case 4:  // in a point
                a = b = c = at;
                break;
            case 5:  // always the same
                a = at, b = within(at + glm::vec3(size, 0, 0)), c = within(at + glm::vec3(0, size, 0));
                break;
            case 6:  // needles
                c = b + (c - b) * 1e-5f;
                break;
            case 7:  // a wall of two, from end to end
                a = {-1, -1, at.z}, b = {1, -1, at.z}, c = i % 2 ? glm::vec3(-1, 1, at.z) : glm::vec3(1, 1, at.z);
                if (i % 2) b = {1, 1, at.z}, std::swap(b, c);
                break;
            case 8:  // one float's step apart
                b = a, c = a;
                b.x = std::nextafter(a.x, 2.0f);
                c.y = std::nextafter(a.y, 2.0f);
                break;
            default:  // leaves, each small
                b = within(a + 0.01f * (b - at)), c = within(a + 0.01f * (c - at));
        }
        out.push_back(triangle(a, b, c, in));
    }
}

/// All coordinates have the same unit and are within it each way, seen from the center. Colors are opaque.
struct Scene {
    scenes::Scene scene;
    glm::dvec3 center{0.0};
    double unit = 1;
};

inline Scene make_scene(Input& in) {
    Scene made;
    auto& groups = made.scene.groups;
    groups.emplace_back();
    if (!in.one_in(40)) {
        for (unsigned patches = 1 + in.below(4); patches > 0; --patches) add_patch(groups[0].triangles, in);
    }
    made.unit = in.power_of_two(100);
    // Where single precision ends: 2^-24 of the offset is a step of what is drawn.
    const double offset = in.one_in(3) ? std::ldexp(1.0, int(in.below(22))) : 0.0;
    made.center = made.unit * offset * glm::dvec3(in.point());
    const bool is_raw = in.one_in(30);
    for (VertexColoredTriangle& t : groups[0].triangles) {
        for (glm::vec3& v : t.vertices) v = glm::vec3(glm::dvec3(v) * made.unit + made.center);
        if (is_raw && in.one_in(4)) t.vertices[in.below(3)][int(in.below(3))] = in.finite();
    }
    if (in.one_in(4) && !groups[0].triangles.empty()) {
        // The same again, twice, turned about the center.
        scenes::Group outer;
        const glm::mat4 there = glm::translate(glm::mat4(1), glm::vec3(made.center));
        const glm::mat4 back = glm::translate(glm::mat4(1), glm::vec3(-made.center));
        for (unsigned copies = 1 + in.below(3); copies > 0; --copies) {
            const glm::vec3 axis = in.point() + glm::vec3(0, 0, 0.1f);
            glm::mat4 turn = glm::rotate(glm::mat4(1), 3 * in.coordinate(), glm::normalize(axis));
            turn = glm::scale(turn, glm::vec3(1 - 0.5f * std::abs(in.coordinate())));
            outer.placements.push_back({0, there * turn * back});
        }
        groups.push_back(std::move(outer));
    }
    return made;
}

/// Throws std::invalid_argument where the library refuses the camera.
inline View make_view(Input& in, const Scene& scene) {
    View view;
    view.width = 1 + int(in.below(70));
    view.height = 1 + int(in.below(70));
    constexpr std::array tolerances{0.0f, 0.25f, 1.0f, 4.0f, 30.0f, 1e9f};
    view.tolerance_px = tolerances[in.below(unsigned(tolerances.size()))];
    view.distance = in.one_in(4) ? DistanceMeasure::depth : DistanceMeasure::nearest_point;
    const auto& triangles = scene.scene.groups[0].triangles;
    const auto place = [&]() -> glm::dvec3 {
        if (in.one_in(6) && !triangles.empty()) {
            return glm::dvec3(triangles[in.bits() % triangles.size()].vertices[in.below(3)]);
        }
        return scene.center + scene.unit * glm::dvec3(in.point());
    };
    const glm::dvec3 target = place();
    glm::dvec3 eye = place();
    if (!in.one_in(4)) eye = target + (eye - target) * (1.0 + in.below(8)) + scene.unit * glm::dvec3(0, 0, 1.5);
    if (in.one_in(5)) eye = target + (eye - target) * std::ldexp(1.0, int(in.below(24)));
    const glm::vec3 up = in.one_in(8) ? in.point() : glm::vec3(0, 1, 0);
    float near_depth = in.one_in(5) ? float(scene.unit * in.power_of_two(20)) : 0.0f;
    if (!std::isfinite(near_depth)) near_depth = 0;
    const double distance = glm::length(eye - target);
    if (in.one_in(2)) {
        const double height = in.one_in(4) ? scene.unit * in.power_of_two(30) : 2.5 * scene.unit;
        view.camera = Camera::orthographic(eye, target, up, float(height), near_depth);
    } else {
        double angle = 2 * std::atan(1.3 * scene.unit / std::max(distance, scene.unit));
        if (in.one_in(4)) angle = 3.1 * (in.byte() + 0.01) / 256;
        view.camera = Camera::perspective(eye, target, up, float(angle), near_depth);
    }
    return view;
}

}  // namespace farfield::fuzz
