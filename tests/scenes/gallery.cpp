#include "scenes/generate/gallery.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include "catch.hpp"
#include "support/pictures.hpp"

using namespace farfield;
using namespace farfield::scenes;

namespace {

using Triangles = std::vector<Triangle>;

bool same_bytes(const Triangles& a, const Triangles& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0;
}

float reach(const Triangles& triangles) {
    float farthest = 0;
    for (const Triangle& t : triangles) {
        for (const glm::vec3& v : t.vertices) farthest = std::max(farthest, glm::length(v));
    }
    return farthest;
}

double area(const Triangles& triangles) {
    double sum = 0;
    for (const Triangle& t : triangles) sum += double(t.area());
    return sum;
}

float luminance(Rgba8 c) {
    return 0.2126f * float(c.r) + 0.7152f * float(c.g) + 0.0722f * float(c.b);
}

View seen_from(glm::vec3 towards, double distance, int size) {
    return test::looking(glm::dvec3(towards) * distance, {}, size);
}

Image finely(const Triangles& triangles, const View& view) {
    return test::plain_picture<Triangle>(triangles, view, {.samples = 64});
}

/// Every edge lies in two triangles, once in each direction, on the same bits.
bool is_watertight(const Triangles& triangles) {
    using Point = std::array<float, 3>;
    std::map<std::pair<Point, Point>, int> edges;
    for (const Triangle& t : triangles) {
        for (std::size_t k = 0; k < 3; ++k) {
            const glm::vec3 a = t.vertices[k], b = t.vertices[(k + 1) % 3];
            ++edges[{{a.x, a.y, a.z}, {b.x, b.y, b.z}}];
        }
    }
    return std::all_of(edges.begin(), edges.end(), [&](const auto& edge) {
        const auto back = edges.find({edge.first.second, edge.first.first});
        return edge.second == 1 && back != edges.end() && back->second == 1;
    });
}

}  // namespace

TEST_CASE("every scene of the gallery keeps its contract at every severity", "[scenes]") {
    for (const GalleryEntry& entry : gallery()) {
        for (const float severity : {0.0f, 0.3f, 0.5f, 1.0f}) {
            for (const std::uint32_t triangles : {1000u, 5003u, 20'000u}) {
                INFO(entry.name << ", severity " << severity << ", " << triangles << " triangles");
                const GalleryScene scene = make_gallery(entry.name, severity, triangles);
                CHECK(scene.name == entry.name);
                CHECK(scene.triangles.size() <= triangles);
                CHECK(scene.triangles.size() >= triangles / 2);
                CHECK(glm::length(scene.towards_viewer) == Approx(1));
                CHECK(std::all_of(scene.triangles.begin(), scene.triangles.end(), [](const Triangle& t) {
                    return t.bounds().is_finite() && t.rgba.a == 255 && t.area() > 0;
                }));
                Triangles within = scene.triangles;
                if (entry.name == "ground") within.resize(within.size() - 2);
                CHECK(reach(within) < (entry.name == "meadow" ? 2.5f : 1.75f));
                CHECK(reach(within) > 0.75f);
                CHECK(same_bytes(scene.triangles, make_gallery(entry.name, severity, triangles).triangles));
            }
        }
        CHECK_FALSE(same_bytes(make_gallery(entry.name, 0.25f).triangles, make_gallery(entry.name, 0.75f).triangles));
    }
}

TEST_CASE("the gallery refuses what makes no scene, naming it", "[scenes]") {
    const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
    CHECK_THROWS_AS(make_gallery("nothing", 0), std::invalid_argument);
    CHECK_THROWS_AS(make_gallery("wall", -0.1f), std::invalid_argument);
    CHECK_THROWS_AS(make_gallery("wall", 1.1f), std::invalid_argument);
    CHECK_THROWS_AS(make_gallery("wall", nan), std::invalid_argument);
    CHECK_THROWS_AS(make_gallery("wall", 0, 999), std::invalid_argument);
    CHECK_THROWS_AS(slats({.slats = 0}), std::invalid_argument);
    CHECK_THROWS_AS(slats({.angle_degrees = nan}), std::invalid_argument);
    CHECK_THROWS_AS(slats({.breadth = 0}), std::invalid_argument);
    CHECK_THROWS_AS(wall({.normal = glm::vec3(0)}), std::invalid_argument);
    CHECK_THROWS_AS(wall({.normal = glm::vec3(nan)}), std::invalid_argument);
    CHECK_THROWS_AS(bust({.side_quads = 0}), std::invalid_argument);
    CHECK_THROWS_AS(twigs({.thickness = infinity}), std::invalid_argument);
    CHECK_THROWS_AS(lit_leaves({.contrast = 2}), std::invalid_argument);
    CHECK_THROWS_AS(sheets({.spacing = -1}), std::invalid_argument);
    CHECK_THROWS_AS(ground_and_leaves({.half_side = nan}), std::invalid_argument);
    CHECK_THROWS_AS(meadow({.height = 0}), std::invalid_argument);
    CHECK_THROWS_AS(meadow({.cover = nan}), std::invalid_argument);
    CHECK_THROWS_AS(clouds({.clouds = 0}), std::invalid_argument);
    CHECK_THROWS_AS(clouds({.radius = -1}), std::invalid_argument);
    try {
        make_gallery("nothing", 0);
    } catch (const std::invalid_argument& e) {
        const std::string text = e.what();
        for (const GalleryEntry& entry : gallery()) CHECK(text.find(std::string(entry.name)) != std::string::npos);
    }
}

TEST_CASE("slats cover as much as their angle says", "[scenes]") {
    for (const float angle : {0.0f, 15.0f, 45.0f, 90.0f}) {
        const Triangles blind = slats({.slats = 16, .angle_degrees = angle, .segments = 20});
        CHECK(blind.size() == 640);
        CHECK(area(blind) == Approx(4));
        View view = test::looking_orthographic({0, 0, 8}, {}, 4, 100);
        const double covered = test::coverage(finely(blind, view)) / (100 * 100) * 16;
        INFO(angle << " degrees: " << covered << " of 4");
        CHECK(std::abs(covered - 4 * std::sin(double(angle) * 3.14159265 / 180)) < 0.15);
    }
}

TEST_CASE("a wall looks along its normal", "[scenes]") {
    for (const glm::vec3 normal : {glm::vec3(0, 0, 2), glm::vec3(1, 0, 1), glm::vec3(1, 1, 1), glm::vec3(0, -3, 0)}) {
        const Triangles square = wall({.normal = normal, .side_quads = 24});
        CHECK(square.size() == 1152);
        CHECK(area(square) == Approx(4));
        for (const Triangle& t : square) {
            const glm::vec3 across = glm::cross(t.vertices[1] - t.vertices[0], t.vertices[2] - t.vertices[0]);
            CHECK(glm::dot(glm::normalize(across), glm::normalize(normal)) == Approx(1));
            CHECK(std::abs(glm::dot(t.vertices[0], glm::normalize(normal))) < 1e-5f);
        }
    }
}

TEST_CASE("a bust is closed, outward and star-shaped, wherever it looks", "[scenes]") {
    for (const glm::vec3 towards : {glm::vec3(0, 0, 1), glm::vec3(1, 1, 1), glm::vec3(0, 1, 0)}) {
        for (const std::uint32_t n : {1u, 5u, 42u}) {
            INFO(n << " quads a side");
            const Triangles surface = bust({.looks_to = towards, .side_quads = n});
            CHECK(surface.size() == 12 * n * n);
            CHECK(is_watertight(surface));
            for (const Triangle& t : surface) {
                const glm::dvec3 a(t.vertices[0]), b(t.vertices[1]), c(t.vertices[2]);
                CHECK(glm::dot(a, glm::cross(b, c)) > 0);  // what turns the origin away from its back
            }
        }
    }
    // Without back faces it looks the same: nothing is seen through it.
    const Triangles surface = bust();
    for (const glm::vec3 towards :
         {glm::vec3(0, 0, 1), glm::vec3(0.6f, 0, -0.8f), glm::normalize(glm::vec3(1, 1, 1))}) {
        const View view = seen_from(towards, 4, 96);
        const Image both = test::plain_picture<Triangle>(surface, view, {.samples = 16});
        CHECK(both == test::plain_picture<Triangle>(surface, view, {.samples = 16, .culls_back_faces = true}));
    }
}

TEST_CASE("a bust looks alike from before it, wherever it looks", "[scenes]") {
    const Image front = finely(bust(), seen_from({0, 0, 1}, 4, 64));
    for (const glm::vec3 towards : {glm::normalize(glm::vec3(1, 0, 1)), glm::normalize(glm::vec3(1, 1, 1))}) {
        CHECK(test::rms_difference(finely(bust({.looks_to = towards}), seen_from(towards, 4, 64)), front) < 0.003);
    }
}

TEST_CASE("twigs are as thick, long and many as asked for", "[scenes]") {
    const Triangles many = twigs({.twigs = 300, .length = 0.5f, .thickness = 0.01f, .segments = 3});
    CHECK(many.size() == 5400);
    CHECK(area(many) == Approx(300 * 3 * 0.5 * 0.01).epsilon(1e-3));
    CHECK(reach(many) < 1.01f);
    CHECK_FALSE(same_bytes(many, twigs({.seed = 2, .twigs = 300, .length = 0.5f, .thickness = 0.01f, .segments = 3})));
}

TEST_CASE("leaves keep their area whatever their number, and are bright where the sun is", "[scenes]") {
    for (const std::uint32_t count : {1000u, 20'000u}) {
        const Triangles leaves = lit_leaves({.leaves = count, .cover = 3});
        CHECK(leaves.size() == count);
        CHECK(area(leaves) == Approx(3 * 3.14159265).epsilon(1e-3));
        CHECK(reach(leaves) <= 1.00001f);
    }
    const auto mean_luminance = [](const Triangles& triangles, glm::vec3 towards) {
        const Image image = finely(triangles, seen_from(towards, 4, 64));
        double sum = 0;
        for (const Rgba8 c : image.pixels()) sum += double(luminance(c));
        return sum / test::coverage(image);
    };
    const Triangles lit = lit_leaves({.contrast = 1}), plain = lit_leaves({.contrast = 0});
    CHECK(mean_luminance(lit, {1, 0, 0}) > 1.5 * mean_luminance(lit, {-1, 0, 0}));
    CHECK(mean_luminance(plain, {1, 0, 0}) == Approx(mean_luminance(plain, {-1, 0, 0})).epsilon(0.02));
}

TEST_CASE("sheets lie as far apart as asked for, the dark one in front", "[scenes]") {
    const glm::vec3 normal = glm::normalize(glm::vec3(1, 2, 3));
    const Triangles pile = sheets({.sheets = 5, .spacing = 0.02f, .normal = normal, .side_quads = 7});
    REQUIRE(pile.size() == 2 * 5 * 49);
    for (std::size_t i = 0; i < pile.size(); ++i) {
        const float expected = 0.02f * (2 - float(i / 98));
        for (const glm::vec3& v : pile[i].vertices) CHECK(std::abs(glm::dot(v, normal) - expected) < 1e-6f);
    }
    CHECK(luminance(pile.front().rgba) < 80);
    const Image picture = finely(pile, seen_from(normal, 4, 64));
    CHECK(luminance(picture.at(32, 32)) == Approx(luminance(pile.front().rgba)));
}

TEST_CASE("a ground of two triangles lies under the leaves", "[scenes]") {
    const Triangles all = ground_and_leaves({.leaves = {.leaves = 3000}, .half_side = 50});
    REQUIRE(all.size() == 3002);
    CHECK(same_bytes({all.begin(), all.end() - 2}, lit_leaves({.leaves = 3000})));
    for (std::size_t i = 3000; i < 3002; ++i) {
        for (const glm::vec3& v : all[i].vertices) CHECK((v.y == -1 && std::abs(v.x) == 50 && std::abs(v.z) == 50));
    }
}

TEST_CASE("a meadow has the area asked for, and stands on the ground", "[scenes]") {
    const Triangles grass = meadow({.blades = 5000, .height = 0.1f, .cover = 2});
    CHECK(grass.size() == 5000);
    CHECK(area(grass) == Approx(8).epsilon(0.05));
    for (const Triangle& t : grass) {
        CHECK(t.vertices[0].y == 0);
        CHECK(t.vertices[1].y == 0);
        CHECK(t.vertices[2].y > 0.04f);
        CHECK(t.vertices[2].y <= 0.1f);
    }
}

TEST_CASE("clouds in a row leave open what each of them does", "[scenes]") {
    // Orthographically along the row, in the middle of the disk.
    const auto open = [](std::uint32_t count) {
        const Triangles row = clouds({.clouds = count, .leaves = 3000, .cover = 0.3f, .radius = 0.5f});
        const Image image = finely(row, test::looking_orthographic({0, 0, 8}, {}, 0.4f, 32));
        return 1 - test::coverage(image) / (32 * 32);
    };
    const double one = open(1);
    CHECK(one == Approx(0.8).margin(0.05));
    CHECK(open(8) == Approx(std::pow(one, 8)).margin(0.05));
}

TEST_CASE("one color at each corner changes nothing", "[scenes]") {
    const GalleryScene scene = make_gallery("bust", 0.5f, 3000);
    const auto colored = vertex_colored(scene.triangles);
    const View view = seen_from(scene.towards_viewer, 4, 64);
    CHECK(test::plain_picture<VertexColoredTriangle>(colored, view) ==
          test::plain_picture<Triangle>(scene.triangles, view));
}
