#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <random>
#include <set>
#include <utility>

#include "catch.hpp"
#include "scenes/load/polygon.hpp"

using farfield::scenes::detail::Triangulator;

namespace {

using Polygon = std::vector<glm::dvec3>;

glm::dvec3 doubled_area(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    return glm::cross(b - a, c - a);
}

glm::dvec3 doubled_area(const Polygon& polygon) {
    glm::dvec3 sum(0.0);
    for (std::size_t i = 2; i < polygon.size(); ++i) sum += doubled_area(polygon[0], polygon[i - 1], polygon[i]);
    return sum;
}

/// Triangles that all face as the polygon does, with its area in sum, cover it once and nothing else.
void check_covers_once(const Polygon& polygon) {
    Triangulator triangulator;
    const auto& triangles = triangulator(polygon);
    REQUIRE(triangles.size() == polygon.size() - 2);
    const glm::dvec3 whole = doubled_area(polygon);
    const double size = glm::length(whole);
    double sum = 0.0;
    for (const auto& [a, b, c] : triangles) {
        const double area = glm::dot(doubled_area(polygon[a], polygon[b], polygon[c]), whole) / size;
        CHECK(area >= -1e-12 * size);
        sum += area;
    }
    CHECK(std::abs(sum - size) <= 1e-9 * size);
}

void check_is_fan(const Polygon& polygon) {
    Triangulator triangulator;
    const auto& triangles = triangulator(polygon);
    REQUIRE(triangles.size() == polygon.size() - 2);
    for (std::uint32_t i = 0; i < triangles.size(); ++i) CHECK(triangles[i] == Triangulator::Triangle{0, i + 1, i + 2});
}

Polygon rotated(const Polygon& polygon, std::size_t first) {
    Polygon result;
    for (std::size_t i = 0; i < polygon.size(); ++i) result.push_back(polygon[(first + i) % polygon.size()]);
    return result;
}

/// From every first corner, both ways round, in three planes and of any size.
void check_in_all_ways(const Polygon& polygon) {
    for (std::size_t first = 0; first < polygon.size(); ++first) {
        CAPTURE(first);
        Polygon turned = rotated(polygon, first);
        check_covers_once(turned);
        std::reverse(turned.begin(), turned.end());
        check_covers_once(turned);
        for (glm::dvec3& p : turned) p = {p.y + 0.5 * p.x, p.z, p.x};
        check_covers_once(turned);
        for (glm::dvec3& p : turned) p = {0.25 * p.z, 2.0 * p.x - p.z, p.y};
        check_covers_once(turned);
    }
}

/// `outer` with `hole` joined to its corner `at` by a bridge.
Polygon with_hole(const Polygon& outer, std::size_t at, const Polygon& hole) {
    Polygon result(outer.begin(), outer.begin() + static_cast<std::ptrdiff_t>(at) + 1);
    result.insert(result.end(), hole.begin(), hole.end());
    result.push_back(hole[0]);
    result.insert(result.end(), outer.begin() + static_cast<std::ptrdiff_t>(at), outer.end());
    return result;
}

const Polygon square{{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}};

/// The outline of squares that grew one beside the other around no hole, with a corner at each unit of length.
Polygon outline_of_squares(std::mt19937& random, int count) {
    std::set<std::pair<int, int>> squares{{0, 0}};
    const auto in = [&](int x, int y) { return squares.count({x, y}) > 0; };
    while (static_cast<int>(squares.size()) < count) {
        auto from = squares.begin();
        std::advance(from, static_cast<std::ptrdiff_t>(random() % squares.size()));
        constexpr int steps[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
        const auto* step = steps[random() % 4];
        const int x = from->first + step[0], y = from->second + step[1];
        if (in(x, y)) continue;
        // Round the new square its neighbors must form one run, or it closes a hole.
        constexpr int around[8][2] = {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}};
        int changes = 0;
        for (int i = 0; i < 8; ++i) {
            const auto *p = around[i], *q = around[(i + 1) % 8];
            changes += in(x + p[0], y + p[1]) != in(x + q[0], y + q[1]);
        }
        if (changes == 2) squares.insert({x, y});
    }
    // Along the border with the inside on the left, from the lower left corner of the lowest of the leftmost.
    const int start_x = squares.begin()->first, start_y = squares.begin()->second;
    Polygon outline;
    int x = start_x, y = start_y, dx = 1, dy = 0;
    do {
        outline.push_back({x, y, 0});
        x += dx;
        y += dy;
        // The squares beside a step (ax, ay) from (x, y).
        const auto left = [&](int ax, int ay) {
            return in(x - (ax < 0 || ay > 0 ? 1 : 0), y - (ax < 0 || ay < 0 ? 1 : 0));
        };
        const auto right = [&](int ax, int ay) {
            return in(x - (ax < 0 || ay < 0 ? 1 : 0), y - (ax > 0 || ay < 0 ? 1 : 0));
        };
        for (const auto& [ax, ay] : {std::pair{-dy, dx}, std::pair{dx, dy}, std::pair{dy, -dx}}) {
            if (left(ax, ay) && !right(ax, ay)) {
                dx = ax;
                dy = ay;
                break;
            }
        }
    } while (x != start_x || y != start_y);
    return outline;
}

}  // namespace

TEST_CASE("polygons: convex ones become the fan of their first corner", "[scenes][load]") {
    check_is_fan({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
    check_is_fan(square);
    check_is_fan({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 2, 0}, {1, 2, 0}, {0, 2, 0}});    // corners in line
    check_is_fan({{0, 0, 0}, {0.1, 0.3, 0}, {0.2, 0.6, 0}, {0.3, 0.9, 0}, {-1, 1, 0}});  // in line but for rounding
    for (int n = 4; n < 100; ++n) {
        Polygon circle;
        for (int i = 0; i < n; ++i)
            circle.push_back({5e6 + 1e3 * std::cos(6.28 * i / n), 7, 1e3 * std::sin(6.28 * i / n)});
        check_is_fan(circle);
    }
    // Of no area, or not finite: nothing to choose from.
    check_is_fan({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}});
    check_is_fan({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}});
    check_is_fan({{0, 0, 0}, {3, 0, 0}, {1, 1, std::nan("")}, {0, 3, 0}});
    Triangulator triangulator;
    CHECK(triangulator({}).empty());
    CHECK(triangulator(std::vector<glm::dvec3>(2)).empty());
}

TEST_CASE("polygons: a concave one is covered once", "[scenes][load]") {
    check_in_all_ways({{0, 0, 0}, {4, 0, 0}, {1, 1, 0}, {0, 4, 0}});
    const Polygon u{{0, 0, 0}, {3, 0, 0}, {3, 3, 0}, {2, 3, 0}, {2, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}};
    check_in_all_ways(u);
    for (const double unit : {1e-300, 1e-30, 1e30, 1e299}) {
        Polygon scaled = rotated(u, 2);
        for (glm::dvec3& p : scaled) p *= unit;
        Triangulator triangulator, other;
        CHECK(triangulator(scaled) == other(rotated(u, 2)));
    }
    Polygon far_away = rotated(u, 2);
    for (glm::dvec3& p : far_away) p += glm::dvec3(500'000, 4'649'000, 300);
    Triangulator triangulator, other;
    CHECK(triangulator(far_away) == other(rotated(u, 2)));
}

TEST_CASE("polygons: holes joined by bridges, corners that touch, edges there and back", "[scenes][load]") {
    check_in_all_ways(with_hole(square, 0, {{1, 1, 0}, {1, 3, 0}, {3, 3, 0}, {3, 1, 0}}));
    check_in_all_ways(with_hole(square, 2, {{2, 1, 0}, {0.5, 0.5, 0}, {1, 2, 0}}));
    // The hole touches a corner, the middle of an edge, or the border's whole length but for a slit.
    check_in_all_ways(with_hole(square, 0, {{0, 0, 0}, {1, 3, 0}, {3, 3, 0}, {3, 1, 0}}));
    check_in_all_ways(with_hole(square, 0, {{3, 3, 0}, {4, 4, 0}, {3.5, 3, 0}}));
    check_in_all_ways(with_hole(square, 0, {{1, 1, 0}, {2, 4, 0}, {3, 1, 0}}));
    check_in_all_ways(
        with_hole(with_hole(square, 0, {{3, 1, 0}, {3, 2, 0}, {3.5, 1, 0}}), 0, {{1, 1, 0}, {1, 2, 0}, {2, 1, 0}}));
    check_in_all_ways({{0, 0, 0}, {2, 0, 0}, {4, 0, 0}, {4, 4, 0}, {2, 0, 0}, {0, 4, 0}});  // two triangles, one point
    check_in_all_ways(
        {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {2, 2, 0}, {1, 1, 0}, {2, 2, 0}, {0, 4, 0}});     // a crack into it
    check_in_all_ways({{0, 0, 0}, {4, 0, 0}, {6, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}});  // a whisker
    check_in_all_ways({{0, 0, 0}, {0, 0, 0}, {4, 0, 0}, {1, 1, 0}, {1, 1, 0}, {1, 1, 0}, {0, 4, 0}});  // corners twice
}

TEST_CASE("polygons: one that is not plane is covered as seen along the axis that it faces most", "[scenes][load]") {
    Polygon saddle{{0, 0, 1}, {4, 0, -1}, {1, 1, 0.5}, {0, 4, -2}};
    Triangulator triangulator;
    for (std::size_t first = 0; first < 4; ++first) {
        double sum = 0.0;
        const Polygon p = rotated(saddle, first);
        for (const auto& [a, b, c] : triangulator(p)) {
            const double area = doubled_area(p[a], p[b], p[c]).z;
            CHECK(area > 0.0);
            sum += area;
        }
        CHECK(sum == Approx(8.0));
    }
}

TEST_CASE("polygons: random outlines are covered once", "[scenes][load]") {
    std::mt19937 random(12);
    for (int round = 0; round < 60; ++round) {
        CAPTURE(round);
        const Polygon outline = outline_of_squares(random, 2 + round);
        check_covers_once(rotated(outline, random() % outline.size()));
        Polygon star;
        for (int i = 0; i < 5 + round; ++i) {
            const double angle = 6.28 * (i + 0.5 * static_cast<double>(random() % 1000) / 1000) / (5 + round);
            const double radius = 0.1 + static_cast<double>(random() % 1000) / 1000;
            star.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
        }
        check_covers_once(star);
    }
}

TEST_CASE("polygons: no corner in line is hidden behind a triangle without width", "[scenes][load]") {
    // Next door there may be polygons that have it, too: every corner is one of a triangle with an area.
    std::mt19937 random(5);
    for (int round = 0; round < 20; ++round) {
        CAPTURE(round);
        const Polygon outline = outline_of_squares(random, 12);
        Triangulator triangulator;
        std::vector<bool> seen(outline.size());
        for (const auto& triangle : triangulator(outline)) {
            const double area = doubled_area(outline[triangle[0]], outline[triangle[1]], outline[triangle[2]]).z;
            for (const std::uint32_t corner : triangle) seen[corner] = seen[corner] || area > 0.5;
        }
        CHECK(std::find(seen.begin(), seen.end(), false) == seen.end());
    }
}

TEST_CASE("polygons: spirals, combs and those that cross themselves do not take the square of their corners",
          "[scenes][load]") {
    constexpr int n = 20'000;
    Polygon spiral, comb, crossing;
    for (int i = 0; i < n; ++i) {
        const bool out = i < n / 2;
        const double angle = 0.13 * (out ? i : n - 1 - i), radius = angle + (out ? 1 : 3);
        spiral.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
        comb.push_back({0.5 * i, i % 4 == 1 || i % 4 == 2 ? 100 : 0, 0});
    }
    comb.push_back({n, -1, 0});
    comb.push_back({-1, -1, 0});
    std::mt19937 random(1);
    for (int i = 0; i < n; ++i) crossing.push_back({random() % 1000, random() % 1000, 0});
    check_covers_once(spiral);
    check_covers_once(comb);
    Triangulator triangulator;
    CHECK(triangulator(crossing).size() == n - 2);
}
