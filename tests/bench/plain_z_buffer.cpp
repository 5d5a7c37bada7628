// The yardstick draws what the library's z-buffer draws: speeds of two different pictures would mean nothing.
#define FARFIELD_PLAIN_Z_BUFFER plain_z_buffer_under_test
#include "../../bench/peers/plain_z_buffer.cpp"

#include <glm/vec3.hpp>

#include "catch.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::bench;
using test::Random;

namespace {

View view_along_z(glm::dvec3 eye, int size) {
    return {.camera = Camera::perspective(eye, eye - glm::dvec3(0, 0, 1), {0, 1, 0}, 1.0f),
            .width = size,
            .height = size,
            .tolerance_px = 0};
}

std::vector<PlainTriangle> packed(const std::vector<Triangle>& triangles) {
    std::vector<PlainTriangle> result;
    for (const Triangle& t : triangles) {
        PlainTriangle plain{{}, t.rgba};
        for (int c = 0; c < 3; ++c) {
            for (int axis = 0; axis < 3; ++axis) plain.vertices[c][axis] = t.vertices[std::size_t(c)][axis];
        }
        result.push_back(plain);
    }
    return result;
}

Image drawn_by_peer(PlainZBuffer& peer, const std::vector<Triangle>& triangles, const View& view) {
    Box bounds = Box::empty();
    for (const Triangle& t : triangles) bounds.add(t.bounds());
    peer.begin_frame(LocalView(view, glm::dvec3(0), bounds));
    peer.draw(packed(triangles));
    peer.end_frame();
    return peer.image();
}

Image drawn_by_library(const std::vector<Triangle>& triangles, const View& view, int samples) {
    const auto hierarchy = build<SpatialHierarchy<Octree, Exact, TriangleCount>>(triangles);
    ZBufferRenderer renderer(ZBufferOptions{.samples = samples});
    make_viewer(hierarchy, triangles, renderer).frame(view);
    return renderer.image();
}

std::size_t pixels_apart(const Image& a, const Image& b) {
    std::size_t apart = 0;
    for (std::size_t i = 0; i < a.pixels().size(); ++i) apart += a.pixels()[i] != b.pixels()[i];
    return apart;
}

}  // namespace

TEST_CASE("the peer and the z-buffer draw one picture, but for the rounding of single samples") {
    Random random(7);
    std::vector<Triangle> triangles;
    for (int i = 0; i < 3000; ++i) {
        // From specks to what is larger than the picture and reaches behind the eye.
        const float size = std::exp(random.between(-5, 2));
        const glm::vec3 center = random.in_cube(6);
        Triangle t;
        for (glm::vec3& v : t.vertices) v = center + random.in_cube(size);
        t.rgba = random.color();
        triangles.push_back(t);
    }
    for (const int a_side : {1, 8}) {
        const auto peer = plain_z_buffer_under_test(a_side);
        for (const View& view : {view_along_z({0, 0, 9}, 200), view_along_z({0.5, 0.25, 1}, 200)}) {
            const Image ours = drawn_by_library(triangles, view, a_side * a_side);
            CHECK(pixels_apart(drawn_by_peer(*peer, triangles, view), ours) <=
                  ours.pixels().size() / 500 * std::size_t(a_side));
        }
    }
}

TEST_CASE("the peer covers exactly the samples that an edge leaves, and draws both sides") {
    // A square whose right edge runs through the middle of the picture, from both sides.
    const Rgba8 red{255, 0, 0, 255};
    std::vector<Triangle> square{{{{{-50, -50, -1}, {0, -50, -1}, {0, 50, -1}}}, red},
                                 {{{{-50, -50, -1}, {-50, 50, -1}, {0, 50, -1}}}, red}};
    for (const int a_side : {1, 8}) {
        const auto peer = plain_z_buffer_under_test(a_side);
        const Image image = drawn_by_peer(*peer, square, view_along_z({0, 0, 0}, 16));
        for (int y = 0; y < 16; ++y) {
            for (int x = 0; x < 16; ++x) CHECK(image.at(x, y) == (x < 8 ? red : Rgba8{0, 0, 0, 0}));
        }
    }
}

TEST_CASE("nothing of one frame of the peer is left in the next, of whatever size") {
    const std::vector<Triangle> triangle{{{{{-1, -1, -2}, {1, -1, -2}, {0, 1, -2}}}, {10, 20, 30, 255}}};
    const std::vector<Triangle> farther{{{{{-1, -1, -3}, {1, -1, -3}, {0, 1, -3}}}, {200, 100, 50, 255}}};
    for (const int a_side : {1, 8}) {
        const auto peer = plain_z_buffer_under_test(a_side), other = plain_z_buffer_under_test(a_side);
        const View view = view_along_z({0, 0, 0}, 32);
        drawn_by_peer(*peer, triangle, view);
        CHECK(drawn_by_peer(*peer, farther, view) == drawn_by_peer(*other, farther, view));
        CHECK(drawn_by_peer(*peer, {}, view) == Image(32, 32));
        CHECK(drawn_by_peer(*peer, triangle, view_along_z({0, 0, 0}, 48)) ==
              drawn_by_peer(*other, triangle, view_along_z({0, 0, 0}, 48)));
    }
}
