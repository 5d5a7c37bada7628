// Several cubes at once give the splats that each gives alone, bit by bit.
#include "farfield/approximation/color_cube/cube_lanes.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/renderer/coverage_renderer.hpp"
#include "farfield/renderer/hierarchical_z_renderer.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/spatial_hierarchy.hpp"
#include "farfield/viewer.hpp"
#include "support/pictures.hpp"
#include "support/placed.hpp"
#include "support/random.hpp"
#include "support/scenes.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

using Cubes = std::vector<Placed<ColorCube>>;

/// Any colors, which a file may hold; every fourth face lets through, or is nothing.
ColorCube::stand_in_data random_cube(Random& random) {
    const auto byte = [&] { return std::uint8_t(random.below(256)); };
    ColorCube::stand_in_data cube;
    for (Rgba8& c : cube) c = {byte(), byte(), byte(), std::uint8_t(random.below(4) == 0 ? byte() : 255)};
    const bool is_sparse = random.below(2) == 0;
    for (Rgba8& c : cube) {
        if (is_sparse && random.below(2) == 0) c = {0, 0, 0, 0};
    }
    return cube;
}

bool widths_agree(const ColorCube& policy, const Cubes& all, const LocalView& view, const std::vector<Splat>& expected,
                  bool& was_refused) {
    const std::vector<std::uint32_t> words = words_of(policy, all);
    return test::widths_agree(detail::cube_kernels, all.size(), expected, was_refused,
                              [&](auto splats_of, std::size_t first, std::size_t n, PlacedSplats& out) {
                                  return splats_of(words.data() + first, n, view, out);
                              });
}

/// This one is drawn one by one.
struct OneByOne : ColorCube {
    template <class Sink>
    void draw_stand_in(const stand_in_data& data, const Cell& cell, const LocalView& view, Sink&& sink) const {
        ColorCube::draw_stand_in(data, cell, view, sink);
    }
};
static_assert(detail::DrawsPlaced<ColorCube> && !detail::DrawsPlaced<OneByOne>);
// Large ones are faces.
static_assert(!detail::DrawsLargePlaced<ColorCube>);

template <class A, class R>
Image picture(const Triangles& triangles, const View& view, FrameStats& stats) {
    const auto hierarchy = build<SpatialHierarchy<Octree, A, TriangleCount>>(triangles);
    R renderer;
    auto viewer = make_viewer(hierarchy, triangles, renderer);
    stats = viewer.frame(view);
    return renderer.image();
}

}  // namespace

TEST_CASE("cubes drawn together are those drawn one by one", "[approximation]") {
    Random random(140);
    const ColorCube policy;
    std::size_t drawn = 0, refused = 0;
    for (int round = 0; round < 600; ++round) {
        CAPTURE(round);
        const float size = round % 8 == 0 ? std::ldexp(1.0f, int(random.below(160)) - 80) : 1.0f;
        Cubes some(1 + random.below(round % 50 == 0 ? 255 : 20));
        for (auto& p : some) {
            p = {random_cube(random), random_cell(random, size)};
            if (round % 3 == 0) p.cell.half *= std::ldexp(1.0f, -int(random.below(40)));
            // Flat ones, rods and points.
            for (int axis = 0; axis < 3; ++axis) {
                if (round % 5 == 0 && random.below(3) == 0) p.cell.half[axis] = 0;
            }
        }
        // From between the axes, along one, and from among the cells.
        glm::dvec3 eye = glm::dvec3(random.in_cube(round % 4 == 0 ? 0.5f : 3.0f)) * double(size);
        if (round % 7 == 0) eye = glm::dvec3(0, round % 2 == 0 ? -3 : 3, 0) * double(size);
        const View view = round % 3 == 1 ? looking_orthographic(eye, {0, 0, 0}) : looking(eye, {0, 0, 0});
        const LocalView local(view, glm::dvec3(0), 4 * size);
        const float limit_px = round % 2 == 0 ? std::numeric_limits<float>::max() : 30.0f;
        Cubes all;
        std::vector<Splat> one_by_one, together;
        const SplatSink sink{one_by_one, limit_px};
        for (const auto& p : some) {
            const std::size_t before = one_by_one.size();
            if (policy.places(p.cell, local, limit_px)) all.push_back(p);
            policy.draw_stand_in(p.data, p.cell, local, sink);
            if (!policy.places(p.cell, local, limit_px)) CHECK(one_by_one.size() == before);
        }
        const std::vector<std::uint32_t> words = words_of(policy, all);
        policy.draw_placed(words.data(), all.size(), local, SplatSink{together});
        CHECK(are_same(together, one_by_one));
        bool was_refused = false;
        CHECK(widths_agree(policy, all, local, one_by_one, was_refused));
        // Only squares of lengths that leave single precision are, and points.
        if (was_refused) CHECK((size > 0x1p30f || size < 0x1p-20f || round % 5 == 0));
        drawn += one_by_one.size();
        refused += was_refused;
    }
    CHECK(drawn > 4000);
    CHECK(refused > 10);
}

TEST_CASE("a cube from each of the directions in which one, two or three faces are seen", "[approximation]") {
    Random random(3);
    const ColorCube policy;
    Cubes all(11);
    for (auto& p : all) {
        p.data = random_cube(random);
        p.cell.half = p.cell.bounds_half = glm::vec3(0.5f, 0.25f, 0.125f);
    }
    for (int i = 0; i < 27; ++i) {
        const glm::dvec3 direction(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
        if (i == 13) continue;
        for (const bool is_orthographic : {false, true}) {
            CAPTURE(i, is_orthographic);
            const glm::dvec3 eye = 5.0 * direction;
            const LocalView local(is_orthographic ? looking_orthographic(eye) : looking(eye), glm::dvec3(0), 2);
            const auto splats = splats_either_way(policy, all, local);
            REQUIRE(splats);
            bool was_refused = false;
            CHECK(widths_agree(policy, all, local, *splats, was_refused));
            CHECK(!was_refused);
        }
    }
}

TEMPLATE_TEST_CASE("a picture of cubes, large and small, is that of cubes drawn one by one", "[approximation]",
                   ZBufferRenderer, HierarchicalZRenderer, CoverageRenderer) {
    Random random(17);
    Triangles triangles;
    while (triangles.size() < 20000) {
        const glm::vec3 a = random.in_cube(1);
        triangles.push_back({{a, a + random.in_cube(0.06f), a + random.in_cube(0.06f)},
                             {std::uint8_t(random.below(256)), 120, 40, std::uint8_t(255)}});
    }
    std::uint64_t splats = 0, faces = 0;
    for (const bool is_orthographic : {false, true}) {
        for (const float tolerance : {0.7f, 2.0f, 4.0f}) {
            CAPTURE(is_orthographic, tolerance);
            const glm::dvec3 eye(8, 12, 16);
            const View view = is_orthographic ? looking_orthographic(eye, {0, 0, 0}, 10.0f, 128, tolerance)
                                              : looking(eye, {0, 0, 0}, 128, tolerance);
            FrameStats together, one_by_one;
            const Image a = picture<ColorCube, TestType>(triangles, view, together);
            const Image b = picture<OneByOne, TestType>(triangles, view, one_by_one);
            CHECK(a == b);
            CHECK(together.splats == one_by_one.splats);
            CHECK(together.faces == one_by_one.faces);
            splats += together.splats;
            faces += together.faces;
        }
    }
    CHECK(splats > 400);
    CHECK(faces > 100);
}
