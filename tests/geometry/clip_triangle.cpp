#include "farfield/geometry/clip_triangle.hpp"

#include <algorithm>
#include <cmath>

#include "catch.hpp"
#include "support/scenes.hpp"
#include "support/triangle_in_box.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

/// Twice its area along the normal.
template <class Corners>
glm::dvec3 doubled_area(const Corners& corners) {
    glm::dvec3 sum(0);
    for (std::size_t i = 2; i < corners.size(); ++i) {
        sum += glm::cross(glm::dvec3(corners[i - 1]) - glm::dvec3(corners[0]),
                          glm::dvec3(corners[i]) - glm::dvec3(corners[0]));
    }
    return sum;
}
double length(glm::dvec3 v) {
    return std::sqrt(glm::dot(v, v));
}
ClippedTriangle clipped(const Box& box, const Triangle& t) {
    return ClippedTriangle(box, {t.vertices[0], t.vertices[1], t.vertices[2]});
}
Box random_box(Random& random) {
    Box box = Box::empty();
    box.add(random.in_cube(1));
    box.add(random.in_cube(1));
    return box;
}

}  // namespace

TEST_CASE("a clipped triangle is the part of it that lies in the box", "[geometry]") {
    Random random(81);
    std::size_t most = 0;
    int clipped_ones = 0;
    for (int i = 0; i < 20000; ++i) {
        const Box box = random_box(random);
        Triangle t;
        const float size = i % 3 == 0 ? 4.0f : i % 3 == 1 ? 1.0f : 0.2f;
        const glm::vec3 center = random.in_cube(1);
        for (glm::vec3& v : t.vertices) v = center + random.in_cube(size);
        const ClippedTriangle c = clipped(box, t);
        const auto corners = c.corners();
        const glm::dvec3 whole = doubled_area(t.vertices), expected = doubled_area(clipped_to(t, box)),
                         found = doubled_area(corners);
        bool inside = true, in_the_plane = true;
        for (const glm::vec3 p : corners) {
            const float by = 1e-6f * (1 + size);
            inside &= box.contains(glm::clamp(p, box.lower, box.upper)) &&
                      glm::all(glm::lessThanEqual(glm::abs(p - glm::clamp(p, box.lower, box.upper)), glm::vec3(by)));
            const double off = glm::dot(glm::dvec3(p) - glm::dvec3(t.vertices[0]), whole) / length(whole);
            // Of a needle the plane is not known better.
            in_the_plane &= std::abs(off) <= 1e-5 * double(1 + size) / std::min(1.0, length(whole));
        }
        CHECK(inside);
        CHECK(in_the_plane);
        CHECK(corners.size() <= 9);
        CHECK(length(found - expected) <= 1e-5 * double(1 + size));
        most = std::max(most, corners.size());
        clipped_ones += !corners.empty() && length(expected) < 0.999 * length(whole);
    }
    CHECK(most >= 7);
    CHECK(clipped_ones > 2000);
}

TEST_CASE("a triangle inside stays as it is, of one outside nothing is left", "[geometry]") {
    Random random(82);
    const Box box{{-1, -1, -1}, {1, 1, 1}};
    for (int i = 0; i < 2000; ++i) {
        Triangle t;
        for (glm::vec3& v : t.vertices) v = random.in_cube(1);
        if (i % 4 == 0) t.vertices[1].x = 1;  // on the border
        const ClippedTriangle c = clipped(box, t);
        REQUIRE(c.corners().size() == 3);
        CHECK(std::equal(c.corners().begin(), c.corners().end(), t.vertices.begin()));
        glm::vec3 away(0);
        away[int(random.below(3))] = i % 2 ? 2.001f : -2.001f;
        const Triangle outside = moved({t}, 1, away)[0];
        CHECK(clipped(box, outside).corners().size() < 3);
    }
    // Its plane meets the box and it does not.
    CHECK(clipped(box, {{{{3, 0, 0}, {0, 3, 0}, {3, 3, 0}}}, {}}).corners().size() < 3);
    // All of the box's middle, whatever lies outside.
    CHECK(length(doubled_area(clipped(box, {{{{-50, -50, 0}, {50, -50, 0}, {0, 90, 0}}}, {}}).corners())) == Approx(8));
}

TEST_CASE("a box's parts share a triangle out among them", "[geometry]") {
    Random random(83);
    for (int i = 0; i < 2000; ++i) {
        const Box box = random_box(random);
        const glm::vec3 middle = glm::mix(box.lower, box.upper, random.between(0.2f, 0.8f));
        Triangle t;
        for (glm::vec3& v : t.vertices) v = random.in_cube(2);
        glm::dvec3 sum(0);
        for (int child = 0; child < 8; ++child) {
            Box part = box;
            for (int axis = 0; axis < 3; ++axis) {
                ((child >> axis & 1) != 0 ? part.lower : part.upper)[axis] = middle[axis];
            }
            sum += doubled_area(clipped(part, t).corners());
        }
        CHECK(length(sum - doubled_area(clipped(box, t).corners())) <= 1e-5);
    }
}

TEST_CASE("triangles without an area and boxes without a volume clip to numbers", "[geometry]") {
    Random random(84);
    const Box box{{-1, -1, -1}, {1, 1, 1}};
    for (int i = 0; i < 1000; ++i) {
        const glm::vec3 a = random.in_cube(2), b = random.in_cube(2), c = random.in_cube(2);
        Box flat = box;
        flat.lower[i % 3] = flat.upper[i % 3] = i % 2 ? a[i % 3] : 0.25f;
        const Box point{b, b};
        for (const Box& in : {box, flat, point}) {
            for (const Triangle& t : {Triangle{{a, a, a}, {}}, Triangle{{a, b, b}, {}}, Triangle{{a, b, a}, {}},
                                      Triangle{{a, b, c}, {}}, Triangle{{a, b, 0.5f * (a + b)}, {}}}) {
                const ClippedTriangle rest = clipped(in, t);
                CHECK(rest.corners().size() <= 9);
                CHECK(std::all_of(rest.corners().begin(), rest.corners().end(), [](glm::vec3 p) {
                    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
                }));
            }
        }
        // What lies in a flat box is all there.
        Triangle within{{a, b, c}, {}};
        for (glm::vec3& v : within.vertices) {
            v *= 0.5f;
            v[i % 3] = flat.lower[i % 3];
        }
        CHECK(clipped(flat, within).corners().size() == 3);
    }
}
