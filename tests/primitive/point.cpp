#include "farfield/primitive/point.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/color_cube_cluster.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/partition/polygon_bsp.hpp"
#include "farfield/viewer.hpp"
#include "support/pictures.hpp"
#include "support/random.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

static_assert(PrimitiveWithPolygons<Point> && PrimitiveWithColor<Point> && PrimitiveWithWork<Point>);
static_assert(!PrimitiveWithInstance<Point> && !has_double_bounds<Point>);

using Points = std::vector<Point>;
using Corners = std::vector<glm::vec3>;

std::vector<Corners> polygons_of(const Point& point) {
    std::vector<Corners> polygons;
    point.polygons([&](const Polygon& polygon) {
        CHECK(polygon.colors.size() == 1);
        CHECK(polygon.colors[0] == point.rgba);
        polygons.emplace_back(polygon.vertices.begin(), polygon.vertices.end());
    });
    return polygons;
}

/// Along the normal, as long as the area.
glm::dvec3 area_vector(const Corners& corners) {
    return 0.5 * doubled_area<double>(corners.size(), [&](std::size_t i) { return glm::dvec3(corners[i]); });
}

Points random_points(int count, std::uint64_t seed) {
    Random random(seed);
    Points points;
    for (int i = 0; i < count; ++i) {
        const glm::vec3 direction = random.direction();
        const bool is_disc = random.below(2) == 0;
        points.push_back({direction, 0.02f, is_disc ? direction : glm::vec3(0), random.color()});
    }
    return points;
}

}  // namespace

TEST_CASE("a point's box is the smallest that holds its corners", "[geometry]") {
    for (const Point& point : random_points(1000, 1)) {
        Box box = Box::empty();
        for (const Corners& corners : polygons_of(point)) {
            for (const glm::vec3& corner : corners) box.add(corner);
        }
        CHECK(point.bounds() == box);
    }
}

TEST_CASE("a disc faces along its normal, however long that is", "[geometry]") {
    Random random(2);
    for (const float length : {1.0f, 0x1p-140f, 0x1p-70f, 0x1p70f, 0x1p120f}) {
        for (int i = 0; i < 100; ++i) {
            glm::vec3 normal(0);
            if (i < 6) {
                normal[i % 3] = i < 3 ? 1 : -1;
            } else {
                normal = random.direction();
            }
            const Point point{random.in_cube(1), 0.25f, length * normal, {1, 2, 3, 255}};
            const auto polygons = polygons_of(point);
            REQUIRE(polygons.size() == 1);
            const glm::dvec3 area = area_vector(polygons[0]);
            CHECK(std::abs(glm::length(area) / point.area() - 1) < 1e-5);
            CHECK(glm::dot(glm::normalize(area), glm::dvec3(normal)) > 0.999);
            for (const glm::vec3& corner : polygons[0]) {
                CHECK(std::abs(glm::length(corner - point.position) / 0.25f - 1.0996f) < 1e-4f);
            }
            CHECK(point.work().triangles == float(polygons[0].size() - 2));
        }
    }
}

TEST_CASE("a ball is closed, faces outward, and is seen as a circle of its radius in the mean", "[geometry]") {
    const Point ball{{1, 2, 3}, 0.5f, {}, {1, 2, 3, 255}};
    const auto polygons = polygons_of(ball);
    CHECK(ball.work().triangles == float(polygons.size()));
    double sum = 0;
    glm::dvec3 all(0);
    for (const Corners& corners : polygons) {
        const glm::dvec3 area = area_vector(corners);
        CHECK(glm::dot(area, glm::dvec3(corners[0] - ball.position)) > 0);
        sum += glm::length(area);
        all += area;
    }
    CHECK(glm::length(all) < 1e-6);
    CHECK(std::abs(sum / ball.area() - 1) < 1e-5);

    Random random(3);
    double mean = 0, least = 10, most = 0;
    constexpr int directions = 20'000;
    for (int i = 0; i < directions; ++i) {
        const glm::dvec3 direction(random.direction());
        double seen = 0;
        for (const Corners& corners : polygons) seen += std::max(0.0, glm::dot(direction, area_vector(corners)));
        seen /= 3.14159265 * 0.25;
        mean += seen / directions;
        least = std::min(least, seen);
        most = std::max(most, seen);
    }
    CHECK(std::abs(mean - 1) < 0.003);
    CHECK(least > 0.8164);
    CHECK(least < 0.83);
    CHECK(most < 1.1548);
    CHECK(most > 1.14);
}

TEST_CASE("what is no number in a point shows in its box", "[geometry]") {
    const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
    for (const float bad : {nan, infinity, -infinity}) {
        for (const bool is_disc : {false, true}) {
            for (int axis = 0; axis < 3; ++axis) {
                Point point{{0, 0, 0}, 1, is_disc ? glm::vec3(0, 0, 1) : glm::vec3(0), {}};
                CHECK(point.bounds().is_finite());
                point.position[axis] = bad;
                CHECK_FALSE(point.bounds().is_finite());
            }
            CHECK_FALSE(Point{{0, 0, 0}, bad, is_disc ? glm::vec3(0, 0, 1) : glm::vec3(0), {}}.bounds().is_finite());
        }
        CHECK_FALSE(Point{{0, 0, 0}, 1, {0, bad, 0}, {}}.bounds().is_finite());
    }
}

TEST_CASE("a point without a radius is at its position", "[geometry]") {
    for (const glm::vec3 normal : {glm::vec3(0), glm::vec3(1, 2, 3)}) {
        const Point point{{1, 2, 3}, 0, normal, {}};
        CHECK(point.area() == 0);
        CHECK(point.bounds() == Box{{1, 2, 3}, {1, 2, 3}});
        CHECK_FALSE(polygons_of(point).empty());
    }
}

TEMPLATE_TEST_CASE("points are drawn by every approximation", "", (SpatialHierarchy<Octree, Exact, TriangleCount>),
                   (SpatialHierarchy<SharedOctree, Exact, TriangleCount>),
                   (SpatialHierarchy<Octree, ColorCube, TriangleCount>),
                   (SpatialHierarchy<Octree, ColorCubeCluster<2>, TriangleCount>),
                   (SpatialHierarchy<Octree, OpacityTensor, TriangleCount>),
                   (SpatialHierarchy<PolygonBsp, OpacityTensor, TriangleCount>)) {
    constexpr bool is_clipped = TestType::assignment == Assignment::clipped;
    const auto pictures = [](const Points& points, const View& view) {
        const auto hierarchy = build<TestType>(points);
        CHECK(hierarchy.report().primitives == points.size());
        ZBufferRenderer renderer;
        Viewer<TestType, Point, ZBufferRenderer> viewer(hierarchy, std::span<const Point>(points), renderer);
        const FrameStats stats = viewer.frame(view);
        return std::pair(renderer.image(), stats.approximations);
    };
    // A hollow sphere of discs and balls; clipped, each of them is cut by the planes of many others.
    const Points points = random_points(is_clipped ? 1000 : 6000, 4);
    const View close = looking({2, 1, 1}, {}, 96), distant = looking({8, 5, 3}, {}, 192, 24);
    const auto [exact, none] = pictures(points, close);
    CHECK(none == 0);
    const Image plain = plain_picture<Point>(points, close);
    // Corners of fragments are snapped.
    CHECK(different_pixels(exact, plain) <= (is_clipped ? 96 : 0));
    const auto [stand_ins, some] = pictures(points, distant);
    CHECK((some > 0) == TestType::approximation_type::facts.stands_in);
    // Cells as large as here are coarse, but none loses its points or makes walls of them.
    const double ratio = coverage(stand_ins) / coverage(plain_picture<Point>(points, distant, {.samples = 16}));
    CHECK(ratio > 0.5);
    CHECK(ratio < 2);

    // Many at one place, without a radius, and one far off.
    Points odd(500, Point{{1, 2, 3}, 0.5f, {}, {255, 0, 0, 255}});
    for (std::size_t i = 0; i < odd.size(); i += 3) odd[i].radius = 0;
    for (std::size_t i = 1; i < odd.size(); i += 3) odd[i].normal = {0, 1, 0};
    odd.push_back({{1000, 0, 0}, 1, {}, {0, 255, 0, 255}});
    const View view = looking({3, 4, 5}, {1, 2, 3}, 64);
    CHECK(different_pixels(pictures(odd, view).first, plain_picture<Point>(odd, view)) <= (is_clipped ? 64 : 0));
    const Points nothing(3, Point{});
    CHECK(coverage(pictures(nothing, view).first) == 0);
}
