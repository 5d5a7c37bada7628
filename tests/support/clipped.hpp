// Scenes for partitions that cut polygons, and what holds for all of these partitions.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <glm/geometric.hpp>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/geometry/fragments.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "support/pictures.hpp"
#include "support/scenes.hpp"
#include "support/strict_order.hpp"

namespace farfield::test {

struct ClippedScene {
    std::string name;
    Triangles triangles;
};

inline std::vector<ClippedScene> clipped_scenes() {
    std::vector<ClippedScene> scenes;
    Random random(60);
    const auto add = [&](const char* name, Triangles t) { scenes.push_back({name, std::move(t)}); };
    const Rgba8 gray{128, 128, 128, 255};
    add("nothing", {});
    add("one", random_triangles(1, 61, 1));
    add("two that interpenetrate", {Triangle{{{{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}}}, gray},
                                    Triangle{{{{0, -1, -1}, {0, -1, 1}, {0, 1, 0}}}, gray}});
    add("three that overlap in a circle", [&] {
        Triangles t;
        for (int i = 0; i < 3; ++i) {
            const float a = 2.0944f * float(i), b = a + 2.0944f;
            const glm::vec3 from(std::cos(a), std::sin(a), -0.3f), to(std::cos(b), std::sin(b), 0.3f);
            const glm::vec3 wide = 0.2f * glm::normalize(glm::cross(to - from, {0, 0, 1}));
            t.push_back({{from - wide, to - wide, to + wide}, random.color()});
            t.push_back({{from - wide, to + wide, from + wide}, random.color()});
        }
        return t;
    }());
    add("interpenetrating", random_triangles(120, 62, 0.6f));
    add("many small", random_triangles(1500, 63, 0.06f));
    add("everything at once", mixed_triangles(900, 64));
    add("shared edges and vertices", sphere({0.1f, 0.2f, 0}, 0.9f, 12, gray));
    add("two spheres through one another", [&] {
        Triangles t = sphere({-0.3f, 0, 0}, 0.7f, 10, gray);
        append(t, sphere({0.3f, 0.1f, 0}, 0.7f, 9, {200, 40, 40, 255}));
        return t;
    }());
    add("coplanar, overlapping, facing either way", [&] {
        Triangles t = random_triangles(200, 65, 0.4f);
        for (Triangle& one : t)
            for (glm::vec3& v : one.vertices) v.z = 0.3f * v.x - 0.7f * v.y;
        return t;
    }());
    add("touching split planes", [&] {
        Triangles t;
        for (int i = -4; i <= 4; ++i) {
            append(t, sheet({-1, -1, 0.25f * float(i)}, {2, 0, 0}, {0, 2, 0}, 3, 3, random.color()));
            append(t, sheet({0.25f * float(i), -1, -1}, {0, 2, 0}, {0, 0, 2}, 2, 2, random.color()));
        }
        return t;
    }());
    add("duplicates", [&] {
        Triangles t;
        for (const Triangle& one : random_triangles(30, 66, 0.7f)) t.insert(t.end(), 9, one);
        return t;
    }());
    add("collinear", [&] {
        Triangles t = random_triangles(100, 67, 0.5f);
        for (Triangle& one : t)
            for (glm::vec3& v : one.vertices) v = glm::vec3(1, 2, -1) * v.x;
        return t;
    }());
    add("one huge among tiny", [&] {
        Triangles t = random_triangles(600, 68, 0.01f);
        t.insert(t.begin(), Triangle{{{{-60, -50, -1}, {70, -40, 2}, {0, 90, 0.5f}}}, gray});
        return t;
    }());
    add("slivers", [&] {
        Triangles t(150);
        for (Triangle& one : t) {
            const glm::vec3 from = random.in_cube(1), to = random.in_cube(1), beside = random.in_cube(1e-5f);
            one = {{from, to, to + beside}, random.color()};
        }
        return t;
    }());
    add("far from the origin", moved(random_triangles(300, 69, 0.4f), 1, {300, -200, 250}));
    add("tiny", moved(random_triangles(300, 70, 0.4f), 1e-12f));
    add("large", moved(random_triangles(300, 71, 0.4f), 1e12f));
    return scenes;
}

inline double area_of(std::span<const glm::vec3> polygon) {
    glm::dvec3 sum(0);
    for (std::size_t i = 2; i < polygon.size(); ++i) {
        sum += glm::cross(glm::dvec3(polygon[i - 1]) - glm::dvec3(polygon[0]),
                          glm::dvec3(polygon[i]) - glm::dvec3(polygon[0]));
    }
    return 0.5 * glm::length(sum);
}

inline double area_of(std::span<const Triangle> triangles) {
    double sum = 0;
    for (const Triangle& t : triangles) sum += area_of(t.vertices);
    return sum;
}

/// A scene's size and place as tests of order and of pictures want them.
struct Surroundings {
    glm::dvec3 center{0};
    double radius = 1, step = 0x1p-23;  ///< of single precision at the largest coordinate

    explicit Surroundings(std::span<const Triangle> triangles) {
        if (triangles.empty()) return;
        Box box = Box::empty();
        for (const Triangle& t : triangles) box.add(t.bounds());
        center = glm::dvec3(box.center());
        radius = 0.5 * double(glm::length(box.size()));
        const glm::vec3 reach = glm::max(glm::abs(box.lower), glm::abs(box.upper));
        step = 0x1p-23 * double(glm::max(reach.x, glm::max(reach.y, reach.z)));
    }

    /// From outside, from inside, and orthographic.
    std::vector<View> views(int size) const {
        std::vector<View> out;
        const glm::dvec3 directions[]{{1, 0.3, 0.5}, {-0.4, 1, 0.2}, {0.01, -0.2, -1}, {0, 0, 1}};
        for (const glm::dvec3& d : directions) {
            out.push_back(looking(center + radius * 2.2 * glm::normalize(d), center, size));
            out.push_back(looking(center + radius * 0.3 * d, center + radius * glm::dvec3(d.y, -d.z, d.x + 0.1), size));
            out.push_back(
                looking_orthographic(center + radius * 3.0 * glm::normalize(d), center, float(2 * radius), size));
        }
        return out;
    }
};

template <class H>
void check_strict_order(const H& h, std::span<const Triangle> triangles) {
    REQUIRE(h.keeps_strict_order());
    const Surroundings around(triangles);
    OrderRecorder recorder;
    auto viewer = make_viewer(h, triangles, recorder);
    std::uint64_t seed = 72;
    for (const View& view : around.views(64)) {
        viewer.frame(view);
        const OrderCheck check = check_order(recorder.polygons, view.camera.projection == Projection::perspective,
                                             around.radius, around.step, 150, ++seed);
        INFO("view " << seed - 72 << ", " << check.hits << " hits");
        CHECK(check.wrong == 0);
    }
}

template <class H>
void check_fragments(const H& h, std::span<const Triangle> triangles) {
    REQUIRE(h.fragments().first_vertex.size() == std::size_t(h.item_count()) + 1);
    REQUIRE(h.order().size() == h.item_count());
    double after = 0;
    std::size_t without_area = 0, turned = 0, colors = 0;
    std::vector<double> area(triangles.size());
    for (std::uint32_t at = 0; at < h.item_count(); ++at) {
        const Polygon p = h.fragments()[at];
        const Triangle& t = triangles[h.order()[at]];
        const double fragment = area_of(p.vertices);
        without_area += !(fragment > 0);
        after += fragment;
        area[h.order()[at]] += fragment;
        const glm::dvec3 was =
            glm::cross(glm::dvec3(t.vertices[1] - t.vertices[0]), glm::dvec3(t.vertices[2] - t.vertices[0]));
        const std::vector<glm::dvec3> v(p.vertices.begin(), p.vertices.end());
        glm::dvec3 is(0);
        for (std::size_t i = 2; i < v.size(); ++i) is += glm::cross(v[i - 1] - v[0], v[i] - v[0]);
        turned += !(glm::dot(is, was) > 0);
        for (const Rgba8& c : p.colors) colors += c != t.rgba;
    }
    CHECK(without_area == 0);
    CHECK(turned == 0);
    CHECK(colors == 0);
    const double before = area_of(triangles);
    const Surroundings around(triangles);
    // Each cut moves corners by up to a step.
    CHECK(std::abs(after - before) <= 1e-6 * before + double(h.item_count()) * around.step * around.radius);
    if (h.report().polygons_joined == 0) {
        std::size_t different = 0;
        for (std::size_t i = 0; i < triangles.size(); ++i) {
            const double whole = area_of(triangles[i].vertices);
            different += std::abs(area[i] - whole) > 1e-4 * whole + 64 * around.step * around.radius;
        }
        CHECK(different == 0);
    }
}

template <class H>
void check_pictures(const H& h, std::span<const Triangle> triangles) {
    const Surroundings around(triangles);
    const ZBufferOptions options{.samples = 16};
    ZBufferRenderer renderer(options);
    auto viewer = make_viewer(h, triangles, renderer);
    for (View view : around.views(96)) {
        view.tolerance_px = 0;
        viewer.frame(view);
        // Corners of fragments are snapped to 1/256 sample: one sample in 16 of a pixel here and there.
        CHECK(different_pixels(renderer.image(), plain_picture<Triangle>(triangles, view, options)) <= 96 * 96 / 100);
    }
}

}  // namespace farfield::test
