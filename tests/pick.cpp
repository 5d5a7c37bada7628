#include "farfield/pick.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/area_splat.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/approximation/sample_set.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/paging/open_pages.hpp"
#include "farfield/paging/write_pages.hpp"
#include "farfield/partition/gap_bsp.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/partition/polygon_bsp.hpp"
#include "farfield/primitive/instance.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "paging/faulty_source.hpp"
#include "support/random.hpp"
#include "support/scenes.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

struct Truth {
    double distance = std::numeric_limits<double>::infinity();
    std::uint32_t index = 0;
    double margin = std::numeric_limits<double>::infinity();  ///< to what comes next
};

/// Möller and Trumbore, on all triangles: another formula than the library's.
Truth truth_of(const Triangles& triangles, const Ray& ray) {
    Truth truth;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        const auto& v = triangles[i].vertices;
        const glm::dvec3 a(v[0]), e(glm::dvec3(v[1]) - a), f(glm::dvec3(v[2]) - a), p = glm::cross(ray.direction, f);
        const double det = glm::dot(e, p);
        if (det == 0) continue;
        const glm::dvec3 s = ray.origin - a, q = glm::cross(s, e);
        const double u = glm::dot(s, p) / det, w = glm::dot(ray.direction, q) / det, t = glm::dot(f, q) / det;
        if (u < 0 || w < 0 || u + w > 1 || t < ray.nearest || t > ray.farthest) continue;
        if (t < truth.distance) {
            truth = {t, std::uint32_t(i), truth.distance - t};
        } else {
            truth.margin = std::min(truth.margin, t - truth.distance);
        }
    }
    return truth;
}

Ray random_ray(Random& random) {
    // Lengths of directions differ, and some rays run along an axis or begin inside.
    const glm::dvec3 origin(random.in_cube(3));
    glm::dvec3 direction = glm::dvec3(random.in_cube(1)) - origin;
    if (random.below(8) == 0) direction = {0, 0, direction.z};
    return {origin, direction * double(random.between(0.1f, 10))};
}

/// In double precision.
struct Placed {
    glm::dvec3 corner;
    BoxD bounds() const { return {corner, corner + glm::dvec3(1, 1, 0)}; }
    void polygons(auto&& sink) const {
        const glm::dvec3 v[] = {corner, corner + glm::dvec3(1, 0, 0), corner + glm::dvec3(1, 1, 0),
                                corner + glm::dvec3(0, 1, 0)};
        const Rgba8 color{255, 255, 255, 255};
        sink(PolygonD{v, {&color, 1}});
    }
};

template <class Partition, class A>
using Built = SpatialHierarchy<Partition, A, TriangleCount>;

}  // namespace

TEMPLATE_TEST_CASE("picked is what a loop over all triangles finds", "", (Built<Octree, Exact>),
                   (Built<SharedOctree, Exact>), (Built<PolygonBsp, Exact>), (Built<GapBsp, OpacityTensor>),
                   (Built<Octree, SampleSet<AreaSplat>>)) {
    const Triangles triangles = mixed_triangles(2000, 5);
    const auto hierarchy = build<TestType>(triangles);
    Random random(11);
    int hits = 0;
    for (int i = 0; i < 2000; ++i) {
        const Ray ray = random_ray(random);
        const Truth truth = truth_of(triangles, ray);
        const auto picked = pick(hierarchy, triangles, ray);
        INFO("ray " << i);
        REQUIRE(picked.has_value() == std::isfinite(truth.distance));
        if (!picked) continue;
        ++hits;
        CHECK(picked->distance == Approx(truth.distance).epsilon(1e-9));
        REQUIRE(picked->path.size() == 1);
        const bool is_twin = triangles[picked->path[0]].vertices == triangles[truth.index].vertices;
        if (truth.margin > 1e-9 * truth.distance || is_twin) CHECK((is_twin || picked->path[0] == truth.index));
        // Of duplicates the first.
        if (is_twin) CHECK(picked->path[0] == truth.index);
        CHECK(picked->node < hierarchy.nodes().size());
    }
    CHECK(hits > 500);
}

TEST_CASE("what lies under a pixel is what is drawn there") {
    Triangles triangles = random_triangles(4000, 3, 0.2f);
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        triangles[i].rgba = {std::uint8_t(i), std::uint8_t(i >> 8), 77, 255};
    }
    using Hierarchy = Built<Octree, Exact>;
    const auto hierarchy = build<Hierarchy>(triangles);
    ZBufferRenderer renderer;
    auto viewer = make_viewer(hierarchy, triangles, renderer);
    View stretched = looking({1.5, 1, 2}, {0, 0, 0}, 96);
    stretched.camera.half_width = 0.9f;
    stretched.camera.off_center = {0.25, -0.5};
    View mirrored = looking({1.5, 1, 2}, {0, 0, 0}, 96);
    mirrored.camera.right = -mirrored.camera.right;
    const View views[] = {looking({1.5, 1, 2}, {0, 0, 0}, 96),
                          looking_orthographic({-2, 1, 1}, {0, 0, 0}, 2, 96),
                          looking({1.5, 1, 2}, {0, 0, 0}, 96).tile(20, 30, 40, 50),
                          stretched,
                          mirrored,
                          looking({0.1, 0, 0.2}, {1, 0, 0}, 96)};
    for (const View& view : views) {
        INFO("view " << &view - views);
        viewer.frame(view);
        int different = 0, drawn = 0;
        for (int y = 0; y < view.height; ++y) {
            for (int x = 0; x < view.width; ++x) {
                const Rgba8 seen = renderer.image().at(x, y);
                const auto picked = pick(hierarchy, triangles, view, glm::dvec2(x, y) + 0.5);
                drawn += seen.a != 0;
                different += picked ? seen != triangles[picked->path[0]].rgba : seen.a != 0;
            }
        }
        CHECK(drawn > 1000);
        // The renderer snaps corners to parts of a pixel, so that borders may lie beside where they are.
        CHECK(different <= drawn / 50);
    }
}

TEST_CASE("instances are entered, to any depth, and paths name them") {
    const Triangles triangles = random_triangles(300, 9, 0.3f);
    using Inner = Built<Octree, OpacityTensor>;
    using Tree = Instance<Inner, Triangle>;
    using Middle = Built<Octree, OpacityTensor>;
    using Grove = Instance<Middle, Tree>;
    const auto inner = build<Inner>(triangles);
    Random random(2);
    const auto place = [&](float scale, float reach) {
        const glm::vec3 axis = random.direction(),
                        aside = glm::normalize(glm::cross(axis, glm::vec3(axis.z, axis.x, -axis.y)));
        return Similarity(glm::mat3(axis, aside, glm::cross(axis, aside)), scale, glm::dvec3(random.in_cube(reach)));
    };
    std::vector<Tree> trees;
    for (int i = 0; i < 20; ++i) trees.push_back({&inner, triangles, place(random.between(0.2f, 2), 4)});
    const auto middle = build<Middle>(trees);
    std::vector<Grove> groves;
    for (int i = 0; i < 5; ++i) groves.push_back({&middle, trees, place(3, 30)});
    const auto outer = build<Built<Octree, Exact>>(groves);

    int hits = 0, wrong = 0;
    for (int i = 0; i < 300; ++i) {
        const glm::dvec3 origin(random.in_cube(60));
        const Ray ray{origin, glm::dvec3(random.in_cube(20)) - origin};
        const detail::RayMeeter meeter(ray);
        double nearest = std::numeric_limits<double>::infinity();
        std::vector<std::uint32_t> path;
        for (std::uint32_t g = 0; g < groves.size(); ++g) {
            for (std::uint32_t t = 0; t < trees.size(); ++t) {
                for (std::uint32_t k = 0; k < triangles.size(); ++k) {
                    const auto at = [&](int corner) {
                        return groves[g].to_world.apply(
                            trees[t].to_world.apply(glm::dvec3(triangles[k].vertices[std::size_t(corner)])));
                    };
                    const double d = meeter.distance_to(at(0), at(1), at(2));
                    if (d < nearest) {
                        nearest = d;
                        path = {g, t, k};
                    }
                }
            }
        }
        const auto picked = pick(outer, groves, ray);
        REQUIRE(picked.has_value() == !path.empty());
        if (!picked) continue;
        ++hits;
        wrong += picked->path != path;
        CHECK(picked->distance == Approx(nearest).epsilon(1e-6));
    }
    CHECK(hits > 50);
    CHECK(wrong == 0);
}

TEST_CASE("a scene far from the origin is picked as exactly as one at it") {
    const glm::dvec3 far_off(6378137, -4e6, 1e5);
    std::vector<Placed> tiles;
    for (int y = 0; y < 20; ++y) {
        for (int x = 0; x < 20; ++x) tiles.push_back({far_off + glm::dvec3(x, y, 0)});
    }
    const auto hierarchy = build<Built<Octree, Exact>>(tiles);
    int wrong = 0;
    for (std::uint32_t i = 0; i < 400; ++i) {
        const glm::dvec3 target = tiles[i].corner + glm::dvec3(0.25, 0.5, 0);
        const auto picked = pick(hierarchy, tiles, Ray{target + glm::dvec3(3, -2, 9), {-3, 2, -9}});
        wrong += !picked || picked->path[0] != i || std::abs(picked->distance - 1) > 1e-7;
    }
    CHECK(wrong == 0);
}

TEST_CASE("rays pass through no edge that triangles share") {
    const Triangles wall = sheet({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 16, 16, {255, 255, 255, 255});
    const auto hierarchy = build<Built<Octree, Exact>>(wall);
    int missed = 0;
    for (int y = 1; y < 64; ++y) {
        for (int x = 1; x < 64; ++x) {
            const glm::dvec3 target(x / 32.0 - 1, y / 32.0 - 1, 0), eye(0.3, 0.2, 3);
            missed += !pick(hierarchy, wall, Ray{eye, target - eye});
        }
    }
    CHECK(missed == 0);
}

TEST_CASE("what is refused is passed through") {
    const Triangles sheets = [] {
        Triangles all;
        for (int i = 0; i < 5; ++i) {
            append(all, sheet({-1, -1, -float(i)}, {2, 0, 0}, {0, 2, 0}, 1, 1, {std::uint8_t(i), 0, 0, 255}));
        }
        return all;
    }();
    const auto hierarchy = build<Built<Octree, Exact>>(sheets);
    const Ray ray{{0.5, 0.25, 2}, {0, 0, -1}};
    const auto third =
        pick(hierarchy, sheets, ray, [](const Triangle& t, const PickedPrimitive&) { return t.rgba.r >= 2; });
    REQUIRE(third);
    CHECK(third->distance == 4);
    Ray limited = ray;
    limited.nearest = 2.5;
    CHECK(pick(hierarchy, sheets, limited)->distance == 3);
    limited.farthest = 2.75;
    CHECK(!pick(hierarchy, sheets, limited));
    limited = {{0.5, 0.25, -9}, {0, 0, -2}, -std::numeric_limits<double>::infinity()};
    CHECK(pick(hierarchy, sheets, limited)->distance == -4.5);  // the nearest end of the ray is behind its origin
}

TEST_CASE("there is nothing in nothing, and bad rays are refused") {
    using Hierarchy = Built<Octree, Exact>;
    const Triangles none;
    CHECK(!pick(Hierarchy(), none, Ray{}));
    const Triangles specks{{{glm::vec3(1), glm::vec3(1), glm::vec3(1)}, {}},
                           {{glm::vec3(0), glm::vec3(1), glm::vec3(2)}, {}}};
    CHECK(!pick(build<Hierarchy>(specks), specks, Ray{{1, 1, 3}, {0, 0, -1}}));
    const std::string refused = "farfield::pick: a ray needs an origin and a direction that are finite";
    const double nan = std::numeric_limits<double>::quiet_NaN();
    CHECK_THROWS_WITH(pick(Hierarchy(), none, Ray{{0, 0, 0}, {0, 0, 0}}), refused);
    CHECK_THROWS_WITH(pick(Hierarchy(), none, Ray{{0, nan, 0}, {0, 0, 1}}), refused);
    CHECK_THROWS_WITH(pick(Hierarchy(), none, Ray{{0, 0, 0}, {0, 0, 1}, nan}), refused);
    CHECK_THROWS_AS(pick(Hierarchy(), specks, Ray{}), std::invalid_argument);
}

TEST_CASE("What is picked in pages is what is picked in memory") {
    using H = SpatialHierarchy<Octree, OpacityTensor, TriangleCount>;
    const Triangles scene = random_triangles(20000, 3);
    const H h = build<H>(scene);
    const std::vector<std::byte> bytes = paged<H, Triangle>(h, scene, {.page_bytes = 4096});
    const auto source = std::make_shared<MemorySource>(bytes);
    // Room for a part of the pages: those along a ray fit.
    auto pages = open_pages_of<H, Triangle>(source, "memory", {.most_bytes = 2'000'000, .loads_in_background = false});
    Random random(9);
    int hits = 0;
    for (int i = 0; i < 300; ++i) {
        const glm::dvec3 from = glm::dvec3(random.direction()) * 3.0, to(random.in_cube(1));
        const Ray ray{from, to - from};
        const auto expected = pick(h, scene, ray);
        const auto picked = pick(pages, ray);
        REQUIRE(picked.has_value() == expected.has_value());
        if (!expected) continue;
        ++hits;
        CHECK(picked->distance == expected->distance);
        CHECK(picked->primitive.vertices == scene[expected->path[0]].vertices);
    }
    CHECK(hits > 100);
    CHECK_FALSE(pages.waits_for_pages());
}
