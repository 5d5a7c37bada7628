#include "farfield/raster/polygon_clip.hpp"

#include <cmath>
#include <vector>

#include "catch.hpp"
#include "support/random.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

namespace {

LocalView local(const View& view) {
    return LocalView(view, glm::dvec3(0), 8);
}

/// How far inside all that it is clipped to a point is; below 0: outside.
double inside(const glm::dvec3& p, const SampleProjection& to) {
    const double w = p.z * double(to.depth_weight) + double(to.depth_bias);
    const double reach = double(SampleProjection::guard_band) * 256 * w;
    double least = std::min(reach - std::abs(p.x), reach - std::abs(p.y)) / (double(to.focal.x) * 256);
    if (std::isfinite(to.near_depth)) least = std::min(least, p.z - double(to.near_depth));
    return least;
}

ClippedPolygon clipped(const std::vector<glm::vec3>& corners, const SampleProjection& to,
                       const std::vector<glm::vec4>& colors = {}) {
    ClippedPolygon polygon;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        polygon.add(corners[i], to, colors.empty() ? glm::vec4(0) : colors[i]);
    }
    polygon.clip(to);
    return polygon;
}

}  // namespace

TEST_CASE("what lies in front of the near plane and on the screen stays as it is", "[raster]") {
    const SampleProjection to(local(looking({0, 0, 5})), 4);
    const std::vector<glm::vec3> corners{{-1, -1, 0}, {1, -1, 0.5f}, {0.3f, 1, -2}, {-1, 0.5f, -1}};
    const ClippedPolygon polygon = clipped(corners, to);
    REQUIRE(polygon.size() == 4);
    for (std::size_t i = 0; i < 4; ++i) {
        CHECK_FALSE(polygon[i].is_cut);
        CHECK(polygon[i].rounded == to.project(corners[i]));
        SnappedTriangle t{};
        polygon.snap(i, to, t, 1);
        const glm::vec3 p = to.project(corners[i]);
        const float inverse = to.inverse_w(p.z);
        CHECK(t.x[1] == snapped_to_256th(p.x * inverse + to.offset_x));
        CHECK(t.y[1] == snapped_to_256th(p.y * inverse + to.offset_y));
        CHECK(t.q[1] == to.q(p.z, inverse));
    }
}

TEST_CASE("what is left lies inside, and nothing that lies inside is lost", "[raster]") {
    Random random(450);
    std::size_t cut = 0, gone = 0, lost = 0, outside = 0;
    for (int round = 0; round < 3000; ++round) {
        View view = round % 4 == 3 ? looking_orthographic({0, 0, 3}, {}, round % 8 == 3 ? 1e-4f : 2.0f)
                                   : looking({0, 0, 0.2}, {0, 0, -1});
        view.camera.near_depth = round % 2 == 0 ? 0.1f : 0.0f;
        const SampleProjection to(local(view), 4);
        const float size = std::pow(10.0f, random.between(-1, 2));
        std::vector<glm::vec3> corners{random.in_cube(size), random.in_cube(size), random.in_cube(size)};
        const ClippedPolygon polygon = clipped(corners, to);
        gone += polygon.size() == 0;
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            cut += polygon[i].is_cut;
            const double scale = glm::length(polygon[i].p / glm::dvec3(to.focal.x * 256, to.focal.y * 256, 1));
            outside += inside(polygon[i].p, to) < -1e-9 * (1 + scale * double(SampleProjection::guard_band));
        }
        // Points of the triangle, as combinations of its corners, are points of what is left if they lie inside.
        ClippedPolygon whole;
        for (const glm::vec3& c : corners) whole.add(c, to);
        const glm::dvec3 a = whole[0].p, b = whole[1].p, c = whole[2].p, normal = glm::cross(b - a, c - a);
        for (int i = 0; i < 20; ++i) {
            double u = random.unit(), v = random.unit();
            if (u + v > 1) u = 1 - u, v = 1 - v;
            const glm::dvec3 p = a + (b - a) * u + (c - a) * v;
            if (inside(p, to) < 1e-6) continue;
            bool holds = polygon.size() >= 3;
            for (std::size_t k = 0; k < polygon.size(); ++k) {
                const glm::dvec3 from = polygon[k].p, edge = polygon[(k + 1) % polygon.size()].p - from;
                const double side = glm::dot(glm::cross(edge, p - from), normal);
                holds = holds && side >= -1e-6 * glm::dot(normal, normal);
            }
            lost += !holds;
        }
    }
    CHECK(outside == 0);
    CHECK(lost == 0);
    CHECK(cut > 1000);
    CHECK(gone > 100);
}

TEST_CASE("polygons that share an edge share its cut points, bit by bit", "[raster]") {
    Random random(451);
    std::size_t compared = 0, different = 0;
    const SampleProjection to(local(looking({0, 0, 0}, {0, 0, -1})), 4);
    for (int round = 0; round < 3000; ++round) {
        const glm::vec3 a = random.in_cube(1), b = random.in_cube(1);
        const ClippedPolygon one = clipped({a, b, random.in_cube(1)}, to);
        const ClippedPolygon other = clipped({random.in_cube(1), b, a}, to);
        const auto is_in = [&](glm::vec3 p) { return inside(glm::dvec3(to.project(p)), to) > 0; };
        if (is_in(a) == is_in(b)) continue;
        // The cut points nearest to each other are those of the edge that both have.
        double least = 1e30;
        for (std::size_t i = 0; i < one.size(); ++i) {
            for (std::size_t k = 0; k < other.size(); ++k) {
                if (one[i].is_cut && other[k].is_cut) least = std::min(least, glm::distance(one[i].p, other[k].p));
            }
        }
        different += least != 0;
        ++compared;
    }
    CHECK(different == 0);
    CHECK(compared > 500);
}

TEST_CASE("colors vary linearly along what is cut", "[raster]") {
    View view = looking({0, 0, 0}, {0, 0, -1});
    view.camera.near_depth = 1;
    const SampleProjection to(local(view), 1);
    // From depth 0 to depth 4: cut at depth 1, a quarter of the way.
    const ClippedPolygon polygon =
        clipped({{0, 0, 0}, {1, 0, -4}, {0, 1, -4}}, to, {glm::vec4(0), glm::vec4(4, 0, 0, 4), glm::vec4(0, 4, 0, 4)});
    REQUIRE(polygon.size() == 4);
    std::size_t cut = 0;
    for (std::size_t i = 0; i < 4; ++i) {
        if (!polygon[i].is_cut) continue;
        ++cut;
        CHECK(polygon[i].p.z == Approx(1));
        CHECK(polygon[i].color.a == Approx(1));
        CHECK(polygon[i].color.r + polygon[i].color.g == Approx(1));
    }
    CHECK(cut == 2);
}

TEST_CASE("a polygon takes eight corners and leaves out the rest", "[raster]") {
    const SampleProjection to(local(looking({0, 0, 5})), 1);
    ClippedPolygon polygon;
    for (int i = 0; i < 12; ++i) {
        const float at = 6.2831853f * float(i) / 12;
        polygon.add({std::cos(at), std::sin(at), 0}, to);
    }
    CHECK(polygon.size() == ClippedPolygon::largest_input);
}
