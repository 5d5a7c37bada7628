#include "farfield/primitive.hpp"

#include <array>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/instance.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/spatial_hierarchy.hpp"
#include "farfield/viewer.hpp"
#include "support/pictures.hpp"
#include "support/recorder.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

struct BoundsOnly {
    Box box;
    Box bounds() const { return box; }
};
struct DoubleBounds {
    BoxD bounds() const { return {}; }
};
struct MisspeltBounds {
    Box bound() const { return {}; }
};
struct WrongBounds {
    glm::vec3 bounds() const { return {}; }
};
struct BoundsOfMutable {
    Box bounds() { return {}; }
};
struct MisspeltPolygons : BoundsOnly {
    template <class Sink>
    void polygon(Sink&&) const {}
};
struct WithWork : BoundsOnly {
    Work work() const { return {.triangles = 7}; }
};
struct WithWrongWork : BoundsOnly {
    float work() const { return 7; }
};
struct WithColor : BoundsOnly {
    glm::vec4 color() const { return {}; }
};
struct WithWrongColor : BoundsOnly {
    const char* color() const { return "red"; }
};
/// A type that cannot have members.
enum class Tile : int {};

}  // namespace

template <>
struct farfield::primitive_traits<Tile> {
    static Box bounds(Tile t) { return {{float(int(t)), 0, 0}, {float(int(t)) + 1, 1, 0}}; }
    template <class Sink>
    static void polygons(Tile t, Sink&& sink) {
        const float x = float(int(t));
        const std::array<glm::vec3, 4> corners{glm::vec3(x, 0, 0), {x + 1, 0, 0}, {x + 1, 1, 0}, {x, 1, 0}};
        const Rgba8 color{std::uint8_t(50 * int(t)), 100, 0, 255};
        sink(Polygon{corners, {&color, 1}});
    }
    static Work work(Tile) { return {.triangles = 2}; }
};

static_assert(Primitive<Triangle> && PrimitiveWithPolygons<Triangle> && PrimitiveWithColor<Triangle>);
static_assert(!PrimitiveWithWork<Triangle> && !PrimitiveWithInstance<Triangle>);
static_assert(Primitive<VertexColoredTriangle> && PrimitiveWithPolygons<VertexColoredTriangle>);
static_assert(Primitive<BoundsOnly> && !PrimitiveWithPolygons<BoundsOnly> && !PrimitiveWithColor<BoundsOnly>);
static_assert(Primitive<DoubleBounds> && has_double_bounds<DoubleBounds> && !has_double_bounds<BoundsOnly>);
static_assert(!Primitive<MisspeltBounds> && !Primitive<WrongBounds> && !Primitive<BoundsOfMutable> && !Primitive<int>);
static_assert(Primitive<MisspeltPolygons> && !PrimitiveWithPolygons<MisspeltPolygons>);
static_assert(PrimitiveWithWork<WithWork> && !PrimitiveWithWork<BoundsOnly>);
static_assert(PrimitiveWithColor<WithColor> && !PrimitiveWithColor<BoundsOnly>);
static_assert(Primitive<Tile> && PrimitiveWithPolygons<Tile> && PrimitiveWithWork<Tile> && !PrimitiveWithColor<Tile>);

using ExactHierarchy = SpatialHierarchy<Octree, Exact, TriangleCount>;
using Cubes = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
static_assert(PrimitiveWithInstance<Instance<Cubes, Triangle>> && PrimitiveWithPolygons<Instance<Cubes, Triangle>>);
static_assert(has_double_bounds<Instance<Cubes, Triangle>>);

static_assert(BuildableFrom<ExactHierarchy, BoundsOnly>, "exact needs nothing but bounds");
static_assert(!BuildableFrom<Cubes, BoundsOnly>, "color cubes need polygons");
static_assert(!BuildableFrom<Cubes, MisspeltPolygons> && BuildableFrom<ExactHierarchy, MisspeltPolygons>);
static_assert(BuildableFrom<Cubes, Triangle> && BuildableFrom<Cubes, Tile>);
static_assert(!BuildableFrom<ExactHierarchy, MisspeltBounds>);

TEST_CASE("a type of one's own is drawn by its traits") {
    std::vector<Tile> tiles;
    for (int i = 0; i < 5; ++i) tiles.push_back(Tile(i));
    const Cubes h = build<Cubes>(tiles);
    CHECK(h.whole_work().triangles == 10);
    const View view = looking_orthographic({2.5, 0.5, 3}, {2.5, 0.5, 0}, 5, 50);
    ZBufferRenderer renderer;
    make_viewer(h, tiles, renderer).frame(view);
    CHECK(renderer.image() == plain_picture<Tile>(tiles, view));
    CHECK(renderer.image().at(25, 25) == Rgba8{100, 100, 0, 255});
    CHECK(coverage(renderer.image()) == 500);
}

TEST_CASE("a type with bounds alone can be culled and handed over") {
    std::vector<BoundsOnly> boxes;
    for (int i = 0; i < 1000; ++i) boxes.push_back({{{float(i), 0, 0}, {float(i) + 0.5f, 1, 1}}});
    const ExactHierarchy h = build<ExactHierarchy>(boxes);
    Recorder recorder;
    View view = looking_orthographic({500, 0.5, 3}, {500, 0.5, 0}, 100, 100);
    const FrameStats stats = make_viewer(h, boxes, recorder).frame(view);
    CHECK(stats.primitives >= 100);
    CHECK(stats.primitives < 500);
}

TEST_CASE("work and color of another type are not taken for work and color") {
    // Not a static_assert: what the concept says must be what happens in the body, not an error inside of the library.
    CHECK_FALSE(PrimitiveWithWork<WithWrongWork>);
    CHECK_FALSE(PrimitiveWithColor<WithWrongColor>);
}

TEST_CASE("work is what the type says, else one triangle") {
    CHECK(work_of(WithWork{}).triangles == 7);
    CHECK(work_of(BoundsOnly{}).triangles == 1);
    CHECK(work_of(Tile(0)).triangles == 2);
}

TEST_CASE("boxes that are empty, or not finite, are refused whatever brings them") {
    const float infinity = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
    for (const Box& bad :
         {Box::empty(), Box{{0, 1, 0}, {1, 0, 1}}, Box{{0, 0, 0}, {1, infinity, 1}}, Box{{-infinity, 0, 0}, {1, 1, 1}},
          Box{{nan, 0, 0}, {1, 1, 1}}, Box{{0, 0, 0}, {1, 1, nan}}}) {
        std::vector<BoundsOnly> boxes(10, BoundsOnly{{{0, 0, 0}, {1, 1, 1}}});
        boxes[7].box = bad;
        try {
            build<ExactHierarchy>(boxes);
            FAIL_CHECK("was not refused");
        } catch (const std::invalid_argument& e) {
            CHECK(std::string(e.what()).find("primitive 7 ") != std::string::npos);
        }
    }
}

TEST_CASE("work that is no number is refused") {
    struct Odd : BoundsOnly {
        float triangles = 1;
        Work work() const { return {.triangles = triangles}; }
    };
    for (const float bad : {-1.0f, std::numeric_limits<float>::quiet_NaN()}) {
        std::vector<Odd> boxes(10);
        for (Odd& b : boxes) b.box = {{0, 0, 0}, {1, 1, 1}};
        boxes[3].triangles = bad;
        CHECK_THROWS_AS(build<ExactHierarchy>(boxes), std::invalid_argument);
    }
}

namespace {

struct Many {
    std::vector<glm::dvec3> rim;
    std::vector<Rgba8> colors;
    BoxD bounds() const {
        BoxD b = BoxD::empty();
        for (const glm::dvec3& v : rim) b.add(v);
        return b;
    }
    template <class Sink>
    void polygons(Sink&& sink) const {
        sink(PolygonD{rim, colors});
    }
};

}  // namespace

TEST_CASE("polygons of any number of corners arrive whole, less the origin") {
    for (const std::size_t n : {3u, 4u, 63u, 64u, 65u, 66u, 127u, 128u, 1000u}) {
        for (const bool one_color : {true, false}) {
            Many many;
            for (std::size_t i = 0; i < n; ++i) {
                const double a = 6.283185307179586 * double(i) / double(n);
                many.rim.push_back({5 + std::cos(a), 7 + std::sin(a), 0});
                if (!one_color || i == 0) many.colors.push_back({std::uint8_t(i), std::uint8_t(i >> 8), 0, 255});
            }
            double area = 0;
            std::size_t wrong_colors = 0, too_many = 0;
            local_polygons(many, {5, 7, 0}, [&](const Polygon& p) {
                for (std::size_t i = 2; i < p.vertices.size(); ++i) {
                    area +=
                        0.5 * double(glm::cross(p.vertices[i - 1] - p.vertices[0], p.vertices[i] - p.vertices[0]).z);
                }
                too_many += p.vertices.size() > 64;
                wrong_colors += p.colors.size() != (one_color ? 1 : p.vertices.size());
                for (std::size_t i = 0; i < p.colors.size() && !one_color; ++i) {
                    // The color names the corner.
                    const std::size_t corner = p.colors[i].r + 256u * p.colors[i].g;
                    wrong_colors +=
                        glm::length(glm::dvec3(p.vertices[i]) - (many.rim[corner] - glm::dvec3(5, 7, 0))) > 1e-6;
                }
            });
            INFO(n << " corners");
            CHECK(std::abs(area - 0.5 * double(n) * std::sin(6.283185307179586 / double(n))) < 1e-4);
            CHECK(wrong_colors == 0);
            CHECK(too_many == 0);
        }
    }
}

TEST_CASE("what is no polygon is dropped") {
    Many many;
    int count = 0;
    const auto sink = [&](const Polygon&) { ++count; };
    many.rim = {{0, 0, 0}, {1, 0, 0}};
    many.colors = {{1, 2, 3, 255}};
    local_polygons(many, {0, 0, 0}, sink);
    local_polygons(many, {1, 0, 0}, sink);
    many.rim.push_back({0, 1, 0});
    many.colors.clear();
    local_polygons(many, {0, 0, 0}, sink);
    CHECK(count == 0);
}
