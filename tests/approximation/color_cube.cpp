#include "farfield/approximation/color_cube.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "catch.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/spatial_hierarchy.hpp"
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
ColorCube::stand_in_draft sampled(const ColorCube& a, const Cell& cell, const Triangles& triangles) {
    GridSampler sampler;
    return a.sample(
        cell,
        [&](auto&& sink) {
            for (const Triangle& t : triangles) t.polygons(sink);
        },
        sampler);
}
/// Squarely across an axis through the middle of the cell; `part` of the cell's width on the next axis.
Triangles wall(int axis, float part, Rgba8 color) {
    glm::vec3 corner(-1), u(0), v(0);
    corner[axis] = 0.1f;
    u[(axis + 1) % 3] = 2 * part;
    v[(axis + 2) % 3] = 2;
    return sheet(corner, u, v, 3, 2, color);
}
bool close(glm::vec4 a, glm::vec4 b, float by) {
    return glm::all(glm::lessThanEqual(glm::abs(a - b), glm::vec4(by)));
}

struct Sink {
    float splat_limit_px = 0;
    std::vector<Face>* faces;
    std::vector<Splat>* splats;
    void operator()(const Face& f) const { faces->push_back(f); }
    void operator()(const Splat& s) const { splats->push_back(s); }
};

}  // namespace

TEST_CASE("a wall is opaque on the two faces it faces and nothing on the others", "[approximation]") {
    for (int axis = 0; axis < 3; ++axis) {
        for (const std::uint32_t samples : {0u, 2u, 4u, 8u}) {
            for (const float looseness : {1.0f, 2.0f}) {
                const auto d = sampled({.samples = samples}, cube_cell(looseness), wall(axis, 1, {255, 102, 51, 255}));
                for (int side = 0; side < 6; ++side) {
                    INFO("axis " << axis << ", side " << side << ", samples " << samples);
                    CHECK(close(d[std::size_t(side)], side / 2 == axis ? glm::vec4(1, 0.4f, 0.2f, 1) : glm::vec4(0),
                                0.004f));
                }
            }
        }
    }
}

TEST_CASE("a face covered in part has that opacity", "[approximation]") {
    for (const std::uint32_t samples : {0u, 4u, 8u}) {
        for (const float part : {0.25f, 0.5f, 0.75f}) {
            const auto d = sampled({.samples = samples}, cube_cell(2), wall(0, part, {255, 255, 255, 255}));
            INFO(samples << " samples, " << part);
            CHECK(close(d[0], glm::vec4(part), 0.004f));
            CHECK(close(d[1], glm::vec4(part), 0.004f));
        }
    }
}

TEST_CASE("what sticks out of a loose cell counts, up to the whole face", "[approximation]") {
    const auto beside = [](float shift) {
        Triangles t = wall(0, 0.5f, {255, 255, 255, 255});
        return moved(t, 1, {0, shift, 0});
    };
    for (const std::uint32_t samples : {0u, 4u}) {
        for (const float shift : {-0.5f, 0.5f, 0.75f}) {
            const auto d = sampled({.samples = samples}, cube_cell(2), beside(shift));
            CHECK(close(d[0], glm::vec4(0.5f), 0.07f));
        }
        Triangles large = moved(wall(0, 1, {255, 255, 255, 255}), 1.9f);
        // A draft keeps what is beyond the face, for a neighbor lacks it; what is drawn ends at the face.
        const auto beyond = sampled({.samples = samples}, cube_cell(2), large);
        CHECK(beyond[0].a > 3);
        CHECK(ColorCube{}.finish(cube_cell(2), beyond)[0] == Rgba8{255, 255, 255, 255});
    }
}

TEST_CASE("sampled and analytic cubes agree where little overlaps", "[approximation]") {
    // Over many cells with a few small triangles each; samples are few and miss as often as they hit too much.
    glm::vec4 sum[2][6] = {};
    for (int round = 0; round < 5000; ++round) {
        const Triangles triangles = random_triangles(12, 20 + std::uint64_t(round), 0.12f);
        for (int k = 0; k < 2; ++k) {
            const auto d = sampled({.samples = k ? 8u : 0u}, cube_cell(2), triangles);
            for (std::size_t side = 0; side < 6; ++side) sum[k][side] += d[side];
        }
    }
    for (std::size_t side = 0; side < 6; ++side) {
        INFO("side " << side << ": analytic " << sum[0][side].a << ", sampled " << sum[1][side].a);
        CHECK(std::abs(sum[1][side].a / sum[0][side].a - 1) < 0.06f);
        CHECK(std::abs(sum[1][side].r / sum[0][side].r - 1) < 0.06f);
    }
}

TEST_CASE("what covers more than a face lets nothing through, and takes nothing away", "[approximation]") {
    // Loose contents side by side beyond the cell: an opacity above 1.
    const glm::vec4 front(0.9f, 0.6f, 0.3f, 1.5f), back(0.1f, 0.4f, 0.2f, 0.5f);
    for (const auto opacity : {ColorCube::Opacity::blended, ColorCube::Opacity::thresholded}) {
        const ColorCube cube{.opacity = opacity};
        for (unsigned side = 0; side < 6; ++side) {
            // Octant 0 or 7, and the one behind it along the side's axis.
            const unsigned front_octant = side & 1 ? 7 : 0, back_octant = front_octant ^ (1u << side / 2);
            ColorCube::stand_in_draft in_front{}, behind{}, own{};
            in_front[side] = front;
            behind[side] = back;
            const std::vector<ChildDraft<ColorCube::stand_in_draft>> children{{front_octant, nullptr, &in_front},
                                                                              {back_octant, nullptr, &behind}};
            cube.merge({}, own, children);
            CHECK(close(own[side], front * 0.25f, 1e-6f));
            // Own contents that cover more than the face hide all of it, and lie behind all of it, half and half.
            ColorCube::stand_in_draft loose{};
            loose[side] = front;
            cube.merge({}, loose, children);
            const glm::vec4 inside = front * 0.25f;
            const float seen =
                opacity == ColorCube::Opacity::blended ? 1 - inside.a : std::min((1 - inside.a) / front.a, 1.0f);
            CHECK(close(loose[side], 0.5f * (front + (inside + front * seen)), 1e-6f));
        }
    }
    // Coverages add up to 1 at most, and nothing counts more than once.
    const ColorCube cube{.opacity = ColorCube::Opacity::thresholded};
    for (const float a : {0.25f, 0.75f, 1.0f}) {
        ColorCube::stand_in_draft in_front{}, behind{}, own{};
        in_front[1] = glm::vec4(a);
        behind[1] = glm::vec4(0.5f);
        const std::vector<ChildDraft<ColorCube::stand_in_draft>> children{{7, nullptr, &in_front},
                                                                          {6, nullptr, &behind}};
        cube.merge({}, own, children);
        CHECK(own[1].a == Approx(0.25f * std::min(a + 0.5f, 1.0f)));
    }
}

TEST_CASE("an inner cube is front four over back four, then their mean", "[approximation]") {
    // By hand for the side that looks to +x: octants 1, 3, 5, 7 are in front, 0, 2, 4, 6 behind them.
    std::array<ColorCube::stand_in_draft, 8> octants{};
    const auto red = glm::vec4(0.5f, 0, 0, 0.5f), green = glm::vec4(0, 0.25f, 0, 0.25f), white = glm::vec4(1);
    octants[1][1] = red;
    octants[0][1] = white;
    octants[3][1] = green;
    octants[4][1] = green;
    // 1 over 0: (0.5, 0, 0, 0.5) + 0.5 white = (1, 0.5, 0.5, 1). 3 over 2: green. 5 over 4: green. 7 over 6: nothing.
    const glm::vec4 expected = (glm::vec4(1, 0.5f, 0.5f, 1) + green + green) * 0.25f;
    std::vector<ChildDraft<ColorCube::stand_in_draft>> children;
    const Cell cell = cube_cell();
    for (unsigned c : {0u, 1u, 3u, 4u}) children.push_back({c, &cell, &octants[c]});
    ColorCube::stand_in_draft own{};
    ColorCube{}.merge(cell, own, children);
    CHECK(close(own[1], expected, 1e-6f));
    CHECK(close(own[0], glm::vec4(0), 0));
    // Seen from -x the same colors would lie the other way around.
    std::array<ColorCube::stand_in_draft, 8> turned{};
    for (unsigned c = 0; c < 8; ++c) turned[c][0] = octants[c][1];
    children.clear();
    for (unsigned c : {0u, 1u, 3u, 4u}) children.push_back({c, &cell, &turned[c]});
    own = {};
    ColorCube{}.merge(cell, own, children);
    CHECK(close(own[0], (white + green + green) * 0.25f, 1e-6f));
}

TEST_CASE("eight opaque children make an opaque parent", "[approximation]") {
    for (const auto opacity : {ColorCube::Opacity::blended, ColorCube::Opacity::thresholded}) {
        ColorCube::stand_in_draft solid;
        solid.fill(glm::vec4(0.2f, 0.4f, 0.6f, 1));
        const Cell cell = cube_cell();
        std::vector<ChildDraft<ColorCube::stand_in_draft>> children;
        for (unsigned c = 0; c < 8; ++c) children.push_back({c, &cell, &solid});
        ColorCube::stand_in_draft own{};
        ColorCube{.opacity = opacity}.merge(cell, own, children);
        for (const glm::vec4& c : own) CHECK(close(c, solid[0], 1e-6f));
    }
}

TEST_CASE("cubes of 1995 add coverages of front and back and are opaque above the threshold", "[approximation]") {
    const ColorCube a{.opacity = ColorCube::Opacity::thresholded};
    ColorCube::stand_in_draft front{}, back{};
    front[1] = glm::vec4(0.4f, 0, 0, 0.4f);
    back[1] = glm::vec4(0, 0.4f, 0, 0.4f);
    const Cell cell = cube_cell();
    std::vector<ChildDraft<ColorCube::stand_in_draft>> children{{1, &cell, &front}, {0, &cell, &back}};
    ColorCube::stand_in_draft own{};
    a.merge(cell, own, children);
    CHECK(close(own[1], glm::vec4(0.1f, 0.1f, 0, 0.2f), 1e-6f));  // 0.4 + 0.4 on a quarter of the face
    // Never more than whole.
    front[1] = glm::vec4(0.8f, 0, 0, 0.8f);
    back[1] = glm::vec4(0, 0.8f, 0, 0.8f);
    own = {};
    a.merge(cell, own, children);
    CHECK(close(own[1], glm::vec4(0.2f, 0.05f, 0, 0.25f), 1e-6f));

    ColorCube::stand_in_draft d{};
    d[0] = glm::vec4(0.3f, 0.15f, 0, 0.6f);
    d[1] = glm::vec4(0.2f, 0.1f, 0, 0.4f);
    const auto data = a.finish(cell, d);
    CHECK(data[0] == Rgba8{128, 64, 0, 255});
    CHECK(data[1] == Rgba8{0, 0, 0, 0});
    CHECK(ColorCube{}.finish(cell, d)[1] == Rgba8{51, 26, 0, 102});
}

TEST_CASE("only faces that look at the viewer are drawn", "[approximation]") {
    ColorCube::stand_in_data data;
    data.fill({255, 255, 255, 255});
    Random random(21);
    for (int i = 0; i < 2000; ++i) {
        Cell cell = cube_cell();
        cell.center = random.in_cube(2);
        cell.half = glm::vec3(random.between(0.1f, 1));
        const glm::vec3 eye = random.in_cube(4);
        const View v = i % 3 ? looking(eye, random.in_cube(1)) : looking_orthographic(eye, random.in_cube(1));
        const LocalView view(v, {}, 5);
        std::vector<Face> faces;
        std::vector<Splat> splats;
        ColorCube{}.draw_stand_in(data, cell, view, Sink{0, &faces, &splats});
        std::size_t expected = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const float d = view.towards_viewer(cell.center)[axis];
            expected += std::abs(d) > (view.is_perspective ? cell.half[axis] : 0.0f);
        }
        CHECK(faces.size() == expected);
        CHECK(splats.empty());
        for (const Face& f : faces) {
            const int axis = f.side / 2;
            CHECK(f.lower[axis] == f.upper[axis]);
            CHECK(f.lower[axis] == cell.center[axis] + (f.side & 1 ? cell.half[axis] : -cell.half[axis]));
            const float towards = view.towards_viewer(f.lower)[axis];
            CHECK((f.side & 1 ? towards > 0 : towards < 0));
        }
    }
}

TEST_CASE("a small cube's splat has the area and the color of the faces that are seen", "[approximation]") {
    Random random(22);
    for (int i = 0; i < 1000; ++i) {
        Cell cell = cube_cell();
        cell.half = glm::vec3(0.01f);
        cell.center = random.in_cube(0.2f);
        ColorCube::stand_in_data data;
        const int alpha = 1 + int(random.below(255));
        for (Rgba8& c : data) c = {std::uint8_t(alpha), std::uint8_t(alpha / 2), 0, std::uint8_t(alpha)};
        const View v = i % 2 ? looking(random.direction() * 5.0f, {0, 0, 0}, 100)
                             : looking_orthographic(random.direction() * 5.0f, {0, 0, 0}, 3, 100);
        const LocalView view(v, {}, 5);
        std::vector<Face> faces;
        std::vector<Splat> splats;
        ColorCube{}.draw_stand_in(data, cell, view, Sink{2, &faces, &splats});
        REQUIRE(splats.size() == 1);
        CHECK(faces.empty());
        const glm::vec3 d = glm::normalize(view.towards_viewer(cell.center));
        const float area = 4 * cell.half.x * cell.half.x * (std::abs(d.x) + std::abs(d.y) + std::abs(d.z));
        // Faces seen under less than about the cell's own angle are left out.
        const float in_picture = area * view.stretch(cell.center);
        CHECK(splats[0].size.x == splats[0].size.y);
        CHECK(splats[0].size.x * splats[0].size.y <= in_picture * 1.00001f);
        CHECK(splats[0].size.x * splats[0].size.y >= in_picture * 0.99f);
        CHECK(splats[0].center == cell.center);
        CHECK(std::abs(splats[0].rgb.r - 255) <= 1);
        CHECK(std::abs(splats[0].rgb.g - 255.0 * (alpha / 2) / alpha) <= 1.5);
        const auto law = AreaLaw(splats[0].rgb.a);
        CHECK(law == law_of_opacity(float(alpha) / 255));
        CHECK(splats[0].opacity == Approx(alpha / 255.0).margin(1e-5));
    }
}

TEST_CASE("what a cube's faces say about its contents: a surface is one from whichever side it is seen",
          "[approximation]") {
    const ColorCube a{.guesses_area_law = true};
    CHECK(!ColorCube{}.area_law({}));
    const auto law = [&](const Triangles& triangles) {
        return a.area_law(a.finish(cube_cell(), sampled(a, cube_cell(), triangles)));
    };
    const Rgba8 white{255, 255, 255, 255}, half{0, 0, 0, 128}, none{0, 0, 0, 0};
    CHECK(law(sheet({-1, -1, 0.1f}, {2, 0, 0}, {0, 2, 0}, 8, 8, white)) == AreaLaw::coherent);
    CHECK(law(sheet({-1, -1, -1}, {2, 0, 2}, {0, 2, 0}, 8, 8, white)) == AreaLaw::coherent);
    CHECK(law(random_triangles(40, 25, 0.1f)) == AreaLaw::independent);
    CHECK(law({}) == AreaLaw::independent);
    CHECK(a.area_law({half, half, none, none, none, none}) == AreaLaw::mixed);
}

TEST_CASE("no mass is lost where primitives stick out of loose cells", "[approximation]") {
    // Few enough that hardly any hide behind another within a cell.
    Random random(23);
    const Triangles triangles = random_triangles(1500, 24, 0.02f);
    glm::dvec3 total(0);
    for (const Triangle& t : triangles) {
        total += 0.5 * glm::abs(glm::dvec3(glm::cross(t.vertices[1] - t.vertices[0], t.vertices[2] - t.vertices[0])));
    }
    using Cubes = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
    const Cubes h = build<Cubes>(triangles, {.partition = {.uniform_depth = 4}});
    for (const std::uint32_t samples : {0u, 8u}) {
        const ColorCube a{.samples = samples};
        glm::dvec3 sum(0);
        GridSampler sampler;
        struct Place {
            std::uint32_t node;
            Cell cell;
            std::uint32_t end;
        };
        std::vector<Place> stack{{0, h.root_cell(), h.item_count()}};
        while (!stack.empty()) {
            const Place at = stack.back();
            stack.pop_back();
            const Node& node = h.nodes()[at.node];
            const std::uint32_t own_end = node.child_mask ? h.nodes()[node.first_child].first_item : at.end;
            const auto d = a.sample(
                at.cell,
                [&](auto&& sink) {
                    for (std::uint32_t i = node.first_item; i < own_end; ++i) triangles[h.order()[i]].polygons(sink);
                },
                sampler);
            for (int axis = 0; axis < 3; ++axis) {
                sum[axis] += double(d[std::size_t(2 * axis)].a) * 4 * double(at.cell.half.x) * double(at.cell.half.x);
            }
            std::uint32_t rank = 0;
            const auto children = std::uint32_t(std::popcount(node.child_mask));
            for (unsigned c = 0; c < 8; ++c) {
                if ((node.child_mask >> c & 1) == 0) continue;
                const std::uint32_t child = node.first_child + rank++;
                stack.push_back({child, Octree{}.child(at.cell, {}, c),
                                 rank < children ? h.nodes()[child + 1].first_item : at.end});
            }
        }
        for (int axis = 0; axis < 3; ++axis) {
            INFO(samples << " samples, axis " << axis << ": " << sum[axis] << " of " << total[axis]);
            CHECK(std::abs(sum[axis] / total[axis] - 1) < (samples ? 0.05 : 0.01));
        }
    }
}

TEST_CASE("cubes made directly and composited agree on a wall", "[approximation]") {
    using Cubes = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
    const Triangles triangles = sheet({-1, -1, 0.13f}, {2, 0, 0}, {0, 2, 0}, 40, 40, {200, 100, 50, 255});
    const Cubes composited = build<Cubes>(triangles),
                direct = build<Cubes>(triangles, {.approximation = {.inner = ColorCube::Inner::direct}});
    REQUIRE(composited.root_stand_in());
    REQUIRE(direct.root_stand_in());
    for (std::size_t side = 0; side < 6; ++side) {
        const Rgba8 a = (*composited.root_stand_in())[side], b = (*direct.root_stand_in())[side];
        INFO("side " << side << ": " << int(a.a) << " and " << int(b.a));
        CHECK(std::abs(a.a - b.a) <= 12);
        CHECK(std::abs(a.r - b.r) <= 12);
        if (side >= 4) CHECK(b.a >= 250);
    }
}

TEST_CASE("the error is the cell's side on the screen, infinite where the eye is", "[approximation]") {
    const Cell cell = cube_cell();
    const View v = looking({0, 0, 11}, {0, 0, 0}, 200);
    const LocalView view(v, {}, 5);
    CHECK(ColorCube{}.error_px({}, cell, view) == Approx(2 * view.focal_px / 10));
    const LocalView inside(looking({0.5, 0, 0.2}, {0, 0, 0}, 200), {}, 5);
    CHECK(std::isinf(ColorCube{}.error_px({}, cell, inside)));
    const LocalView on_corner(looking({1, 1, 1}, {0, 0, 0}, 200), {}, 5);
    CHECK(std::isinf(ColorCube{}.error_px({}, cell, on_corner)));
    const LocalView parallel(looking_orthographic({0.5, 0, 0.2}, {0, 0, 0}, 4, 200), {}, 5);
    CHECK(ColorCube{}.error_px({}, cell, parallel) == Approx(100));
}
