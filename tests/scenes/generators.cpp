#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <stdexcept>

#include "catch.hpp"
#include "scenes/catalog.hpp"
#include "scenes/generate/forest.hpp"
#include "scenes/generate/island.hpp"
#include "scenes/generate/molecule.hpp"
#include "scenes/generate/sphere.hpp"
#include "scenes/generate/tree.hpp"

using namespace farfield;
using namespace farfield::scenes;

namespace {

bool same_bytes(const Scene& a, const Scene& b) {
    if (a.groups.size() != b.groups.size()) return false;
    for (std::size_t g = 0; g < a.groups.size(); ++g) {
        const auto &s = a.groups[g].triangles, &t = b.groups[g].triangles;
        if (s.size() != t.size()) return false;
        if (!s.empty() && std::memcmp(s.data(), t.data(), s.size() * sizeof s[0]) != 0) return false;
        const auto &p = a.groups[g].placements, &q = b.groups[g].placements;
        if (p.size() != q.size()) return false;
        for (std::size_t i = 0; i < p.size(); ++i) {
            if (p[i].group != q[i].group || p[i].to_parent != q[i].to_parent) return false;
        }
    }
    return true;
}

bool all_finite(const std::vector<VertexColoredTriangle>& triangles) {
    return std::all_of(triangles.begin(), triangles.end(), [](const VertexColoredTriangle& t) {
        return t.bounds().is_finite() && t.rgba[0].a == 255 && t.rgba[1].a == 255 && t.rgba[2].a == 255;
    });
}

/// By looking at every triangle: the highest point above (x, z).
float height_above(const std::vector<VertexColoredTriangle>& ground, float x, float z) {
    float highest = -1e30f;
    for (const VertexColoredTriangle& t : ground) {
        const glm::vec3 &a = t.vertices[0], &b = t.vertices[1], &c = t.vertices[2];
        const float area = (b.x - a.x) * (c.z - a.z) - (c.x - a.x) * (b.z - a.z);
        const float v = ((x - a.x) * (c.z - a.z) - (c.x - a.x) * (z - a.z)) / area;
        const float w = ((b.x - a.x) * (z - a.z) - (x - a.x) * (b.z - a.z)) / area;
        if (v >= -1e-4f && w >= -1e-4f && v + w <= 1.0001f) {
            highest = std::max(highest, a.y + v * (b.y - a.y) + w * (c.y - a.y));
        }
    }
    return highest;
}

}  // namespace

TEST_CASE("a tree has the triangles asked for and stands on the ground", "[scenes]") {
    for (const std::uint64_t seed : {1u, 2u, 3u, 99u}) {
        for (const std::uint32_t triangles : {2'000u, 7'519u, 7'520u, 52'470u, 60'001u}) {
            TreeOptions options;
            options.seed = seed;
            options.triangles = triangles;
            const Scene scene = tree(options);
            INFO("seed " << seed << ", " << triangles << " triangles");
            CHECK(triangle_count(scene) == triangles);
            CHECK(all_finite(scene.groups[0].triangles));
            const Box box = bounds(scene);
            CHECK(std::abs(box.lower.y) < 1e-3f);
            CHECK(box.upper.y > 8.5f);
            CHECK(box.upper.y < 12.0f);
            CHECK(std::max({box.upper.x, -box.lower.x, box.upper.z, -box.lower.z}) < 6.0f);
        }
    }
    CHECK(triangle_count(tree()) == 52'470);
}

TEST_CASE("a tree is brown below and mostly green above", "[scenes]") {
    std::size_t green = 0, others = 0;
    const Scene scene = tree();
    for (const VertexColoredTriangle& t : scene.groups[0].triangles) {
        const bool is_green = t.rgba[0].g > t.rgba[0].r;
        if (t.bounds().upper.y < 0.15f * 10.0f) CHECK_FALSE(is_green);
        ++(is_green ? green : others);
    }
    CHECK(green > 20'000);
    CHECK(others > 5'000);
}

TEST_CASE("a tree of impossible options is refused", "[scenes]") {
    TreeOptions options;
    options.triangles = 1'999;
    CHECK_THROWS_AS(tree(options), std::invalid_argument);
    options = {};
    options.height_m = 0.0f;
    CHECK_THROWS_AS(tree(options), std::invalid_argument);
    options.height_m = std::nanf("");
    CHECK_THROWS_AS(tree(options), std::invalid_argument);
}

TEST_CASE("the same seed gives the same bytes, another seed others", "[scenes]") {
    CHECK(same_bytes(tree(5), tree(5)));
    CHECK_FALSE(same_bytes(tree(5), tree(6)));
    CHECK(same_bytes(island(60), island(60)));
    CHECK(same_bytes(forest(3), forest(3)));
    IslandOptions other;
    other.trees = 60;
    other.seed = 2;
    CHECK_FALSE(same_bytes(island(60), island(other)));
}

TEST_CASE("spheres are closed and seen from outside", "[scenes]") {
    CHECK(latitude_longitude_sphere(20, 21).size() == molecule_triangles_per_atom);
    for (const UnitSphere& sphere : {latitude_longitude_sphere(20, 21), latitude_longitude_sphere(3, 2), icosphere(0),
                                     icosphere(1), icosphere(2)}) {
        // The volume by the divergence theorem is right only if every triangle is turned outwards.
        double volume = 0.0;
        for (const auto& [a, b, c] : sphere) {
            CHECK(glm::dot(glm::cross(b - a, c - a), a + b + c) > 0.0f);
            volume += static_cast<double>(glm::dot(a, glm::cross(b, c))) / 6.0;
        }
        CHECK(volume > 0.2);
        CHECK(volume < 4.18880);
        if (sphere.size() == molecule_triangles_per_atom) CHECK(volume > 4.08);
        // Every directed edge has its opposite, bit for bit.
        using Edge = std::array<float, 6>;
        std::vector<Edge> edges, opposite;
        for (const auto& corners : sphere) {
            for (std::size_t i = 0; i < 3; ++i) {
                const glm::vec3 p = corners[i], q = corners[(i + 1) % 3];
                edges.push_back({p.x, p.y, p.z, q.x, q.y, q.z});
                opposite.push_back({q.x, q.y, q.z, p.x, p.y, p.z});
            }
        }
        std::sort(edges.begin(), edges.end());
        std::sort(opposite.begin(), opposite.end());
        CHECK(edges == opposite);
    }
}

TEST_CASE("the molecule has 6,534 overlapping spheres of 800 triangles", "[scenes]") {
    const Scene scene = molecule();
    const auto& triangles = scene.groups[0].triangles;
    REQUIRE(triangle_count(scene) == 5'227'200);
    std::vector<glm::vec3> centers;
    bool outwards = true, flat = true;
    for (std::size_t first = 0; first < triangles.size(); first += molecule_triangles_per_atom) {
        Box box = Box::empty();
        for (std::size_t t = first; t < first + molecule_triangles_per_atom; ++t) box.add(triangles[t].bounds());
        centers.push_back(box.center());
        for (std::size_t t = first; t < first + molecule_triangles_per_atom; ++t) {
            const auto& v = triangles[t].vertices;
            outwards &= glm::dot(glm::cross(v[1] - v[0], v[2] - v[0]), v[0] - box.center()) > 0.0f;
            flat &= triangles[t].rgba[0] == triangles[t].rgba[1] && triangles[t].rgba[1] == triangles[t].rgba[2];
        }
        const float diameter = box.size().y;
        CHECK(diameter > 2.0f * 1.5f);
        CHECK(diameter < 2.0f * 1.85f);
    }
    CHECK(outwards);
    CHECK(flat);
    REQUIRE(centers.size() == molecule_atoms);
    // Brute force over all pairs: none too near, and all have a neighbor that they touch.
    std::size_t too_near = 0, lonely = 0;
    for (std::size_t i = 0; i < centers.size(); ++i) {
        float nearest = 1e30f;
        for (std::size_t k = 0; k < centers.size(); ++k) {
            if (k != i) nearest = std::min(nearest, glm::length(centers[i] - centers[k]));
        }
        too_near += nearest < 1.19f;
        lonely += nearest > 3.0f;
    }
    CHECK(too_near == 0);
    CHECK(lonely == 0);
    // Compact: a chain of so many atoms could be a hundred times as long.
    const Box box = bounds(scene);
    CHECK(box.largest_side() < 110.0f);
}

TEST_CASE("every tree of the island stands on its ground, none in the sea", "[scenes]") {
    for (const std::size_t trees : {std::size_t{1}, std::size_t{480}}) {
        const Scene scene = island(trees);
        const Group& root = scene.groups.back();
        CHECK(root.placements.size() == trees);
        CHECK(root.triangles.size() == 33'104);
        for (const Group& group : scene.groups) CHECK(all_finite(group.triangles));
        std::size_t astray = 0;
        for (std::size_t i = 0; i < trees; i += 7) {
            const glm::vec4 foot = root.placements[i].to_parent[3];
            const float ground = height_above(root.triangles, foot.x, foot.z);
            astray += !(foot.y <= ground + 0.01f && foot.y > ground - 0.5f && ground > 1.0f);
        }
        CHECK(astray == 0);
    }
    CHECK(triangle_count(island()) == 3'642'224);
}

TEST_CASE("the ground of the island is seen from above", "[scenes]") {
    const Scene scene = island(1);
    for (const VertexColoredTriangle& t : scene.groups.back().triangles) {
        const auto& v = t.vertices;
        if (!(glm::cross(v[1] - v[0], v[2] - v[0]).y > 0.0f)) {
            FAIL("a triangle of the ground faces down");
        }
    }
}

TEST_CASE("an island has as many trees as asked for, however little room there is", "[scenes]") {
    CHECK(island(2000).groups.back().placements.size() == 2000);
    CHECK(island(0).groups.back().placements.empty());
    const Scene flat = island(3, false);
    CHECK(flat.groups.size() == 1);
    CHECK(triangle_count(flat) == 3 * 7'519 + 33'104);
    IslandOptions options;
    options.tree_kinds = 0;
    CHECK_THROWS_AS(island(options), std::invalid_argument);
}

TEST_CASE("a forest is a grid of turned trees", "[scenes]") {
    ForestOptions options;
    options.tree_kinds = 3;
    options.tree_triangles = 8'000;
    const Scene scene = forest(options);
    CHECK(scene.groups.size() == 4);
    CHECK(triangle_count(scene) == 20 * 8'000 + 40);
    CHECK(std::abs(bounds(scene).lower.y) < 1e-3f);
    CHECK(triangle_count(forest(2)) == 4 * 52'470 + 8);
    CHECK_THROWS_AS(forest(0), std::invalid_argument);
}

TEST_CASE("the walk over the island goes along its edge and then in, among the tops of its trees", "[scenes]") {
    const IslandOptions options{.trees = 60, .tree_triangles = 2'000, .tree_kinds = 1, .ground_cells = 32};
    const Scene scene = island(options);
    double side = 0;  // of the ground; the sea is larger
    for (const VertexColoredTriangle& t : scene.groups.back().triangles) {
        if (t.vertices[0].y > 0) side = std::max(side, 2.0 * double(std::abs(t.vertices[0].x)));
    }
    const auto cameras = walk_over_island(options, 300);
    REQUIRE(cameras.size() == 300);
    std::size_t far_out = 0;
    for (std::size_t i = 0; i < cameras.size(); ++i) {
        const glm::dvec3 eye = cameras[i].eye;
        CHECK(eye.y > 8);
        CHECK(eye.y < 60);
        CHECK(std::abs(cameras[i].forward.y) < 0.1f);
        far_out += std::max(std::abs(eye.x), std::abs(eye.z)) > 0.3 * side;
        if (i == 0) continue;
        CHECK(glm::length(eye - cameras[i - 1].eye) < 0.02 * side);
        CHECK(glm::dot(cameras[i].forward, cameras[i - 1].forward) > 0.99f);
    }
    CHECK(far_out > 100);
    const glm::dvec3 last = cameras.back().eye;
    CHECK(std::max(std::abs(last.x), std::abs(last.z)) < 0.2 * side);
    // More frames divide the same path.
    CHECK(glm::length(walk_over_island(options, 600)[200].eye - cameras[100].eye) < 1e-9);
}

TEST_CASE("the catalog makes what it names", "[scenes]") {
    const std::vector<std::string> known = names();
    CHECK(std::find(known.begin(), known.end(), "tree") != known.end());
    for (const std::string& name : known) {
        if (name == "molecule") continue;  // has a test of its own
        const Scene scene = make(name);
        CHECK(scene.name == name);
        CHECK(triangle_count(scene) > 0);
        CHECK(bounds(scene).is_finite());
    }
    CHECK(triangle_count(make("forest")) == 1'049'440);
    CHECK(triangle_count(make("shade-island")) == 131'072 + 336 + 1'117 * 36'230);
    CHECK(triangle_count(make("forest-instanced")) == 20'988'800);
    try {
        make("treee");
        FAIL("an unknown name was accepted");
    } catch (const std::invalid_argument& error) {
        for (const std::string& name : known) CHECK(std::string(error.what()).find(name) != std::string::npos);
    }
}
