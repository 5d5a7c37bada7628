// The same scene larger, smaller or elsewhere gives the same cut and the same picture.
#include <cmath>
#include <cstring>
#include <vector>

#include "catch.hpp"
#include "farfield/build.hpp"
#include "farfield/viewer.hpp"
#include "support/pictures.hpp"
#include "support/scenes.hpp"
#include "support/triples.hpp"
#include "support/variants.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

std::vector<View> views_at(double scale, glm::dvec3 offset, float tolerance) {
    const auto at = [&](double x, double y, double z) { return glm::dvec3(x, y, z) * scale + offset; };
    std::vector<View> views{looking(at(6, 2, 4), at(0, 0, 0), 96, tolerance),
                            looking(at(0.25, 0.125, 0.0625), at(1.25, 0.125, 0.5), 96, tolerance),
                            looking(at(1, 9, 0), at(1, 0, 0.5), 96, tolerance),
                            looking_orthographic(at(3, 4, 5), at(0, 0, 0), float(3 * scale), 96, tolerance)};
    views[2].distance = DistanceMeasure::depth;
    return views;
}

bool same_counts(const FrameStats& a, const FrameStats& b) {
    return std::memcmp(&a, &b, sizeof a) == 0;
}

double about(std::uint64_t a, std::uint64_t b) {
    return std::abs(double(a) - double(b)) / double(std::max<std::uint64_t>(b, 20));
}

/// A triangle with coordinates in double precision.
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

std::vector<WideTriangle> widened(const Triangles& triangles, glm::dvec3 offset) {
    std::vector<WideTriangle> out;
    for (const Triangle& t : triangles) {
        // Multiples of 2^-20, so that moving them rounds nothing.
        const auto snapped = [&](glm::vec3 v) { return glm::round(glm::dvec3(v) * 0x1p20) * 0x1p-20 + offset; };
        out.push_back({{snapped(t.vertices[0]), snapped(t.vertices[1]), snapped(t.vertices[2])}, t.rgba});
    }
    return out;
}

template <class A>
using WithPartitions =
    std::tuple<SpatialHierarchy<Octree, A, TriangleCount>, SpatialHierarchy<SharedOctree, A, TriangleCount>>;
using HierarchiesOfPrimitives = decltype(std::tuple_cat(WithPartitions<Exact>{}, WithPartitions<ColorCube>{},
                                                        WithPartitions<ColorCubeCluster<2>>{}));

}  // namespace

TEST_CASE("a scene scaled by a power of two gives exactly the same cut and picture") {
    const Triangles triangles = mixed_triangles(4000, 130);
    for (const Variant& variant : all_variants()) {
        const auto h = variant.build(triangles);
        for (const int exponent : {-13, 14, -40, 40}) {
            const float scale = std::ldexp(1.0f, exponent);
            const Triangles scaled_triangles = moved(triangles, scale);
            const auto other = variant.build(scaled_triangles);
            CHECK(other->nodes().size() == h->nodes().size());
            CHECK(other->bytes() == h->bytes());
            for (const float tolerance : {0.0f, 1.0f, 4.0f}) {
                const auto here = views_at(1, {}, tolerance), there = views_at(double(scale), {}, tolerance);
                for (std::size_t i = 0; i < here.size(); ++i) {
                    INFO(variant.name << ", 2^" << exponent << ", tolerance " << tolerance << ", view " << i);
                    ZBufferRenderer a, b;
                    CHECK(same_counts(h->viewer(a)->frame(here[i]), other->viewer(b)->frame(there[i])));
                    CHECK(a.image() == b.image());
                }
            }
        }
    }
}

TEST_CASE("a scene scaled by anything, or moved, gives the same cut up to ties") {
    const Triangles triangles = mixed_triangles(4000, 131);
    struct Place {
        double scale;
        glm::dvec3 offset;
    };
    for (const Variant& variant : all_variants()) {
        const auto h = variant.build(triangles);
        for (const Place& place : {Place{1e-4, {}}, Place{1e4, {}}, Place{1, {100, -50, 30}},
                                   Place{1e4, {3e5, 0, -7e5}}, Place{1e-4, {2e-3, 1e-2, 0}}}) {
            const auto other_triangles = moved(triangles, float(place.scale), glm::vec3(place.offset));
            const auto other = variant.build(other_triangles);
            INFO(variant.name << ", scaled by " << place.scale << " and moved by " << place.offset.x);
            CHECK(about(other->nodes().size(), h->nodes().size()) < 0.02);
            FrameStats all_here, all_there;
            for (const float tolerance : {0.0f, 1.0f, 4.0f}) {
                const auto here = views_at(1, {}, tolerance), there = views_at(place.scale, place.offset, tolerance);
                for (std::size_t i = 0; i < here.size(); ++i) {
                    INFO("tolerance " << tolerance << ", view " << i);
                    ZBufferRenderer a, b;
                    const FrameStats x = h->viewer(a)->frame(here[i]), y = other->viewer(b)->frame(there[i]);
                    all_here.primitives += x.primitives;
                    all_there.primitives += y.primitives;
                    all_here.approximations += x.approximations;
                    all_there.approximations += y.approximations;
                    all_here.cells_visited += x.cells_visited;
                    all_there.cells_visited += y.cells_visited;
                    if (variant.is_clipped) continue;
                    CHECK(about(y.primitives, x.primitives) < 0.03);
                    CHECK(about(y.approximations, x.approximations) < 0.03);
                    CHECK(about(y.cells_visited, x.cells_visited) < 0.03);
                }
            }
            // Planes that cost the same are ties as well. Where another one is chosen all below it is cut otherwise, so
            // that which cells a view meets is chance; how many there are altogether is not.
            CHECK(about(all_there.primitives, all_here.primitives) < (variant.is_clipped ? 0.05 : 0.03));
            CHECK(about(all_there.cells_visited, all_here.cells_visited) < (variant.is_clipped ? 0.1 : 0.03));
            if (variant.is_clipped) {  // 15 %, or, of few, five
                const double here = double(all_here.approximations), there = double(all_there.approximations);
                CHECK(std::abs(there - here) <= std::max(0.15 * here, 5.0));
            }
        }
    }
}

TEMPLATE_LIST_TEST_CASE("a double-precision scene ten thousand kilometers away looks as it does at the origin", "",
                        HierarchiesOfPrimitives) {
    const Triangles triangles = mixed_triangles(3000, 132);
    const auto here = widened(triangles, {});
    const auto h = build<TestType>(here);
    for (const glm::dvec3 offset : {glm::dvec3(1e7, 1e7, 1e7), glm::dvec3(-1e7, 6.4e6, 12.5)}) {
        const auto there = widened(triangles, offset);
        const auto other = build<TestType>(there);
        REQUIRE(other.nodes().size() == h.nodes().size());
        ZBufferRenderer a, b;
        auto near = make_viewer(h, here, a);
        auto far = make_viewer(other, there, b);
        for (const float tolerance : {0.0f, 2.0f}) {
            const auto views = views_at(1, {}, tolerance), moved_views = views_at(1, offset, tolerance);
            for (std::size_t i = 0; i < views.size(); ++i) {
                INFO("tolerance " << tolerance << ", view " << i);
                View same = moved_views[i];
                // Directions from far away are rounded in the last bit; what is tested is the place.
                same.camera.right = views[i].camera.right;
                same.camera.up = views[i].camera.up;
                same.camera.forward = views[i].camera.forward;
                const FrameStats x = near.frame(views[i]), y = far.frame(same);
                CHECK(same_counts(x, y));
                CHECK(a.image() == b.image());
                if (tolerance == 0) CHECK(a.image() == plain_picture<WideTriangle>(here, views[i]));
            }
        }
    }
}
