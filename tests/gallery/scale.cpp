// The gallery larger, smaller and elsewhere gives the same cut.
#include <cmath>
#include <cstring>
#include <tuple>
#include <utility>

#include "catch.hpp"
#include "farfield/build.hpp"
#include "farfield/viewer.hpp"
#include "gallery/subjects.hpp"
#include "support/scenes.hpp"
#include "support/triples.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

bool same(const FrameStats& a, const FrameStats& b) {
    return std::memcmp(&a, &b, sizeof a) == 0;
}

/// By three in a hundred, or, of few, by what one cell has or has not below it.
bool equal_up_to_ties(std::uint64_t a, std::uint64_t b) {
    return std::abs(double(a) - double(b)) <= std::max(8.0, 0.03 * double(b));
}

View placed(View view, double scale, glm::dvec3 offset) {
    view.camera.eye = view.camera.eye * scale + offset;
    if (view.camera.projection == Projection::orthographic) view.camera.half_height *= float(scale);
    return view;
}

std::vector<View> views_of(const Subject& s, float tolerance) {
    return {s.view(2.5, 64, tolerance), s.view(12, 64, tolerance), s.orthographic_view(64, tolerance)};
}

/// In double precision.
struct WideTriangle {
    std::array<glm::dvec3, 3> vertices;
    Rgba8 rgba;

    BoxD bounds() const {
        return {glm::min(vertices[0], glm::min(vertices[1], vertices[2])),
                glm::max(vertices[0], glm::max(vertices[1], vertices[2]))};
    }
    template <class Sink>
    void polygons(Sink&& sink) const {
        sink(PolygonD{vertices, {&rgba, 1}});
    }
};

/// On multiples of 2^-20, so that moving them rounds nothing.
std::vector<WideTriangle> widened(const std::vector<Triangle>& triangles, glm::dvec3 offset) {
    std::vector<WideTriangle> out;
    for (const Triangle& t : triangles) {
        const auto snapped = [&](glm::vec3 v) { return glm::round(glm::dvec3(v) * 0x1p20) * 0x1p-20 + offset; };
        out.push_back({{snapped(t.vertices[0]), snapped(t.vertices[1]), snapped(t.vertices[2])}, t.rgba});
    }
    return out;
}

/// One hierarchy for each approximation.
using HierarchiesByApproximation =
    decltype(hierarchies_of(variants_of(std::declval<std::tuple<Named<Octree>>>(), std::declval<Approximations>(),
                                        std::declval<std::tuple<Named<TriangleCount>>>())));

}  // namespace

TEST_CASE("gallery: scaled by a power of two it gives exactly the same cut and picture") {
    for (const Subject& subject : subjects(2000, {0.0f, 0.5f, 1.0f})) {
        for (const test::Variant& variant : gallery_variants()) {
            const auto h = variant.build(subject.triangles);
            for (const int exponent : {-20, 23}) {
                const float scale = std::ldexp(1.0f, exponent);
                const auto triangles = moved(subject.triangles, scale);
                const auto other = variant.build(triangles);
                INFO(subject.name << ": " << variant.name << ", 2^" << exponent);
                CHECK(other->bytes() == h->bytes());
                for (const float tolerance : {1.0f, 4.0f}) {
                    for (const View& view : views_of(subject, tolerance)) {
                        ZBufferRenderer a, b;
                        CHECK(same(h->viewer(a)->arrive(view),
                                   other->viewer(b)->arrive(placed(view, double(scale), {}))));
                        CHECK(a.image() == b.image());
                    }
                }
            }
        }
    }
}

// Ties are triangles whose bounds touch a cell's border in exact arithmetic; rounding sends them either way. A blind
// and a wall that is symmetric about the middle of its root cell have whole rows of them. So walls are seen at
// severities where no edge is parallel to an axis plane but those that are level, and get a peg that moves the middle
// away.
TEST_CASE("gallery: scaled by anything and moved it gives the same cut up to ties") {
    struct Place {
        double scale;
        glm::dvec3 offset;
    };
    for (const Subject& subject : subjects(2000, {0.35f, 0.75f})) {
        if (subject.name.rfind("slats", 0) == 0) continue;
        std::vector<Triangle> original = subject.triangles;
        original.push_back(
            {{{{1.21f, 1.33f, 1.27f}, {1.23f, 1.31f, 1.26f}, {1.22f, 1.37f, 1.24f}}}, {90, 60, 40, 255}});
        for (const test::Variant& variant : gallery_variants()) {
            // Planes that cost the same are ties too, and all that is below one of them is cut otherwise.
            if (!has_cubes(variant) || is_known_to_tie(variant, subject)) continue;
            const auto h = variant.build(original);
            for (const Place& place :
                 {Place{1e-4, {}}, Place{1e4, {}}, Place{1e4, {7e4, -3e4, 1e4}}, Place{1e-4, {5e-4, 1e-4, -2e-4}}}) {
                const auto triangles = moved(original, float(place.scale), glm::vec3(place.offset));
                const auto other = variant.build(triangles);
                INFO(subject.name << ": " << variant.name << ", scaled by " << place.scale << " and moved by "
                                  << place.offset.x);
                INFO(other->nodes().size() << " nodes and " << h->nodes().size());
                CHECK(equal_up_to_ties(other->nodes().size(), h->nodes().size()));
                for (const float tolerance : {0.0f, 1.0f, 4.0f}) {
                    for (const View& view : views_of(subject, tolerance)) {
                        INFO("tolerance " << tolerance << ", from " << glm::length(view.camera.eye));
                        Recorder here, there;
                        const FrameStats x = h->frame(view, here);
                        const FrameStats y = other->frame(placed(view, place.scale, place.offset), there);
                        CHECK(equal_up_to_ties(y.primitives, x.primitives));
                        CHECK(equal_up_to_ties(y.approximations, x.approximations));
                        CHECK(equal_up_to_ties(y.cells_visited, x.cells_visited));
                    }
                }
            }
        }
    }
}

TEMPLATE_LIST_TEST_CASE("gallery: in double precision ten thousand kilometers away it looks as it does at the origin",
                        "", HierarchiesByApproximation) {
    for (const Subject& subject : subjects(2000, {0.6f})) {
        const auto here = widened(subject.triangles, {});
        const auto h = build<TestType>(here);
        ZBufferRenderer a;
        auto near = make_viewer(h, here, a);
        for (const glm::dvec3 offset : {glm::dvec3(1e7, 1e7, 1e7), glm::dvec3(-1e7, 6.4e6, 12.5)}) {
            const auto there = widened(subject.triangles, offset);
            const auto other = build<TestType>(there);
            REQUIRE(other.nodes().size() == h.nodes().size());
            ZBufferRenderer b;
            auto far = make_viewer(other, there, b);
            for (const float tolerance : {0.0f, 1.0f, 4.0f}) {
                for (View view : views_of(subject, tolerance)) {
                    INFO(subject.name << ", tolerance " << tolerance);
                    // Of an eye far away only such places can be told apart.
                    view.camera.eye = glm::round(view.camera.eye * 0x1p20) * 0x1p-20;
                    CHECK(same(near.frame(view), far.frame(placed(view, 1, offset))));
                    CHECK(a.image() == b.image());
                }
            }
        }
    }
}
