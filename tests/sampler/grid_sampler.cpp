#include "farfield/sampler/grid_sampler.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <limits>
#include <vector>

#include "catch.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

std::vector<Rgba8> sampled(GridSampler sampler, const SampleGrid& grid, const Triangles& triangles) {
    std::vector<Rgba8> out(grid.size(), Rgba8{9, 9, 9, 9});
    sampler.sample(
        grid,
        [&](auto&& sink) {
            for (const Triangle& t : triangles) t.polygons(sink);
        },
        std::span<Rgba8>(out));
    return out;
}

struct Answer {
    Rgba8 color{0, 0, 0, 0};
    bool clear = true;  ///< not within a hair of an edge, a face of the box or another triangle
};

/// What is seen of a slice [from, to] of the box, in double.
Answer looked_up(const SampleGrid& grid, const Triangles& triangles, unsigned side, double low, double high, double pu,
                 double pv) {
    const int a = int(side / 2), u = (a + 1) % 3, v = (a + 2) % 3;
    const double square_u = double(grid.box.size()[u]) / grid.n, square_v = double(grid.box.size()[v]) / grid.n;
    Answer answer;
    double best = 1e30;
    for (const Triangle& t : triangles) {
        glm::dvec2 p[3];
        for (int c = 0; c < 3; ++c)
            p[c] = {(double(t.vertices[std::size_t(c)][u]) - pu) / square_u,
                    (double(t.vertices[std::size_t(c)][v]) - pv) / square_v};
        const auto cross = [](glm::dvec2 x, glm::dvec2 y) { return x.x * y.y - x.y * y.x; };
        const double area = cross(p[1] - p[0], p[2] - p[0]);
        double inside = 1e30, near = 1e30;
        double depth = 0;
        for (int c = 0; c < 3; ++c) {
            const glm::dvec2 from = p[c], to = p[(c + 1) % 3];
            const double e = cross(to - from, -from) * (area > 0 ? 1 : -1);
            inside = std::min(inside, e);
            const double length = glm::length(to - from);
            const double along =
                length > 0 ? std::clamp(glm::dot(-from, to - from) / (length * length), 0.0, 1.0) : 0.0;
            near = std::min(near, glm::length(from + (to - from) * along));
            depth += (area != 0 ? cross(p[(c + 1) % 3], p[(c + 2) % 3]) / area : 1.0 / 3) *
                     double(t.vertices[std::size_t(c)][a]);
        }
        if (near < 0.01) answer.clear = false;
        if (near < 0.01 || inside <= 0 || area == 0) continue;
        // Corners are snapped to 1/256 of a square, which moves a steep triangle's depth by its slope.
        const glm::dvec3 n =
            glm::abs(glm::cross(glm::dvec3(t.vertices[1] - t.vertices[0]), glm::dvec3(t.vertices[2] - t.vertices[0])));
        const double hair = 1e-4 * double(grid.box.largest_side()) + (n[u] * square_u + n[v] * square_v) / n[a] / 200;
        if (std::abs(depth - low) < hair || std::abs(depth - high) < hair) answer.clear = false;
        if (depth < low || depth > high) continue;
        const double key = side & 1 ? -depth : depth;
        if (std::abs(key - best) < hair) answer.clear = false;
        if (key < best) {
            best = key;
            answer.color = t.rgba;
        }
    }
    return answer;
}

}  // namespace

TEST_CASE("each sample is what a ray along the axis meets first", "[geometry]") {
    Random random(9);
    for (const unsigned slabs : {1u, 4u}) {
        for (int round = 0; round < 12; ++round) {
            Triangles triangles = random_triangles(60, 10 + std::uint64_t(round), round % 3 == 0 ? 3.0f : 0.4f);
            const glm::vec3 low = random.in_cube(0.5f);
            const SampleGrid grid{
                {low, low + glm::vec3(0.9f, round % 2 ? 0.9f : 0.5f, 0.7f)}, 4u + unsigned(round), slabs};
            const auto out = sampled({}, grid, triangles);
            int wrong = 0, unclear = 0;
            for (unsigned side = 0; side < 6; ++side) {
                const int a = int(side / 2), u = (a + 1) % 3, v = (a + 2) % 3;
                for (unsigned slab = 0; slab < slabs; ++slab) {
                    const double thick = double(grid.box.size()[a]) / slabs, from = double(low[a]) + slab * thick;
                    for (unsigned sv = 0; sv < grid.n; ++sv) {
                        for (unsigned su = 0; su < grid.n; ++su) {
                            const Answer answer =
                                looked_up(grid, triangles, side, from, from + thick,
                                          double(low[u]) + (su + 0.5) * double(grid.box.size()[u]) / grid.n,
                                          double(low[v]) + (sv + 0.5) * double(grid.box.size()[v]) / grid.n);
                            unclear += !answer.clear;
                            wrong += answer.clear && out[grid.index(side, slab, sv, su)] != answer.color;
                        }
                    }
                }
            }
            INFO("round " << round << ", " << slabs << " slabs, " << unclear << " unclear");
            CHECK(wrong == 0);
            CHECK(std::size_t(unclear) < grid.size() / 4);
        }
    }
}

TEST_CASE("triangles that share edges cover each sample of a side once", "[geometry]") {
    Random random(11);
    Triangles mesh = sheet({-3, -2.5f, 0.1f}, {6, 0, 0.3f}, {0.2f, 5, -0.2f}, 7, 6, {255, 255, 255, 255});
    const SampleGrid grid{{{-1, -1, -1}, {1, 1, 1}}, 32, 1};
    std::vector<int> times(grid.size() / 6);
    for (const Triangle& t : mesh) {
        const auto out = sampled({}, grid, {t});
        for (std::size_t i = 0; i < times.size(); ++i) times[i] += out[grid.index(4, 0, 0, 0) + i].a == 255;
    }
    CHECK(std::count(times.begin(), times.end(), 1) == 32 * 32);
}

TEST_CASE("a wall through the box is seen from its two sides alone", "[geometry]") {
    for (int axis = 0; axis < 3; ++axis) {
        for (const float where : {-1.0f, -0.3f, 0.0f, 0.7f, 1.0f}) {
            glm::vec3 corner(-2), u(0), v(0);
            corner[axis] = where;
            u[(axis + 1) % 3] = 4;
            v[(axis + 2) % 3] = 4;
            const SampleGrid grid{{{-1, -1, -1}, {1, 1, 1}}, 4, 1};
            const auto out = sampled({}, grid, sheet(corner, u, v, 1, 1, {10, 20, 30, 255}));
            for (unsigned side = 0; side < 6; ++side) {
                for (std::size_t i = 0; i < 16; ++i) {
                    const Rgba8 c = out[grid.index(side, 0, 0, 0) + i];
                    CHECK(c == (int(side / 2) == axis ? Rgba8{10, 20, 30, 255} : Rgba8{0, 0, 0, 0}));
                }
            }
        }
    }
}

TEST_CASE("what a box without extent along an axis holds is in its first slab", "[geometry]") {
    for (const float thickness : {0.0f, std::numeric_limits<float>::denorm_min()}) {
        const SampleGrid grid{{{-1, -1, 0}, {1, 1, thickness}}, 4, 4};
        const auto out = sampled({}, grid, sheet({-2, -2, 0}, {4, 0, 0}, {0, 4, 0}, 1, 1, {10, 20, 30, 255}));
        for (const unsigned side : {4u, 5u}) {
            for (unsigned slab = 0; slab < 4; ++slab) {
                const std::uint8_t alpha = slab == 0 ? 255 : 0;
                for (std::size_t i = 0; i < 16; ++i) CHECK(out[grid.index(side, slab, 0, 0) + i].a == alpha);
            }
        }
    }
}

TEST_CASE("parts outside the box are not seen", "[geometry]") {
    const SampleGrid grid{{{-1, -1, -1}, {1, 1, 1}}, 8, 1};
    Triangles outside = sheet({-2, -2, 1.001f}, {4, 0, 0}, {0, 4, 0}, 2, 2, {255, 0, 0, 255});
    append(outside, sheet({1.001f, -2, -2}, {0, 4, 0}, {0, 0, 4}, 2, 2, {255, 0, 0, 255}));
    const auto out = sampled({}, grid, outside);
    CHECK(std::all_of(out.begin(), out.end(), [](Rgba8 c) { return c == Rgba8{0, 0, 0, 0}; }));
}

TEST_CASE("a sampler's light falls on the side that is seen", "[geometry]") {
    const DirectionalLight light{{0, 0, 1}, 0.25f, 0.5f};
    const SampleGrid grid{{{-1, -1, -1}, {1, 1, 1}}, 2, 1};
    const Triangles wall = sheet({-2, -2, 0}, {4, 0, 0}, {0, 4, 0}, 1, 1, {200, 100, 40, 255});
    Triangles turned = wall;
    for (Triangle& t : turned) std::swap(t.vertices[1], t.vertices[2]);
    for (const Triangles& triangles : {wall, turned}) {
        const auto out = sampled(GridSampler(light), grid, triangles);
        CHECK(out[grid.index(5, 0, 0, 0)] == Rgba8{150, 75, 30, 255});
        CHECK(out[grid.index(4, 0, 0, 0)] == Rgba8{50, 25, 10, 255});
    }
}

TEST_CASE("translucent colors come premultiplied, and what is fully transparent hides nothing", "[geometry]") {
    const SampleGrid grid{{{-1, -1, -1}, {1, 1, 1}}, 2, 1};
    Triangles walls = sheet({-2, -2, 0.5f}, {4, 0, 0}, {0, 4, 0}, 1, 1, {200, 100, 40, 0});
    append(walls, sheet({-2, -2, 0}, {4, 0, 0}, {0, 4, 0}, 1, 1, {200, 100, 40, 128}));
    const auto out = sampled({}, grid, walls);
    CHECK(out[grid.index(5, 0, 0, 0)] == Rgba8{100, 50, 20, 128});
}

TEST_CASE("large and far triangles do not overflow", "[geometry]") {
    const SampleGrid grid{{{-1, -1, -1}, {1, 1, 1}}, 16, 2};
    for (const float far : {1e2f, 1e4f, 1e8f, 1e15f}) {
        const Triangles wall{{{{{-far, -far, 0.25f}, {far, -far, 0.25f}, {0, far, 0.25f}}}, {1, 2, 3, 255}}};
        const auto out = sampled({}, grid, wall);
        INFO("to " << far);
        for (std::size_t i = 0; i < 256; ++i) {
            CHECK(out[grid.index(5, 1, 0, 0) + i] == Rgba8{1, 2, 3, 255});
            CHECK(out[grid.index(5, 0, 0, 0) + i].a == 0);
        }
    }
}

TEST_CASE("colors between corners are interpolated", "[geometry]") {
    const SampleGrid grid{{{0, 0, 0}, {1, 1, 1}}, 16, 1};
    const std::array<glm::vec3, 4> corners{glm::vec3(0, 0, 0.5f), {1, 0, 0.5f}, {1, 1, 0.5f}, {0, 1, 0.5f}};
    const std::array<Rgba8, 4> colors{Rgba8{0, 0, 0, 255}, {240, 0, 0, 255}, {240, 240, 0, 255}, {0, 240, 0, 255}};
    std::vector<Rgba8> out(grid.size());
    GridSampler().sample(
        grid,
        [&](auto&& sink) {
            sink(Polygon{corners, colors});
        },
        std::span<Rgba8>(out));
    for (unsigned v = 0; v < 16; ++v) {
        for (unsigned u = 0; u < 16; ++u) {
            const Rgba8 c = out[grid.index(5, 0, v, u)];
            CHECK(std::abs(c.r - 240 * (u + 0.5) / 16) <= 1.5);
            CHECK(std::abs(c.g - 240 * (v + 0.5) / 16) <= 1.5);
        }
    }
}
