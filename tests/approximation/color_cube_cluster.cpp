#include "farfield/approximation/color_cube_cluster.hpp"

#include <cmath>
#include <numeric>
#include <vector>

#include "catch.hpp"
#include "farfield/sampler/grid_sampler.hpp"
#include "support/pictures.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

Cell cube_cell(float looseness = 1) {
    Cell c;
    c.half = glm::vec3(1);
    c.bounds_half = glm::vec3(looseness);
    return c;
}
template <unsigned K>
struct Made {
    typename ColorCubeCluster<K>::stand_in_data data;
    std::vector<typename ColorCubeCluster<K>::pool_element> pool;

    Made(const ColorCubeCluster<K>& a, const Cell& cell, const Triangles& triangles) {
        GridSampler sampler;
        const auto draft = a.sample(
            cell,
            [&](auto&& sink) {
                for (const Triangle& t : triangles) t.polygons(sink);
            },
            sampler);
        pool.resize(3);  // others' come before
        data = a.finish(cell, draft, pool);
    }
};

struct Sink {
    float splat_limit_px = 0;
    std::vector<Face>* faces;
    std::vector<Splat>* splats;
    void operator()(const Face& f) const { faces->push_back(f); }
    void operator()(const Splat& s) const { splats->push_back(s); }
};

}  // namespace

TEST_CASE("a wall makes one layer of faces, where it is", "[approximation]") {
    for (const float looseness : {1.0f, 2.0f}) {
        const Cell cell = cube_cell(looseness);
        const unsigned across = looseness == 1 ? 4 : 8;
        const ColorCubeCluster<4> a;
        const Made<4> made(a, cell, sheet({-3, -3, 0.6f}, {6, 0, 0}, {0, 6, 0}, 2, 2, {255, 102, 51, 255}));
        CHECK(made.data.first == 3);
        const std::array<std::uint16_t, 6> expected{
            0, 0, 0, 0, std::uint16_t(across * across), std::uint16_t(across * across)};
        CHECK(made.data.count == expected);
        CHECK(made.pool.size() == 3 + 2 * across * across);
        std::vector<Face> faces;
        std::vector<Splat> splats;
        const LocalView view(looking({0, 0, 30}, {0, 0, 0}), {}, 5);
        a.draw_stand_in(made.data, made.pool, cell, view, Sink{0, &faces, &splats});
        REQUIRE(faces.size() == across * across);
        double area = 0;
        for (const Face& f : faces) {
            CHECK(f.side == 5);
            CHECK(f.rgba == Rgba8{255, 102, 51, 255});
            // The wall's own slab, half a unit thick.
            CHECK(f.lower.z == Approx(1.0f));
            area += double(f.upper.x - f.lower.x) * double(f.upper.y - f.lower.y);
        }
        CHECK(area == Approx(4.0 * looseness * looseness));
        faces.clear();
        a.draw_stand_in(made.data, made.pool, cell, LocalView(looking({0, 0, -30}, {0, 0, 0}), {}, 5),
                        Sink{0, &faces, &splats});
        REQUIRE(faces.size() == across * across);
        CHECK(faces[0].side == 4);
        CHECK(faces[0].lower.z == Approx(0.5f));
    }
}

TEST_CASE("faces covered no more than the threshold are left out", "[approximation]") {
    Triangles dot = sheet({-0.95f, -0.95f, 0}, {0.24f, 0, 0}, {0, 0.24f, 0}, 1, 1, {255, 255, 255, 255});
    // One of 4 x 4 samples of one small cube.
    const ColorCubeCluster<2> keeps{.samples = 4, .coverage_threshold = 1.0f / 64},
        drops{.samples = 4, .coverage_threshold = 1.0f / 16};
    CHECK(Made<2>(keeps, cube_cell(), dot).data.count[5] == 1);
    CHECK(Made<2>(drops, cube_cell(), dot).data.count[5] == 0);
}

TEST_CASE("the work is that of half the faces, the error that of one small cube", "[approximation]") {
    const ColorCubeCluster<4> a;
    const Made<4> made(a, cube_cell(), sheet({-3, -3, 0.6f}, {6, 0, 0}, {0, 6, 0}, 2, 2, {255, 102, 51, 255}));
    CHECK(a.work(made.data).splats == 16);
    CHECK(a.expected_work().splats == 16);
    const LocalView view(looking({0, 0, 11}, {0, 0, 0}, 200), {}, 5);
    CHECK(a.error_px(made.data, cube_cell(), view) == Approx(0.5 * double(view.focal_px) / 10));
}

TEST_CASE("faces of a cluster are never seen from behind", "[approximation]") {
    Random random(30);
    const ColorCubeCluster<4> a;
    const Cell cell = cube_cell(2);
    const Made<4> made(a, cell, random_triangles(300, 31, 0.4f));
    for (int i = 0; i < 300; ++i) {
        const glm::vec3 eye = random.in_cube(4);
        const LocalView view(i % 3 ? looking(eye, random.in_cube(1)) : looking_orthographic(eye, random.in_cube(1)), {},
                             5);
        std::vector<Face> faces;
        std::vector<Splat> splats;
        a.draw_stand_in(made.data, made.pool, cell, view, Sink{i % 2 ? 0.0f : 1e9f, &faces, &splats});
        for (const Face& f : faces) {
            const int axis = f.side / 2;
            const float towards = view.towards_viewer(f.lower)[axis];
            CHECK(f.lower[axis] == f.upper[axis]);
            CHECK((f.side & 1 ? towards > 0 : towards < 0));
        }
        for (const Splat& s : splats) CHECK((s.size.x > 0 && s.size.y > 0 && s.opacity > 0 && s.opacity <= 1));
    }
}

TEST_CASE("a cluster of one is a color cube", "[approximation]") {
    const ColorCubeCluster<1> a{.samples = 4};
    const Made<1> made(a, cube_cell(), sheet({-1, -1, 0}, {1, 0, 0}, {0, 2, 0}, 2, 2, {200, 100, 0, 255}));
    CHECK(made.data.count[4] == 1);
    CHECK(made.data.count[5] == 1);
    CHECK(std::abs(made.pool.back().a - 128) <= 1);
    CHECK(std::abs(made.pool.back().r - 100) <= 1);
}

TEST_CASE("the largest cluster fits its place numbers", "[approximation]") {
    const ColorCubeCluster<16> a;
    const Cell cell = cube_cell(2);
    const Made<16> made(a, cell, moved(sphere({0, 0, 0}, 1.9f, 40, {255, 255, 255, 255}), 1));
    std::size_t faces = 0;
    a.polygons(made.data, made.pool, cell, [&](const Polygon& p) {
        ++faces;
        for (const glm::vec3& v : p.vertices)
            CHECK((std::abs(v.x) <= 2.00001f && std::abs(v.y) <= 2.00001f && std::abs(v.z) <= 2.00001f));
    });
    CHECK(faces == std::size_t(std::accumulate(made.data.count.begin(), made.data.count.end(), 0)));
    CHECK(faces > 1000);
}
