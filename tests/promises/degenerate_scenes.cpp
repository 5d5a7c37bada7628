// Degenerate input is ordinary input, for every composable triple.
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "catch.hpp"
#include "support/pictures.hpp"
#include "support/scenes.hpp"
#include "support/variants.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

struct Scene {
    const char* name;
    Triangles triangles;
    /// Where polygons of one plane overlap, rounding decides which is seen.
    bool overlaps_in_a_plane = false;
};

std::vector<Scene> degenerate_scenes() {
    std::vector<Scene> scenes;
    Random random(20);
    const auto add = [&](const char* name, Triangles t) {
        scenes.push_back({name, std::move(t), std::string(name) == "coplanar, oblique"});
    };
    add("nothing", {});
    add("one triangle", random_triangles(1, 21, 0.8f));
    add("two triangles", random_triangles(2, 22, 0.8f));
    add("one triangle, 1000 times", Triangles(1000, random_triangles(1, 23, 0.5f)[0]));
    add("one tiny triangle, 3000 times, and a large one", [] {
        Triangles t(3000,
                    Triangle{{{{0.3f, 0.3f, 0.3f}, {0.3001f, 0.3f, 0.3f}, {0.3f, 0.3001f, 0.3f}}}, {255, 0, 0, 255}});
        t.push_back({{{{-1, -1, -1}, {1, -1, -1}, {1, 1, 1}}}, {0, 255, 0, 255}});
        return t;
    }());
    add("coplanar, on an axis", [&] {
        Triangles t = random_triangles(2500, 24, 0.05f);
        for (Triangle& one : t)
            for (glm::vec3& v : one.vertices) v.z = 0.25f;
        return t;
    }());
    add("coplanar, oblique", [&] {
        Triangles t = random_triangles(2500, 25, 0.05f);
        for (Triangle& one : t)
            for (glm::vec3& v : one.vertices) v.z = 0.3f * v.x - 0.7f * v.y;
        return t;
    }());
    add("collinear", [&] {
        Triangles t = random_triangles(2500, 26, 0.05f);
        for (Triangle& one : t)
            for (glm::vec3& v : one.vertices) v = glm::vec3(1, 2, -1) * v.x;
        return t;
    }());
    add("all in one point", Triangles(2500, Triangle{{{{1, 2, 3}, {1, 2, 3}, {1, 2, 3}}}, {255, 255, 255, 255}}));
    add("all in the origin", Triangles(2500, Triangle{{}, {255, 255, 255, 255}}));
    add("two points", [&] {
        Triangles t(2500, Triangle{{{{1, 2, 3}, {1, 2, 3}, {1, 2, 3}}}, {255, 255, 255, 255}});
        for (std::size_t i = 0; i < t.size(); i += 2) t[i].vertices.fill({1, 2, std::nextafter(3.0f, 4.0f)});
        return t;
    }());
    add("a ground plane under tiny leaves", [&] {
        Triangles t = sheet({-100, 0, 100}, {200, 0, 0}, {0, 0, -200}, 1, 1, {80, 60, 20, 255});
        append(t, moved(random_triangles(5000, 27, 0.003f), 1, {0, 1.2f, 0}));
        return t;
    }());
    for (const std::size_t count : {2500u, 200u}) {
        add(count == 200 ? "few needles" : "needles", [&] {
            Triangles t(count);
            for (Triangle& one : t) {
                const glm::vec3 from = random.in_cube(1), to = random.in_cube(1);
                one = {{from, to, to + random.in_cube(1e-5f)}, random.color()};
            }
            return t;
        }());
    }
    add("without area", [&] {
        Triangles t(2500);
        for (Triangle& one : t) {
            const glm::vec3 from = random.in_cube(1), to = from + random.in_cube(0.05f);
            one = {{from, to, to}, random.color()};
        }
        return t;
    }());
    add("geometric series towards a corner", [&] {
        Triangles t;
        float size = 1;
        for (int i = 0; i < 140; ++i, size *= 0.5f) {
            for (int k = 0; k < 20; ++k) {
                t.push_back({{glm::vec3(size), glm::vec3(size) + random.in_cube(size / 3),
                              glm::vec3(size) + random.in_cube(size / 3)},
                             random.color()});
            }
        }
        return t;
    }());
    add("far from the origin, at the end of single precision", [&] {
        return moved(random_triangles(2500, 28, 0.05f), 1, {3e6f, -3e6f, 3e6f});
    }());
    return scenes;
}

}  // namespace

TEST_CASE("degenerate scenes build, say what stopped early, and draw as a plain loop does") {
    for (const Scene& scene : degenerate_scenes()) {
        Box bounds = Box::empty();
        for (const Triangle& t : scene.triangles) bounds.add(t.bounds());
        const glm::dvec3 center = scene.triangles.empty() ? glm::dvec3(0) : glm::dvec3(bounds.center());
        const double size = scene.triangles.empty() ? 1.0 : std::max(1e-3, double(glm::length(bounds.size())));
        std::vector<View> views{looking(center + size * glm::dvec3(1, 0.5, 0.7), center, 64),
                                looking_orthographic(center + size * glm::dvec3(1, 0.5, 0.7), center, float(size), 64),
                                looking(center, center + glm::dvec3(1, 0.25, 0), 64)};
        std::vector<Image> plain;
        for (const View& view : views) plain.push_back(plain_picture<Triangle>(scene.triangles, view));
        for (const Variant& variant : all_variants()) {
            // As many planes as lines that cross: minutes for all variants together.
            if (variant.is_clipped && scene.name == std::string("needles")) continue;
            INFO(scene.name << ": " << variant.name);
            const auto h = variant.build(scene.triangles);
            const BuildReport& report = h->report();
            CHECK(report.primitives == scene.triangles.size());
            CHECK(report.nodes == h->nodes().size());
            CHECK(report.items == h->item_count());
            CHECK(report.levels <= (variant.is_clipped ? 501 : 33));
            CHECK(report.items + report.polygons_joined + report.polygons_without_area >= report.primitives);
            if (variant.is_clipped) {
                CHECK(report.cells_out_of_order == 0);
                // Two or more are told apart in each cell that is split.
                CHECK(report.nodes <= 3 * report.items + 1);
            } else if (!variant.is_shared) {
                CHECK(report.items == report.primitives);
                // Linear space, with room for cells that share what is large.
                CHECK(report.nodes <= 2 * scene.triangles.size() + 40);
            }
            ZBufferRenderer renderer;
            const auto viewer = h->viewer(renderer);
            for (std::size_t i = 0; i < views.size(); ++i) {
                INFO("view " << i);
                viewer->frame(views[i]);
                if (!(variant.is_clipped && scene.overlaps_in_a_plane))
                    CHECK(variant.is_plain(renderer.image(), plain[i]));
                View coarse = views[i];
                coarse.tolerance_px = 4;
                Recorder recorder;
                h->frame(coarse, recorder);  // defined, whatever it draws
                for (const Face& f : recorder.faces) {
                    CHECK((std::isfinite(f.lower.x) && std::isfinite(f.upper.x) && f.rgba.a != 0));
                }
                recorder.clear();
                recorder.largest_splat = 100;
                h->frame(coarse, recorder);
                for (const Splat& s : recorder.splats) {
                    CHECK((s.opacity >= 0 && s.opacity <= 1 && std::isfinite(s.size.x * s.size.y) && s.size.x > 0 &&
                           s.size.y > 0));
                }
            }
        }
    }
}

TEST_CASE("without tolerance primitives without extent are handed over like any other") {
    // A renderer may draw a point as something: leaving it out is its own decision.
    for (const glm::vec3 point : {glm::vec3(0), glm::vec3(1, 2, 3)}) {
        const Triangles triangles(2500, Triangle{{point, point, point}, {255, 255, 255, 255}});
        for (const Variant& variant : all_variants()) {
            INFO(variant.name);
            const auto h = variant.build(triangles);
            Recorder recorder;
            const FrameStats stats = h->frame(looking(glm::dvec3(point) + glm::dvec3(5, 0, 0), point), recorder);
            // Polygons without area are what a partition that cuts leaves out: it has nothing but polygons.
            CHECK(stats.primitives == (variant.is_clipped ? 0 : triangles.size()));
            CHECK(h->report().polygons_without_area == (variant.is_clipped ? triangles.size() : 0));
            CHECK(stats.approximations == 0);
        }
    }
}

TEST_CASE("what cannot be split says why") {
    Triangles equal(3000, random_triangles(1, 23, 0.01f)[0]);
    equal.push_back({{{{4, 4, 4}, {4, 4, 4.01f}, {4, 4.01f, 4}}}, {255, 255, 255, 255}});
    Triangles two_places = equal;
    for (std::size_t i = 0; i < two_places.size(); i += 2) {
        for (glm::vec3& v : two_places[i].vertices) v.x = std::nextafter(v.x, 9.0f);
    }
    const Triangles many = random_triangles(12000, 29, 0.01f);
    for (const Variant& variant : all_variants()) {
        INFO(variant.name);
        const BuildReport all_equal = variant.build(equal)->report();
        CHECK(all_equal.nodes <= 100);
        const BuildReport tight = variant.build(two_places)->report();
        if (variant.is_clipped) {
            // What lies in one plane need not be told apart.
            CHECK(all_equal.cells_out_of_order + tight.cells_out_of_order == 0);
        } else {
            CHECK(all_equal.cells_that_cannot_be_told_apart == 1);
            CHECK(tight.cells_that_cannot_be_told_apart + tight.cells_at_depth_limit + tight.splits_that_would_not_pay >
                  0);
        }
        // The root alone fits.
        const auto held = variant.build_with(many, 4 * many.size() + 50, {});
        const auto free = variant.build(many);
        CHECK(held->report().cells_over_memory_budget > 0);
        CHECK((held->report().cells_out_of_order > 0) == variant.is_clipped);
        CHECK(held->nodes().size() <= 9);
        CHECK(free->report().cells_over_memory_budget == 0);
        CHECK(free->nodes().size() > 9);
    }
}

TEST_CASE("duplicates take space in proportion to their number") {
    const Triangle one = random_triangles(1, 23, 0.5f)[0];
    const Triangles few(250, one), many(1000, one);
    for (const Variant& variant : all_variants()) {
        const auto a = variant.build(few), b = variant.build(many);
        INFO(variant.name << ": " << a->item_count() << " items of 250, " << b->item_count() << " of 1000");
        CHECK(b->item_count() <= 6 * a->item_count());
        CHECK(b->item_count() <= 64 * many.size());
    }
}

TEST_CASE("boxes that are empty or not finite are refused by the primitive's index") {
    const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
    for (const Variant& variant : all_variants()) {
        for (const std::size_t bad : {0u, 1u, 777u}) {
            for (const float value : {nan, infinity, -infinity}) {
                for (int where = 0; where < 9; ++where) {
                    Triangles triangles = random_triangles(778, 30);
                    triangles[bad].vertices[std::size_t(where / 3)][where % 3] = value;
                    INFO(variant.name << ", primitive " << bad << ", " << value << " at " << where);
                    try {
                        variant.build(triangles);
                        FAIL_CHECK("was not refused");
                    } catch (const std::invalid_argument& e) {
                        INFO(e.what());
                        CHECK(std::string(e.what()).find("primitive " + std::to_string(bad) + " ") !=
                              std::string::npos);
                    }
                }
            }
        }
    }
}

TEST_CASE("a scene too large for single precision is refused, or drawn") {
    Triangles triangles = random_triangles(500, 31);
    for (Triangle& t : triangles) {
        for (glm::vec3& v : t.vertices) v *= 2.5e38f;
    }
    for (const Variant& variant : all_variants()) {
        INFO(variant.name);
        try {
            const auto h = variant.build(triangles);
            for (const NodeRef& node : all_nodes(*h)) {
                CHECK(node.cell.box().is_finite());
                CHECK(node.cell.bounds().is_finite());
            }
        } catch (const std::invalid_argument& e) {
            CHECK(std::string(e.what()).find("farfield: primitive ") == 0);
        }
    }
}
