#include "farfield/approximation/opacity_tensor.hpp"

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/executor.hpp"
#include "farfield/measure/coverage_error.hpp"
#include "farfield/measure/image_error.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/spatial_hierarchy.hpp"
#include "farfield/viewer.hpp"
#include "support/pictures.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

const Rgba8 white{255, 255, 255, 255};
/// What is drawn for a sheet is what its tensor says.
const OpacityTensor plain{.sheet_gain = 1, .closed_sheet_gain = 1};

/// Two by two by two at the origin; its bounds are `looseness` times as large.
Cell unit_cell(float looseness = 1) {
    Cell c;
    c.half = glm::vec3(1);
    c.bounds_half = glm::vec3(looseness);
    return c;
}
Cell placed(Cell cell, float scale, glm::vec3 offset) {
    cell.center = cell.center * scale + offset;
    cell.half *= scale;
    cell.bounds_center = cell.bounds_center * scale + offset;
    cell.bounds_half *= scale;
    return cell;
}

StoredTensor data_of(const Cell& cell, const Triangles& triangles, const OpacityTensor& a = plain,
                     GridSampler sampler = {}) {
    const TensorSums d = a.sample(
        cell,
        [&](auto&& sink) {
            for (const Triangle& t : triangles) t.polygons(sink);
        },
        sampler);
    return a.finish(cell, d);
}

struct Sink {
    float splat_limit_px = 0;
    std::vector<Face>* faces;
    std::vector<Splat>* splats;
    void operator()(const Face& f) const { faces->push_back(f); }
    void operator()(const Splat& s) const { splats->push_back(s); }
};
struct Drawn {
    std::vector<Face> faces;
    std::vector<Splat> splats;
};
Drawn draw(const StoredTensor& data, const Cell& cell, const View& view, const OpacityTensor& a = plain,
           float splat_limit_px = 1e9f) {
    Drawn d;
    a.draw_stand_in(data, cell, LocalView(view, {}, 5), Sink{splat_limit_px, &d.faces, &d.splats});
    return d;
}
/// Of one deposit or none; as a length squared at the center's depth.
float covered(const Drawn& d) {
    REQUIRE(d.faces.empty());
    REQUIRE(d.splats.size() <= 1);
    if (d.splats.empty()) return 0;
    const Splat& s = d.splats[0];
    CHECK(s.size.x > 0);
    CHECK(s.size.y > 0);
    CHECK(s.opacity >= 0);
    CHECK(s.opacity <= 1);
    return s.size.x * s.size.y * s.opacity;
}
View from(glm::vec3 direction) {
    return looking_orthographic(glm::dvec3(direction) * 5.0);
}
float covered_from(const StoredTensor& data, const Cell& cell, glm::vec3 direction, const OpacityTensor& a = plain) {
    return covered(draw(data, cell, from(direction), a));
}

/// A square about the center.
Triangles square(glm::vec3 center, glm::vec3 normal, float side, int n = 4, Rgba8 color = white) {
    const glm::vec3 other = std::abs(normal.x) < 0.7f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
    const glm::vec3 u = glm::normalize(glm::cross(other, normal)), v = glm::cross(normal, u);
    return sheet(center - (u + v) * (0.5f * side), u * side, v * side, n, n, color);
}
/// Leaves of this side strewn over [-1, 1]^3, as many as cover it `fill` times on average.
Triangles leaves(float fill, float side, std::uint64_t seed) {
    Random random(seed);
    Triangles out;
    for (int i = int(fill * 8 / (side * side)); i > 0; --i) {
        const glm::vec3 center = random.in_cube(1 - side);  // arguments are evaluated in any order
        append(out, square(center, random.direction(), side, 1));
    }
    return out;
}
/// [-1, 1]^3 seen orthographically, at 64 samples a pixel: what is covered, as a length squared.
double exactly_covered(const Triangles& triangles, glm::vec3 direction) {
    const View view = looking_orthographic(glm::dvec3(direction) * 5.0, {}, 4, 64);
    return coverage(plain_picture<Triangle>(triangles, view, {.samples = 64})) / 256;
}

/// Rounding of what is stored: of the scale and of the root's entries, a part of the area.
constexpr float stored = 0.022f + 0.017f;
/// Three deviations of the number of samples that hit a square so many samples wide, as a part of that number.
float seen_by_masks(float samples_wide) {
    return 3 * std::sqrt(0.28f * samples_wide) / (samples_wide * samples_wide);
}

bool finite(glm::vec3 v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
bool sound(const Drawn& d) {
    for (const Face& f : d.faces) {
        if (!finite(f.lower) || !finite(f.upper) || f.rgba.a == 0) return false;
    }
    for (const Splat& s : d.splats) {
        if (!finite(s.center) || !std::isfinite(s.size.x) || !std::isfinite(s.size.y)) return false;
        if (!(s.size.x > 0 && s.size.y > 0 && s.opacity >= 0 && s.opacity <= 1)) return false;
    }
    return d.faces.size() <= 3 && d.splats.size() <= 1;
}

using Tensors = SpatialHierarchy<Octree, OpacityTensor, TriangleCount>;
using Cubes = SpatialHierarchy<Octree, ColorCube, TriangleCount>;

template <class H>
Image picture(const H& h, const Triangles& triangles, const View& view, const ZBufferOptions& options = {}) {
    ZBufferRenderer renderer(options);
    Viewer<H, Triangle, ZBufferRenderer> viewer(h, triangles, renderer);
    const FrameStats stats = viewer.frame(view);
    CHECK(stats.approximations > 0);
    return renderer.image();
}

}  // namespace

TEST_CASE("a wall covers the cosine of the angle it is seen under", "[approximation]") {
    Random random(101);
    for (const float looseness : {1.0f, 2.0f}) {
        const Cell cell = unit_cell(looseness);
        for (int axis = 0; axis < 3; ++axis) {
            glm::vec3 corner(-1), u(0), v(0), n(0);
            corner[axis] = 0.1f;
            u[(axis + 1) % 3] = v[(axis + 2) % 3] = 2;
            n[axis] = 1;
            const StoredTensor data = data_of(cell, sheet(corner, u, v, 8, 8, white));
            const StoredTensor with_gain = data_of(cell, sheet(corner, u, v, 8, 8, white), OpacityTensor{});
            CHECK(data == with_gain);
            for (int i = 0; i < 60; ++i) {
                const glm::vec3 w = random.direction();
                const float cosine = std::abs(w[axis]), found = covered_from(data, cell, w) / 4;
                INFO("axis " << axis << ", looseness " << looseness << ", cosine " << cosine);
                CHECK(std::abs(found - cosine) <= 0.03f);
                const float gained = covered_from(data, cell, w, OpacityTensor{}) / 4;
                CHECK(gained >= found - 1e-6f);
                CHECK(gained <= 1.15001f * found);
            }
        }
    }
}

TEST_CASE("a flat piece of any direction covers what is seen of it", "[approximation]") {
    Random random(102);
    const OpacityTensor areas_alone{.counts_overlap = false, .sheet_gain = 1, .closed_sheet_gain = 1};
    const Cell cell = unit_cell();
    for (int i = 0; i < 200; ++i) {
        const glm::vec3 n = random.direction();
        const float side = random.between(0.8f, 1.4f);
        const Triangles triangles = square(random.in_cube(0.1f), n, side);
        const StoredTensor data = data_of(cell, triangles), alone = data_of(cell, triangles, areas_alone);
        for (int k = 0; k < 10; ++k) {
            const glm::vec3 w = random.direction();
            const float cosine = std::abs(glm::dot(n, w)), area = side * side;
            INFO("normal " << n.x << " " << n.y << " " << n.z << ", cosine " << cosine << ", side " << side);
            CHECK(std::abs(covered_from(alone, cell, w, areas_alone) / area - cosine) <= stored);
            CHECK(std::abs(covered_from(data, cell, w) / area - cosine) <= stored + seen_by_masks(side * 16));
        }
    }
}

TEST_CASE("leaves cover what is seen between them", "[approximation]") {
    Random random(103);
    const Cell cell = unit_cell();
    for (const float fill : {0.1f, 0.5f, 1.0f, 2.0f}) {
        // Of one cell masks see some 250 samples: where a tenth is covered, give or take a fifth. In the mean nothing.
        double along_axes = 0, askew = 0, part = 0;
        const int cells = 12;
        for (int i = 0; i < cells; ++i) {
            const Triangles triangles = leaves(fill, 0.05f, std::uint64_t(1030 + i));
            const StoredTensor data = data_of(cell, triangles);
            CHECK(data.area_law() != AreaLaw::coherent);
            for (int axis = 0; axis < 2; ++axis) {
                const glm::vec3 along(axis == i % 2, axis != i % 2, 0), w = random.direction();
                const double exact = exactly_covered(triangles, along);
                along_axes += double(covered_from(data, cell, along)) / exact - 1;
                askew += double(covered_from(data, cell, w)) / exactly_covered(triangles, w) - 1;
                part += exact / 4;
            }
        }
        const int count = 2 * cells;
        part /= count;
        const double chance = std::sqrt((1 - part) / part / 250 / count);
        INFO("fill " << fill << ", part " << part);
        CHECK(std::abs(along_axes / count) <= 0.05 + 2.5 * chance);
        CHECK(std::abs(askew / count) <= 0.05 + 2.5 * chance);
    }
}

TEST_CASE("sheets behind each other cover once", "[approximation]") {
    const Cell cell = unit_cell();
    Random random(104);
    for (const float part : {0.5f, 1.0f}) {
        for (const int n : {1, 2, 10}) {
            Triangles sheets;
            for (int i = 0; i < n; ++i) {
                append(sheets, sheet({-1, -1, n == 1 ? 0 : -0.9f + 1.8f * float(i) / float(n - 1)}, {2 * part, 0, 0},
                                     {0, 2, 0}, 4, 4, white));
            }
            INFO(n << " sheets over " << part);
            CHECK(covered_from(data_of(cell, sheets), cell, {0, 0, 1}) == Approx(4 * part).epsilon(0.03));
            // In one place: a sheet, n times as thick.
            Triangles same;
            for (int i = 0; i < n; ++i) append(same, sheet({-1, -1, 0}, {2 * part, 0, 0}, {0, 2, 0}, 4, 4, white));
            const StoredTensor data = data_of(cell, same);
            CHECK(covered_from(data, cell, {0, 0, 1}) == Approx(4 * part).epsilon(0.03));
        }
    }
}

TEST_CASE("slats close a view as soon as they overlap in it", "[approximation]") {
    Triangles slats;
    for (int i = 0; i < 16; ++i) {
        append(slats, sheet({-1, -0.9375f + 0.125f * float(i), -1}, {0, 0, 2}, {2, 0, 0}, 4, 4, white));
    }
    const Cell cell = unit_cell();
    const StoredTensor data = data_of(cell, slats);
    for (const float degrees : {0.0f, 15.0f, 30.0f, 45.0f, 60.0f, 75.0f, 82.0f}) {
        const float angle = degrees * 3.14159265f / 180;
        const glm::vec3 w(0, std::cos(angle), std::sin(angle));
        // Each slat shows 2 cos, each next one lies sin / 8 lower; from 86.4 degrees on they come apart.
        const float exact = 2 * (2 * std::cos(angle) + 1.875f * std::sin(angle));
        INFO(degrees << " degrees");
        CHECK(covered_from(data, cell, w) == Approx(exact).epsilon(0.08));
    }
}

TEST_CASE("backs of closed surfaces are not seen", "[approximation]") {
    const OpacityTensor closed{.closed_surfaces = true, .sheet_gain = 1, .closed_sheet_gain = 1};
    const Cell cell = unit_cell();
    Random random(105);
    const StoredTensor wall = data_of(cell, sheet({-1, -1, 0.1f}, {2, 0, 0}, {0, 2, 0}, 4, 4, white), closed);
    for (int i = 0; i < 200; ++i) {
        const glm::vec3 w = random.direction();
        INFO("cosine " << w.z);
        const float found = covered_from(wall, cell, w, closed) / 4;
        if (w.z < -0.08f) {
            CHECK(found == 0);
        } else {
            CHECK(std::abs(found - std::max(w.z, 0.0f)) <= 0.06f);
        }
    }
    // A ball: its disk from everywhere.
    const StoredTensor ball = data_of(cell, sphere({0, 0, 0}, 0.9f, 16, white), closed);
    for (int i = 0; i < 50; ++i) {
        CHECK(covered_from(ball, cell, random.direction(), closed) == Approx(3.14159f * 0.81f).epsilon(0.08));
    }
    // An octant of it: nothing from within.
    Triangles octant;
    for (const Triangle& t : sphere({-1, -1, -1}, 1.9f, 32, white)) {
        const glm::vec3 middle = (t.vertices[0] + t.vertices[1] + t.vertices[2]) / 3.0f;
        if (middle.x > -1 && middle.y > -1 && middle.z > -1) octant.push_back(t);
    }
    const StoredTensor part = data_of(cell, octant, closed);
    const glm::vec3 out(std::sqrt(1.0f / 3));
    CHECK(covered_from(part, cell, -out, closed) == 0);
    CHECK(covered_from(part, cell, out, closed) == Approx(exactly_covered(octant, out)).epsilon(0.08));
}

TEST_CASE("open surfaces show both sides", "[approximation]") {
    const Cell cell = unit_cell();
    const StoredTensor data = data_of(cell, sheet({-1, -1, 0.1f}, {2, 0, 0}, {0, 2, 0}, 4, 4, white));
    Random random(106);
    for (int i = 0; i < 50; ++i) {
        const glm::vec3 w = random.direction();
        CHECK(covered_from(data, cell, w) == Approx(covered_from(data, cell, -w)).epsilon(1e-4));
    }
}

TEST_CASE("a leaf is brighter from its lit side", "[approximation]") {
    const DirectionalLight light{.towards = {0, 0, 1}, .ambient = 0.2f, .diffuse = 0.6f};
    const Rgba8 color{200, 100, 50, 255};
    const Cell cell = unit_cell();
    const StoredTensor data =
        data_of(cell, sheet({-0.5f, -0.5f, 0}, {1, 0, 0}, {0, 1, 0}, 3, 3, color), plain, GridSampler(light));
    const auto seen = [&](glm::vec3 w) {
        const Drawn d = draw(data, cell, from(w));
        REQUIRE(d.splats.size() == 1);
        return glm::vec3(d.splats[0].rgb.r, d.splats[0].rgb.g, d.splats[0].rgb.b);
    };
    const auto expected = [&](float brightness) { return glm::vec3(200, 100, 50) * brightness; };
    for (const glm::vec3 w : {glm::vec3(0, 0, 1), glm::vec3(0.6f, 0, 0.8f), glm::vec3(0, -0.8f, 0.6f)}) {
        CHECK(glm::length(seen(w) - expected(0.8f)) < 16);
        CHECK(glm::length(seen(-w) - expected(0.2f)) < 16);
    }
    // The light on closed surfaces is that on their fronts.
    const OpacityTensor closed{.closed_surfaces = true, .sheet_gain = 1, .closed_sheet_gain = 1};
    const StoredTensor front =
        data_of(cell, sheet({-0.5f, -0.5f, 0}, {1, 0, 0}, {0, 1, 0}, 3, 3, color), closed, GridSampler(light));
    const Drawn d = draw(front, cell, from({0, 0, 1}), closed);
    REQUIRE(d.splats.size() == 1);
    CHECK(std::abs(float(d.splats[0].rgb.r) - 160) < 14);
    // A ball under a light from above: day and night.
    const StoredTensor ball = data_of(cell, sphere({0, 0, 0}, 0.9f, 16, color), closed, GridSampler(light));
    const Drawn day = draw(ball, cell, from({0, 0, 1}), closed), night = draw(ball, cell, from({0, 0, -1}), closed);
    REQUIRE(day.splats.size() == 1);
    REQUIRE(night.splats.size() == 1);
    // Lambert over a disk: two thirds of the diffuse part.
    CHECK(float(day.splats[0].rgb.r) == Approx(200 * (0.2 + 0.6 * 2 / 3)).epsilon(0.12));
    CHECK(float(night.splats[0].rgb.r) == Approx(200 * 0.2).epsilon(0.3));
}

TEST_CASE("without light the color is the mean of what is seen", "[approximation]") {
    const Cell cell = unit_cell();
    Triangles t = sheet({-0.5f, -0.5f, 0}, {1, 0, 0}, {0, 1, 0}, 3, 3, {200, 100, 50, 255});
    append(t, sheet({-0.5f, -0.5f, 0.5f}, {1, 0, 0}, {0, 1, 0}, 3, 3, {0, 200, 150, 255}));
    const Drawn d = draw(data_of(cell, t), cell, from({0, 0, 1}));
    REQUIRE(d.splats.size() == 1);
    CHECK(std::abs(d.splats[0].rgb.r - 100) <= 5);
    CHECK(std::abs(d.splats[0].rgb.g - 150) <= 3);
    CHECK(std::abs(d.splats[0].rgb.b - 100) <= 5);
}

TEST_CASE("without splats up to three faces are drawn, and polygons are these", "[approximation]") {
    Random random(107);
    for (int i = 0; i < 60; ++i) {
        const Cell cell = unit_cell(i % 2 ? 2.0f : 1.0f);
        const Triangles triangles =
            i % 3 == 0   ? square(random.in_cube(0.2f), random.direction(), 1)
            : i % 3 == 1 ? random_triangles(1 + random.below(200), 1070 + random.bits(), 0.1f)
                         : sheet({-1, -1, random.between(-0.9f, 0.9f)}, {2, 0, 0}, {0, 1, 0}, 3, 3, white);
        for (const bool is_closed : {false, true}) {
            const OpacityTensor a{.closed_surfaces = is_closed, .sheet_gain = 1, .closed_sheet_gain = 1};
            const StoredTensor data = data_of(cell, triangles, a);
            std::array<float, 3> areas{};
            int polygons = 0;
            a.polygons(data, cell, [&](const Polygon& p) {
                ++polygons;
                CHECK(p.is_lit);
                REQUIRE(p.vertices.size() == 4);
                REQUIRE(p.colors.size() == 1);
                CHECK(p.colors[0].a > 0);
                const glm::vec3 n = glm::cross(p.vertices[1] - p.vertices[0], p.vertices[3] - p.vertices[0]);
                for (int axis = 0; axis < 3; ++axis) {
                    areas[std::size_t(axis)] += std::abs(n[axis]) * float(p.colors[0].a) / 255;
                }
            });
            CHECK(polygons <= 3);
            for (int axis = 0; axis < 3; ++axis) {
                glm::vec3 w(0);
                w[axis] = 1;
                const float along = covered_from(data, cell, w, a),
                            largest = 4 * cell.bounds_half.x * cell.bounds_half.x;
                INFO("round " << i << ", axis " << axis << (is_closed ? ", closed" : ""));
                CHECK(areas[std::size_t(axis)] >= along - largest / 255);
                CHECK(areas[std::size_t(axis)] <= 1.1f * along + largest / 255);
            }
            for (int k = 0; k < 20; ++k) {
                const glm::vec3 eye = random.direction() * 6.0f;
                const View view = k % 2 ? looking(eye) : from(eye / 6.0f);
                const Drawn d = draw(data, cell, view, a, 0);
                CHECK(d.splats.empty());
                CHECK(d.faces.size() <= 3);
                CHECK(sound(d));
                const LocalView local(view, {}, 5);
                for (const Face& f : d.faces) {
                    const int axis = f.side / 2;
                    CHECK(f.lower[axis] == f.upper[axis]);
                    CHECK(((f.side & 1) != 0) == (local.towards_viewer(f.lower)[axis] > 0));
                    CHECK(glm::all(
                        glm::greaterThan(f.rgba.a + 1 - glm::ivec3(f.rgba.r, f.rgba.g, f.rgba.b), glm::ivec3(-1))));
                }
            }
        }
    }
}

TEST_CASE("polygons of an open cell are those that are drawn, all of them by one factor more opaque",
          "[approximation]") {
    Random random(108);
    const Cell cell = unit_cell();
    for (int i = 0; i < 20; ++i) {
        const StoredTensor data = data_of(cell, random_triangles(100, 1080 + std::uint64_t(i), 0.2f));
        std::vector<float> alphas, faces;
        plain.polygons(data, cell, [&](const Polygon& p) { alphas.push_back(p.colors[0].a); });
        for (const Face& f : draw(data, cell, from(glm::vec3(std::sqrt(1.0f / 3))), plain, 0).faces) {
            faces.push_back(f.rgba.a);
        }
        REQUIRE(alphas.size() == faces.size());
        for (std::size_t k = 0; k < faces.size(); ++k) {
            CHECK(alphas[k] == Approx(faces[k] * alphas[0] / faces[0]).margin(2));
            CHECK(alphas[k] >= faces[k]);
            CHECK(alphas[k] <= 1.1f * faces[k] + 1);
        }
    }
}

TEST_CASE("away from the picture's center it covers what perspective makes of it", "[approximation]") {
    Random random(109);
    for (int i = 0; i < 300; ++i) {
        Cell cell = unit_cell();
        // Small, so that one depth is that of all of it; upright sheets of any direction, under up to 40 degrees.
        const float side = 0.02f;
        const glm::vec3 eye = random.direction() * 4.0f;
        const View view = looking(eye, random.in_cube(1));
        const LocalView local(view, {}, 5);
        const glm::vec3 depth = local.forward * 4.0f;
        cell = placed(cell, side, eye + depth + local.right * random.between(-3, 3) + local.up * random.between(-3, 3));
        const glm::vec3 n = random.direction();
        const Triangles triangles = square(cell.center, n, side);
        const OpacityTensor areas_alone{.counts_overlap = false, .sheet_gain = 1, .closed_sheet_gain = 1};
        const StoredTensor data = data_of(cell, triangles, areas_alone);
        const auto projected = [&](glm::vec3 p) {
            const glm::dvec3 d = glm::dvec3(p) - glm::dvec3(eye);
            return glm::dvec2(glm::dot(d, glm::dvec3(local.right)), glm::dot(d, glm::dvec3(local.up))) /
                   glm::dot(d, glm::dvec3(local.forward));
        };
        double exact = 0;
        for (const Triangle& t : triangles) {
            const glm::dvec2 a = projected(t.vertices[1]) - projected(t.vertices[0]),
                             b = projected(t.vertices[2]) - projected(t.vertices[0]);
            exact += 0.5 * std::abs(a.x * b.y - a.y * b.x);
        }
        const glm::vec3 d = cell.center - eye;
        const double at_depth = double(glm::dot(d, local.forward));
        const double squarely = double(side) * side / (at_depth * at_depth);
        INFO("round " << i << ", " << glm::length(d) / float(at_depth) << " off center");
        const double found = double(covered(draw(data, cell, view, areas_alone))) / (at_depth * at_depth);
        CHECK(std::abs(found - exact) <= double(stored) * squarely * double(glm::length(d)) / at_depth);
    }
    // Squarely seen along an axis, where quantization takes nothing: within 3 %.
    for (const float off : {0.0f, 0.3f, 0.6f, 1.0f}) {
        const Cell cell = placed(unit_cell(), 0.02f, {4 * off, 0, -4});
        const StoredTensor data = data_of(cell, square(cell.center, {0, 0, 1}, 0.04f));
        const float found = covered(draw(data, cell, looking({0, 0, 0}, {0, 0, -1})));
        INFO("off " << off);
        CHECK(found == Approx(0.04f * 0.04f).epsilon(0.03));
        const StoredTensor upright = data_of(cell, square(cell.center, {1, 0, 0}, 0.04f));
        CHECK(covered(draw(upright, cell, looking({0, 0, 0}, {0, 0, -1}))) ==
              Approx(0.04f * 0.04f * off).epsilon(0.03).margin(0.02 * 0.04 * 0.04));
    }
}

TEST_CASE("what is drawn lies where the contents are", "[approximation]") {
    Random random(110);
    for (int i = 0; i < 200; ++i) {
        const Cell cell = unit_cell();
        const float side = random.between(0.2f, 0.8f);
        const glm::vec3 center = random.in_cube(0.5f), n = random.direction();
        const Triangles triangles = square(center, n, side);
        const StoredTensor data = data_of(cell, triangles);
        const View view = from(random.direction());
        const Drawn d = draw(data, cell, view);
        if (d.splats.empty()) continue;
        CHECK(glm::length(d.splats[0].center - center) <= 0.06f);
        // No wider or higher than the contents' box and the cell's sixteenth by which that is rounded.
        Box box = Box::empty();
        for (const Triangle& t : triangles) box.add(t.bounds());
        const glm::vec3 size = box.size() + 2.0f / 16;
        CHECK(d.splats[0].size.x <= glm::dot(glm::abs(view.camera.right), size));
        CHECK(d.splats[0].size.y <= glm::dot(glm::abs(view.camera.up), size));
    }
}

TEST_CASE("a translucent cell counts as much as its alpha", "[approximation]") {
    const Cell cell = unit_cell();
    for (const float part : {0.3f, 1.0f}) {
        Triangles t = sheet({-1, -1, 0.1f}, {2 * part, 0, 0}, {0, 2, 0}, 4, 4, {200, 100, 50, 128});
        const StoredTensor data = data_of(cell, t);
        INFO(part);
        CHECK(covered_from(data, cell, {0, 0, 1}) == Approx(4 * part * 128 / 255).epsilon(double(stored)));
        CHECK(covered_from(data, cell, {0.6f, 0, 0.8f}) == Approx(0.8 * 4 * part * 128 / 255).epsilon(0.08));
        const Drawn d = draw(data, cell, from({0, 0, 1}));
        REQUIRE(d.splats.size() == 1);
        CHECK(std::abs(d.splats[0].rgb.r - 200) <= 5);  // of what covers, whatever its alpha
    }
}

TEST_CASE("degenerate contents of cells are drawn as numbers or not at all", "[approximation]") {
    Random random(111);
    const glm::vec3 a(0.1f, 0.2f, 0.3f), b(-0.5f, 0.4f, -0.2f), c(0.7f, -0.3f, 0.2f);
    std::vector<Triangles> scenes;
    scenes.push_back({{{a, b, c}, white}});
    scenes.push_back({{{a, b, a + 0.5f * (b - a) + glm::vec3(1e-6f, 0, 0)}, white}});  // a needle
    scenes.push_back({{{a, b, c}, white}, {{a, c, b}, white}});                        // two opposite ones
    scenes.push_back(moved({{{a, b, c}, white}}, 1e-6f));
    scenes.push_back({{{a, b, c}, {255, 255, 255, 1}}});
    scenes.push_back(square({0.5f, 0.5f, 1}, {0, 0, 1}, 0.5f));  // on the border
    for (std::size_t i = 0; i < scenes.size(); ++i) {
        for (const bool is_closed : {false, true}) {
            const OpacityTensor tensor{.closed_surfaces = is_closed};
            for (const Cell& cell : {unit_cell(), unit_cell(2)}) {
                const StoredTensor data = data_of(cell, scenes[i], tensor);
                CHECK(data.is_sound());
                CHECK(tensor.work(data).splats == 1);
                for (int k = 0; k < 50; ++k) {
                    const glm::vec3 eye = random.direction() * random.between(0, 4);
                    for (const float limit : {0.0f, 1e9f}) {
                        INFO("scene " << i << ", view " << k);
                        CHECK(sound(draw(data, cell, looking(eye, random.in_cube(1)), tensor, limit)));
                        CHECK(sound(draw(data, cell, looking_orthographic(eye, random.in_cube(1)), tensor, limit)));
                    }
                }
            }
        }
    }
    // Two coincident opposite ones cover what one does, and none of them is a back.
    const Cell cell = unit_cell();
    const auto area = float(scenes[0][0].area());
    const glm::vec3 n = glm::normalize(glm::cross(b - a, c - a));
    const float one = covered_from(data_of(cell, scenes[0]), cell, n);
    CHECK(one == Approx(area).epsilon(0.06));
    CHECK(covered_from(data_of(cell, scenes[2]), cell, n) == Approx(area).epsilon(0.15));
    const OpacityTensor closed{.closed_surfaces = true, .sheet_gain = 1, .closed_sheet_gain = 1};
    CHECK(covered_from(data_of(cell, scenes[2], closed), cell, n, closed) == Approx(area).epsilon(0.15));
    CHECK(covered_from(data_of(cell, scenes[2], closed), cell, -n, closed) == Approx(area).epsilon(0.15));
}

TEST_CASE("what has no area has no stand-in: it is drawn", "[approximation]") {
    const Cell cell = unit_cell();
    const glm::vec3 a(0.1f, 0.2f, 0.3f), b(-0.5f, 0.4f, -0.2f);
    for (const Triangles& none : {Triangles{}, Triangles{{{a, b, b}, white}, {{a, b, a}, white}, {{a, a, a}, white}}}) {
        const StoredTensor data = data_of(cell, none);
        CHECK(data == StoredTensor{});
        CHECK(std::isinf(OpacityTensor{}.work(data).splats));
        CHECK(sound(draw(data, cell, from({0, 0, 1}))));
        CHECK(sound(draw(data, cell, looking({1, 2, 3}), plain, 0)));
    }
    Random random(112);
    Triangles lines(3000);
    for (Triangle& t : lines) {
        const glm::vec3 p = random.in_cube(1), q = random.in_cube(1);
        t = {{p, q, q}, white};
    }
    const Tensors h = build<Tensors>(lines);
    CHECK(h.stand_ins().empty());
    ZBufferRenderer renderer;
    const FrameStats stats =
        Viewer<Tensors, Triangle, ZBufferRenderer>(h, lines, renderer).frame(looking({0, 0, 40}, {}, 32, 1e6f));
    CHECK(stats.primitives == lines.size());
    CHECK(stats.approximations == 0);
}

TEST_CASE("the viewer within, before and behind a cell", "[approximation]") {
    const Cell cell = unit_cell();
    Random random(113);
    for (const Triangles& triangles : {leaves(1, 0.2f, 1130), sheet({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 4, 4, white)}) {
        const StoredTensor data = data_of(cell, triangles);
        const Drawn first = draw(data, cell, looking({0, 0, 5}));
        REQUIRE(first.splats.size() == 1);
        const glm::vec3 centroid = first.splats[0].center;
        // At the very centroid there is no direction.
        CHECK(draw(data, cell, looking(centroid, centroid + glm::vec3(0, 0, 1))).splats.empty());
        CHECK(sound(draw(data, cell, looking(centroid, centroid + glm::vec3(1, 0, 0)), plain, 0)));
        CHECK(sound(draw(data, cell, looking_orthographic(centroid, centroid + glm::vec3(1, 1, 0)))));
        CHECK(std::isinf(OpacityTensor{}.error_px(data, cell, LocalView(looking(centroid, {5, 5, 5}), {}, 5))));
        for (int i = 0; i < 200; ++i) {
            const glm::vec3 w = random.direction();
            // All of it behind the viewer.
            CHECK(draw(data, cell, looking(w * 4.0f, w * 5.0f)).splats.empty());
            // The near plane, the viewer, the centroid anywhere.
            View view = looking(random.in_cube(1.5f), random.in_cube(1));
            view.camera.near_depth = random.between(0.01f, 2);
            CHECK(sound(draw(data, cell, view)));
            CHECK(sound(draw(data, cell, view, plain, 0)));
            const float tiny = std::exp2(random.between(-30, -5));
            CHECK(sound(draw(data, cell, looking(centroid + w * tiny, centroid))));
        }
    }
}

TEST_CASE("flat cells and cells that are points", "[approximation]") {
    Random random(114);
    for (int axis = 0; axis < 3; ++axis) {
        glm::vec3 corner(-1), u(0), v(0), n(0);
        corner[axis] = 0;
        u[(axis + 1) % 3] = v[(axis + 2) % 3] = 2;
        n[axis] = 1;
        Cell flat = unit_cell();
        flat.half[axis] = flat.bounds_half[axis] = 0;
        const StoredTensor data = data_of(flat, sheet(corner, u, v, 4, 4, white));
        CHECK(covered_from(data, flat, n) == Approx(4).epsilon(0.03));
        for (int i = 0; i < 100; ++i) {
            const glm::vec3 w = random.direction();
            CHECK(std::abs(covered_from(data, flat, w) / 4 - std::abs(w[axis])) <= 0.04f);
            CHECK(sound(draw(data, flat, looking(w * 3.0f))));
            CHECK(sound(draw(data, flat, looking(w * 3.0f), plain, 0)));
        }
    }
    Cell point = unit_cell();
    point.half = point.bounds_half = glm::vec3(0);
    CHECK(data_of(point, {{{glm::vec3(0), glm::vec3(0), glm::vec3(0)}, white}}) == StoredTensor{});
    CHECK(data_of(point, square({0, 0, 0}, {0, 0, 1}, 1)) == StoredTensor{});
}

TEST_CASE("tensors are the same at any scale and place", "[approximation]") {
    Random random(115);
    for (int i = 0; i < 30; ++i) {
        const Triangles triangles = i % 2 ? random_triangles(60, 1150 + std::uint64_t(i), 0.3f)
                                          : square(random.in_cube(0.2f), random.direction(), 0.9f);
        const Cell cell = unit_cell();
        const StoredTensor here = data_of(cell, triangles);
        for (const int exponent : {-20, -13, 13, 23}) {
            const float scale = std::ldexp(1.0f, exponent);
            CHECK(data_of(placed(cell, scale, {}), moved(triangles, scale)) == here);
        }
        for (const auto& [scale, offset] : {std::pair(1e-4f, 0.0f), {1e4f, 0.0f}, {1e4f, 1e6f}, {1e-4f, 1e-2f}}) {
            const glm::vec3 by(offset, -offset, 0.5f * offset);
            const Cell there = placed(cell, scale, by);
            const StoredTensor data = data_of(there, moved(triangles, scale, by));
            INFO("round " << i << ", scale " << scale << ", offset " << offset);
            CHECK(data.area_law() == here.area_law());
            for (int k = 0; k < 10; ++k) {
                const glm::vec3 w = random.direction();
                const View view = looking_orthographic(glm::dvec3(w) * double(scale) * 5.0 + glm::dvec3(by),
                                                       glm::dvec3(by), 3 * scale);
                const float expected = covered_from(here, cell, w);
                // Rounding may take a step of what is stored to either side.
                CHECK(covered(draw(data, there, view)) / (scale * scale) == Approx(expected).margin(0.04));
            }
        }
    }
}

TEST_CASE("any number of threads makes the same tensors", "[approximation]") {
    for (const std::size_t count : {1u, 2u, 300u, 6000u}) {
        const Triangles triangles = mixed_triangles(count, 116);
        const Tensors serial = build<Tensors>(triangles);
        for (const unsigned threads : {1u, 2u, 3u, 8u}) {
            const Tensors h = build<Tensors>(triangles, {.executor = ThreadExecutor(threads)});
            INFO(count << " triangles, " << threads << " threads");
            REQUIRE(h.stand_ins().size() == serial.stand_ins().size());
            CHECK((h.stand_ins().empty() ||
                   std::memcmp(h.stand_ins().data(), serial.stand_ins().data(), h.stand_ins().size_bytes()) == 0));
        }
    }
}

TEST_CASE("the error is the cell's side on the screen", "[approximation]") {
    const Cell cell = unit_cell(2);
    const LocalView view(looking({0, 0, 11}, {0, 0, 0}, 200), {}, 5);
    CHECK(OpacityTensor{}.error_px({}, cell, view) == Approx(2 * view.focal_px / 10));
    CHECK(std::isinf(OpacityTensor{}.error_px({}, cell, LocalView(looking({0.5, 0, 0.2}), {}, 5))));
    for (unsigned levels = 0; levels < 5; ++levels) {
        CHECK(OpacityTensor{}.least_error_px(cell, levels, view) <=
              OpacityTensor{}.error_px({}, cell, view) / float(1u << levels) * 1.00001f);
    }
}

TEST_CASE("scenes of any size are drawn as numbers", "[approximation]") {
    const Triangles triangles = random_triangles(60, 118, 0.3f);
    for (const int exponent : {-40, -30, 30, 40}) {
        const float scale = std::ldexp(1.0f, exponent);
        const Cell cell = placed(unit_cell(), scale, {});
        const StoredTensor data = data_of(cell, moved(triangles, scale));
        const TensorShape shape = data.unpacked();
        INFO("2^" << exponent);
        CHECK(data.is_sound());
        if (data == StoredTensor{}) continue;  // drawn as primitives
        CHECK(std::abs(shape.root[0] - 0.33f) < 0.1f);
        const View view = looking_orthographic({0, 0, 5 * double(scale)}, {}, 3 * scale);
        CHECK(covered(draw(data, cell, view)) / (scale * scale) == Approx(2.0f).margin(1.0f));
    }
}

namespace {

/// Pictures at 64 samples of things `size_px` wide against exact ones, over eight views.
void check_coverage(const Triangles& triangles, int size_px, const std::vector<glm::vec3>& directions) {
    const Tensors tensors = build<Tensors>(triangles);
    const Cubes cubes = build<Cubes>(triangles);
    double bias = 0, tensor_mse = 0, cube_mse = 0, cube_bias = 0;
    for (const glm::vec3 w : directions) {
        View view = looking_orthographic(glm::dvec3(w) * 6.0, {}, 2 * 48 / float(size_px), 48);
        const ZBufferOptions options{.samples = 64};
        const Image exact = plain_picture<Triangle>(triangles, view, options);
        view.tolerance_px = 1;
        const Image tensor = picture(tensors, triangles, view, options);
        const Image cube = picture(cubes, triangles, view, options);
        bias += coverage_error(tensor, exact).bias;
        cube_bias += coverage_error(cube, exact).bias;
        tensor_mse += mse(tensor, exact);
        cube_mse += mse(cube, exact);
    }
    const auto count = double(directions.size());
    INFO(size_px << " pixels wide: RMSE " << std::sqrt(tensor_mse / count) << " and bias " << bias / count
                 << ", of cubes " << std::sqrt(cube_mse / count) << " and " << cube_bias / count);
    CHECK(std::abs(bias / count) < 0.05);
    CHECK(tensor_mse <= cube_mse);
}
std::vector<glm::vec3> around(std::uint64_t seed) {
    Random random(seed);
    std::vector<glm::vec3> out(8);
    for (glm::vec3& w : out) w = random.direction();
    return out;
}

}  // namespace

TEST_CASE("a ball of tensors covers what it stands for", "[approximation]") {
    const Triangles ball = sphere({0, 0, 0}, 1, 64, {200, 150, 100, 255});
    for (const int size_px : {14, 20}) check_coverage(ball, size_px, around(119));
}

TEST_CASE("a wall of tensors covers what it stands for", "[approximation]") {
    const Triangles wall = sheet({-1, -1, 0.13f}, {2, 0, 0}, {0, 2, 0}, 64, 64, white);
    std::vector<glm::vec3> directions;
    for (int i = 0; i < 8; ++i) {
        directions.push_back(glm::normalize(glm::vec3(0.3f * float(i), 0.1f * float(i), 1)));
    }
    for (const int size_px : {7, 14}) check_coverage(wall, size_px, directions);
}

TEST_CASE("leaves as tensors cover what they stand for", "[approximation]") {
    for (const int size_px : {7, 14}) check_coverage(leaves(3, 0.02f, 1190), size_px, around(120));
    for (const int size_px : {7, 14}) check_coverage(leaves(1, 0.012f, 1191), size_px, around(121));
}

TEST_CASE(
    "what is stored of the error is little for a sheet, more for a rod along a diagonal, and never falls downwards",
    "[approximation]") {
    const Cell cell = unit_cell();
    const float of_sheet = data_of(cell, square({0, 0, 0}, {0, 0, 1}, 1.9f)).error();
    CHECK(of_sheet < 0.05f);
    // Its box is all of the cell, seen along the rod nothing is there.
    Triangles rod;
    for (int i = 0; i < 400; ++i) {
        const glm::vec3 at(-0.9f + 1.8f * float(i) / 399);
        for (const glm::vec3 n : {glm::vec3(1, 0, 0), glm::vec3(0, 1, 0), glm::vec3(0, 0, 1)}) {
            append(rod, square(at, n, 0.2f, 1));
        }
    }
    CHECK(data_of(cell, rod).error() > of_sheet + 0.01f);

    const Triangles triangles = random_triangles(20000, 120, 0.02f);
    const auto h = build<SpatialHierarchy<Octree, OpacityTensor, TriangleCount>>(triangles);
    const View view = looking({0, 0, 9});
    const LocalView local(view, h.origin(), 4);
    std::size_t pairs = 0, falling = 0, without = 0;
    const auto visit = [&](auto&& self, std::uint32_t index, const Cell& at, const StoredTensor* data) -> void {
        const Node& node = h.nodes()[index];
        std::uint32_t rank = 0, data_rank = 0;
        for (unsigned child = 0; child < 8; ++child) {
            if ((node.child_mask >> child & 1) == 0) continue;
            const StoredTensor* below = nullptr;
            if (node.stand_in_mask >> child & 1) below = &h.stand_ins()[node.first_child_data + data_rank++];
            const Cell child_cell = h.partition_policy().child(at, {}, child);
            if (data && below) {
                ++pairs;
                without += below->error() == 0;
                falling += data->error() * 2 + 2 < below->error() + 1;
                CHECK(h.approximation_policy().least_error_px(at, 1, local) <=
                      h.approximation_policy().error_px(*below, child_cell, local));
            }
            self(self, node.first_child + rank++, child_cell, below);
        }
    };
    visit(visit, 0, h.root_cell(), h.root_stand_in());
    CHECK(pairs > 500);
    CHECK(falling == 0);
    // Of most cells masks cannot tell that anything is lost.
    CHECK(without < pairs);
}

TEST_CASE("a cell made of its children is drawn as one that was made of their contents", "[approximation]") {
    Random random(150);
    const Cell cell = unit_cell();
    const OpacityTensor a;
    GridSampler sampler;
    for (int round = 0; round < 20; ++round) {
        const Triangles triangles = round % 2 == 0 ? leaves(0.5f, 0.1f, 1500 + std::uint64_t(round))
                                                   : square(random.in_cube(0.3f), random.direction(), 0.8f);
        const auto contents = [&](auto&& sink) {
            for (const Triangle& t : triangles) t.polygons(sink);
        };
        std::vector<Cell> cells;
        std::vector<TensorSums> drafts;
        for (unsigned child = 0; child < 8; ++child) {
            const glm::vec3 side(child & 1 ? 0.5f : -0.5f, child & 2 ? 0.5f : -0.5f, child & 4 ? 0.5f : -0.5f);
            cells.push_back(placed(cell, 0.5f, side));
            drafts.push_back(a.sample(cells.back(), contents, sampler));
        }
        std::vector<ChildDraft<TensorSums>> children;
        for (unsigned child = 0; child < 8; ++child) children.push_back({child, &cells[child], &drafts[child]});
        TensorSums merged;
        a.merge(cell, merged, children);
        const StoredTensor together = a.finish(cell, merged), whole = data_of(cell, triangles, a);
        CHECK(together.area_law() == whole.area_law());
        for (int k = 0; k < 10; ++k) {
            const View view = from(random.direction());
            const Drawn d = draw(together, cell, view, a), e = draw(whole, cell, view, a);
            REQUIRE(d.splats.size() == e.splats.size());
            if (d.splats.empty()) continue;
            INFO("round " << round << ", view " << k);
            const Splat &p = d.splats[0], &q = e.splats[0];
            // Center and box are rounded to 1/32 and 1/16 of the cell, and a sheet's narrow side follows its normal.
            CHECK(glm::length(p.center - q.center) <= 0.07f);
            CHECK(glm::length(p.size - q.size) <= 0.2f);
            CHECK(covered(d) == Approx(covered(e)).epsilon(0.15).margin(0.04));
        }
    }
}

TEST_CASE("the error is the cell's side and what it shows too much or too little", "[approximation]") {
    const Cell cell = unit_cell();
    // A frame of square rods along the cell's edges: from an axis rods hide one another, from a diagonal none does.
    Triangles frame;
    for (int axis = 0; axis < 3; ++axis) {
        for (int i = 0; i < 16; ++i) {
            const float side = 0.2f, at_u = i & 1 ? -0.9f : 0.7f, at_v = i & 2 ? -0.9f : 0.7f;
            glm::vec3 corner(0), along(0), across(0);
            corner[axis] = -0.9f, along[axis] = 1.8f;
            corner[(axis + 1) % 3] = at_u + (i >= 12 ? side : 0.0f);
            corner[(axis + 2) % 3] = at_v + (i / 4 == 1 ? side : 0.0f);
            across[(axis + (i < 8 ? 1 : 2)) % 3] = side;
            append(frame, sheet(corner, along, across, 4, 1, white));
        }
    }
    CHECK(data_of(cell, frame).error() > 0.1f);
    for (std::uint64_t i = 0; i < 30; ++i) {
        const Triangles some = random_triangles(1 + i * i, 1510 + i, 0.4f);
        const StoredTensor data = data_of(cell, some);
        CHECK(data.error() < 0.1f);
        for (const View& view : {looking({3, 2, 7}), looking_orthographic({3, 2, 7})}) {
            const LocalView local(view, {}, 5);
            const float side = local.pixels(2, local.distance_to(cell));
            CHECK(plain.error_px(data, cell, local) == Approx(side * (1 + data.error())).epsilon(1e-6));
            CHECK(plain.least_error_px(cell, 0, local) <= side);
        }
    }
}

TEST_CASE("leaves are strewn over four tenths of their box", "[approximation]") {
    const Cell cell = unit_cell();
    for (const float fill : {0.1f, 0.3f}) {
        const StoredTensor data = data_of(cell, leaves(fill, 0.1f, 1540));
        REQUIRE(data.area_law() != AreaLaw::coherent);
        const glm::vec3 box = data.unpacked().extent * tensor_unit(cell);
        for (int axis = 0; axis < 3; ++axis) {
            glm::vec3 w(0);
            w[axis] = 1;
            const Drawn d = draw(data, cell, from(w), OpacityTensor{});
            REQUIRE(d.splats.size() == 1);
            REQUIRE(d.splats[0].opacity < 1);
            const float outline = box[(axis + 1) % 3] * box[(axis + 2) % 3];
            CHECK(d.splats[0].size.x * d.splats[0].size.y == Approx(outline).epsilon(1e-4));
        }
    }
}

TEST_CASE("what is covered so often that all laws close it is closed by the one that does so at once",
          "[approximation]") {
    // Sixty sheets along each axis, all over the cell: no law leaves anything.
    Triangles solid;
    for (int i = 0; i < 60; ++i) {
        const float at = -1 + 2 * float(i) / 59;
        append(solid, sheet({-1, -1, at}, {2, 0, 0}, {0, 2, 0}, 1, 1, white));
        append(solid, sheet({-1, at, -1}, {0, 0, 2}, {2, 0, 0}, 1, 1, white));
        append(solid, sheet({at, -1, -1}, {0, 2, 0}, {0, 0, 2}, 1, 1, white));
    }
    const StoredTensor data = data_of(unit_cell(), solid);
    CHECK(sheet_normal(data.unpacked()) == glm::vec3(0));
    CHECK(data.area_law() == AreaLaw::coherent);
}
