// What is in a box is drawn inside its silhouette and not nearer than it says, however all is rounded.
#include "farfield/coverage/polygons/silhouette.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>

#include "catch.hpp"
#include "farfield/raster/polygon_clip.hpp"
#include "support/masks.hpp"
#include "support/pictures.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

namespace {
/// What renderers allow contents to lie outside, 1/256 sample.
constexpr std::int64_t allowance = 8;

/// Least value of an edge function at the square around a point, as if the edge moved outwards by the allowance.
bool is_inside_grown(const TilePolygon& p, std::int64_t x, std::int64_t y) {
    for (int c = 0; c < p.corners; ++c) {
        const auto from = std::size_t(c), to = std::size_t((c + 1) % p.corners);
        const std::int64_t dx = p.x[to] - p.x[from], dy = p.y[to] - p.y[from];
        if (dx * (y - p.y[from]) - dy * (x - p.x[from]) + allowance * (std::abs(dx) + std::abs(dy)) < 0) return false;
    }
    const auto end = std::ptrdiff_t(p.corners);
    const auto [low_x, high_x] = std::minmax_element(p.x.begin(), p.x.begin() + end);
    const auto [low_y, high_y] = std::minmax_element(p.y.begin(), p.y.begin() + end);
    return x >= *low_x - allowance && x <= *high_x + allowance && y >= *low_y - allowance && y <= *high_y + allowance;
}
}  // namespace

TEST_CASE("what is in a box is drawn inside its silhouette and is not nearer", "[coverage]") {
    Random random(800);
    Silhouette silhouette;
    int projected = 0, few_corners = 0;
    for (int i = 0; i < 30000; ++i) {
        // Scenes far from their origin, boxes large and tiny, eyes near and far.
        const float far = i % 3 == 0 ? 0.0f : i % 3 == 1 ? 10.0f : 3000.0f;
        const glm::vec3 center = random.in_cube(far) + random.in_cube(1);
        const float size = std::exp2(-float(random.below(16)));
        const glm::vec3 half(size * random.unit(), size * random.unit(),
                             random.below(5) == 0 ? 0.0f : size * random.unit());
        const glm::vec3 direction = random.direction();
        const float distance = 0.01f + 5 * random.unit() * random.unit();
        const glm::vec3 aside = random.in_cube(1);
        const glm::dvec3 eye = glm::dvec3(center) - glm::dvec3(direction) * double(distance);
        const View view = random.below(4) == 0 ? looking_orthographic(eye, eye + glm::dvec3(direction + 0.3f * aside))
                                               : looking(eye, eye + glm::dvec3(direction + aside));
        const SampleProjection to(LocalView(view, glm::dvec3(0), 2 * far + 2), random.below(2) == 0 ? 1 : 8);
        if (!silhouette.project(center, half, to)) continue;
        ++projected;
        const TilePolygon& outline = silhouette.outline;
        few_corners += outline.corners < 3;
        REQUIRE(outline.corners >= 1);
        REQUIRE(outline.corners <= TilePolygon::most_corners);
        for (int c = 0; outline.corners > 2 && c < outline.corners; ++c) {
            const auto at = [&](int n) { return std::size_t(n % outline.corners); };
            const std::int64_t x1 = outline.x[at(c + 1)] - outline.x[at(c)],
                               y1 = outline.y[at(c + 1)] - outline.y[at(c)];
            const std::int64_t x2 = outline.x[at(c + 2)] - outline.x[at(c + 1)],
                               y2 = outline.y[at(c + 2)] - outline.y[at(c + 1)];
            REQUIRE(x1 * y2 - y1 * x2 > 0);  // clockwise, convex
        }
        for (int k = 0; k < 20; ++k) {
            const float x = inside_of(random, center.x, half.x), y = inside_of(random, center.y, half.y),
                        z = inside_of(random, center.z, half.z);
            const glm::vec3 p = to.project({x, y, z});
            const float inverse = to.inverse_w(p.z);
            if (to.q(p.z, inverse) > silhouette.fronts.nearest_q) {
                FAIL("nearer, frame " << i << ": " << to.q(p.z, inverse) << " > " << silhouette.fronts.nearest_q);
            }
            REQUIRE(silhouette.fronts.count >= 1);
            const float at_x = (p.x * inverse + to.offset_x) / 256 - 0.5f,
                        at_y = (p.y * inverse + to.offset_y) / 256 - 0.5f;
            for (int f = 0; f < silhouette.fronts.count; ++f) {
                const DepthPlane& front = silhouette.fronts.planes[std::size_t(f)];
                const float most = front.inside(front.at_corner + front.by_x * at_x + front.by_y * at_y);
                if (to.q(p.z, inverse) > most) {
                    FAIL("before a front, frame " << i << ": " << to.q(p.z, inverse) << " > " << most);
                }
            }
            const std::int32_t sx = snapped_to_256th(p.x * inverse + to.offset_x),
                               sy = snapped_to_256th(p.y * inverse + to.offset_y);
            if (!is_inside_grown(outline, sx, sy)) FAIL("outside, frame " << i << ": size " << size << ", at " << far);
        }
    }
    CHECK(projected > 10000);
    CHECK(few_corners > 10);
}

TEST_CASE("a box at the near plane, behind the eye or around it has no silhouette", "[coverage]") {
    const View view = looking({0, 0, 4});
    const SampleProjection to(LocalView(view, glm::dvec3(0), 8), 8);
    Silhouette s;
    CHECK(s.project({0, 0, 0}, glm::vec3(1), to));
    CHECK(s.outline.corners == 4);
    CHECK_FALSE(s.project({0, 0, 4}, glm::vec3(1), to));           // around the eye
    CHECK_FALSE(s.project({0, 0, 8}, glm::vec3(1), to));           // behind
    CHECK_FALSE(s.project({0, 0, 3}, glm::vec3(1), to));           // reaches the eye
    CHECK_FALSE(s.project({0, 0, -4}, glm::vec3(20), to));         // reaches behind it
    CHECK_FALSE(s.project({100, 0, 3.9f}, glm::vec3(0.01f), to));  // far beyond the guard band
    CHECK(s.project({5, 0, 0}, glm::vec3(1), to));                 // off the screen
    CHECK(s.project({0.1f, 0, 0}, glm::vec3(0), to));              // a point
    CHECK(s.outline.corners == 1);
    CHECK(s.project({0.1f, 0, 0}, {0.5f, 0, 0}, to));  // a line
    CHECK(s.outline.corners == 2);
}

TEST_CASE("the silhouette of a box across the view is its rectangle, at its front", "[coverage]") {
    const View view = looking_orthographic({0, 0, 4}, {0, 0, 0}, 4, 128);  // 32 pixels a unit
    const SampleProjection to(LocalView(view, glm::dvec3(0), 8), 1);
    Silhouette s;
    REQUIRE(s.project({0.5f, 0.25f, 0}, {0.25f, 0.5f, 1}, to));
    REQUIRE(s.outline.corners == 4);
    const auto [low_x, high_x] = std::minmax_element(s.outline.x.begin(), s.outline.x.begin() + 4);
    const auto [low_y, high_y] = std::minmax_element(s.outline.y.begin(), s.outline.y.begin() + 4);
    const auto near = [](std::int32_t a, double b) { return std::abs(double(a) - b) <= 2; };
    CHECK(near(*low_x, 256 * 32 * 0.25));
    CHECK(near(*high_x, 256 * 32 * 0.75));
    CHECK(near(*low_y, 256 * 32 * -0.75));
    CHECK(near(*high_y, 256 * 32 * 0.25));
    const float front = to.q(3, to.inverse_w(3));
    CHECK(s.fronts.nearest_q >= front);
    CHECK(s.fronts.nearest_q == Approx(front).epsilon(1e-4));
}
