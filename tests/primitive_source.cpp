#include "farfield/primitive_source.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <random>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/image_cache.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/approximation/sample_set.hpp"
#include "farfield/banded_viewer.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/partition/polygon_bsp.hpp"
#include "farfield/pick.hpp"
#include "farfield/primitive/instance.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/update.hpp"
#include "farfield/viewer.hpp"

using namespace farfield;

namespace {

struct Mesh {
    std::vector<glm::vec3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;

    std::array<glm::vec3, 3> corners(std::uint32_t i) const {
        return {vertices[triangles[i][0]], vertices[triangles[i][1]], vertices[triangles[i][2]]};
    }
    static Rgba8 color_of(std::uint32_t i) { return {std::uint8_t(i * 7), std::uint8_t(100 + i % 100), 40, 255}; }

    std::size_t primitive_count() const { return triangles.size(); }
    Box bounds(std::uint32_t i) const { return bounds_of(corners(i)); }
    template <class Sink>
    void polygons(std::uint32_t i, Sink&& sink) const {
        const std::array<glm::vec3, 3> c = corners(i);
        const Rgba8 color = color_of(i);
        sink(Polygon{c, {&color, 1}});
    }
};
using MeshTriangle = IndexedPrimitive<Mesh>;

static_assert(CountsPrimitives<Mesh> && Primitive<MeshTriangle> && PrimitiveWithPolygons<MeshTriangle>);
static_assert(!PrimitiveWithKey<MeshTriangle> && !PrimitiveWithWork<MeshTriangle> &&
              !PrimitiveWithInstance<MeshTriangle> && !PrimitiveWithColor<MeshTriangle>);
static_assert(std::is_same_v<PrimitiveSpan<Triangle>, std::span<const Triangle>>);

Mesh grid(int side) {
    Mesh mesh;
    std::mt19937 random(11);
    for (int i = 0; i < (side + 1) * (side + 1); ++i) {
        mesh.vertices.emplace_back(float(i % (side + 1)), float(random() % 100) * 0.02f, float(i / (side + 1)));
    }
    const auto wide = std::uint32_t(side + 1);
    for (std::uint32_t z = 0; z < std::uint32_t(side); ++z) {
        for (std::uint32_t x = 0; x < std::uint32_t(side); ++x) {
            const std::uint32_t a = z * wide + x, b = a + 1, c = a + wide, d = c + 1;
            mesh.triangles.push_back({a, c, b});
            mesh.triangles.push_back({b, c, d});
        }
    }
    return mesh;
}
std::vector<Triangle> array_of(const Mesh& mesh) {
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
        triangles.push_back({mesh.corners(i), Mesh::color_of(i)});
    }
    return triangles;
}

View view_of(glm::dvec3 eye, glm::dvec3 at, float tolerance = 1) {
    return {
        .camera = Camera::perspective(eye, at, {0, 1, 0}, 0.8f), .width = 64, .height = 48, .tolerance_px = tolerance};
}

template <class H>
void check_same(const H& a, const H& b) {
    CHECK(std::ranges::equal(a.order(), b.order()));
    CHECK(std::ranges::equal(a.nodes(), b.nodes()));
    CHECK(a.fingerprint() == b.fingerprint());
    CHECK(a.stand_ins().size() == b.stand_ins().size());
}

template <class H>
void check_mesh_against_array() {
    const Mesh mesh = grid(24);
    const std::vector<Triangle> array = array_of(mesh);
    const H of_mesh = build<H>(mesh), of_array = build<H>(array);
    check_same(of_mesh, of_array);
    ZBufferRenderer first, second;
    auto by_mesh = make_viewer(of_mesh, mesh, first);
    auto by_array = make_viewer(of_array, array, second);
    for (const glm::dvec3 eye : {glm::dvec3(12, 10, 40), glm::dvec3(12, 90, 300), glm::dvec3(5, 3, 5)}) {
        const View view = view_of(eye, {12, 0, 12});
        const FrameStats a = by_mesh.frame(view), b = by_array.frame(view);
        CHECK(a.primitives == b.primitives);
        CHECK(a.approximations == b.approximations);
        CHECK(first.image() == second.image());
    }
}

}  // namespace

TEST_CASE("a mesh that answers for an index has the hierarchies and the pictures of an array of triangles") {
    check_mesh_against_array<SpatialHierarchy<Octree, Exact, TriangleCount>>();
    check_mesh_against_array<SpatialHierarchy<Octree, ColorCube, TriangleCount>>();
    check_mesh_against_array<SpatialHierarchy<Octree, OpacityTensor, TriangleCount>>();
    check_mesh_against_array<SpatialHierarchy<Octree, SampleSet<>, TriangleCount>>();
    check_mesh_against_array<SpatialHierarchy<PolygonBsp, Exact, TriangleCount>>();
    check_mesh_against_array<SpatialHierarchy<Octree, ImageCache<Exact>, TriangleCount>>();
}

TEST_CASE("instances of a mesh are drawn, selected, picked and drawn within a budget as those of an array") {
    using Inner = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
    const Mesh mesh = grid(12);
    const std::vector<Triangle> array = array_of(mesh);
    const Inner of_mesh = build<Inner>(mesh), of_array = build<Inner>(array);
    std::vector<Instance<Inner, MeshTriangle>> meshes;
    std::vector<Instance<Inner, Triangle>> arrays;
    for (int i = 0; i < 9; ++i) {
        Similarity place;
        place.translation = {14.0 * (i % 3), 0, 14.0 * (i / 3)};
        meshes.push_back({&of_mesh, mesh, place});
        arrays.push_back({&of_array, array, place});
    }
    const Inner scene = build<Inner>(meshes), same = build<Inner>(arrays);
    check_same(scene, same);
    ZBufferRenderer first, second;
    auto by_mesh = make_viewer(scene, meshes, first);
    auto by_array = make_viewer(same, arrays, second);
    const View view = view_of({20, 30, 80}, {20, 0, 20}, 2);
    CHECK(by_mesh.frame(view).primitives == by_array.frame(view).primitives);
    CHECK(first.image() == second.image());
    by_mesh.draw(by_mesh.select(view));
    CHECK(first.image() == second.image());
    Refinement one, other;
    FrameBudget budget;
    budget.most = 300;
    budget.prices = FramePrices::of_primitives();
    CHECK(by_mesh.frame(view, budget, one).primitives == by_array.frame(view, budget, other).primitives);
    CHECK(first.image() == second.image());
    const auto picked = pick(scene, meshes, view, {30.5, 24.5}), wanted = pick(same, arrays, view, {30.5, 24.5});
    REQUIRE((picked && wanted));
    CHECK(picked->path == wanted->path);
    CHECK(picked->distance == wanted->distance);
}

TEST_CASE("a mesh is picked in, drawn in bands and updated") {
    using H = SpatialHierarchy<Octree, OpacityTensor, TriangleCount>;
    Mesh mesh = grid(16);
    const std::vector<Triangle> array = array_of(mesh);
    const H hierarchy = build<H>(mesh);
    const View view = view_of({8, 20, 30}, {8, 0, 8});
    const auto picked = pick(hierarchy, mesh, view, {32, 24},
                             [](const MeshTriangle& triangle, const auto&) { return triangle.index % 2 == 0; });
    const auto wanted = pick(build<H>(array), array, view, {32, 24},
                             [&](const Triangle& t, const auto&) { return (&t - array.data()) % 2 == 0; });
    REQUIRE((picked && wanted));
    CHECK(picked->path == wanted->path);

    ZBufferRenderer renderer;
    auto viewer = make_viewer(hierarchy, mesh, renderer);
    viewer.frame(view);
    auto banded = make_banded_viewer(hierarchy, mesh, 3, [](std::size_t) { return ZBufferRenderer(); });
    banded.frame(view);
    CHECK(banded.image() == renderer.image());

    BuildOptions<H> options;
    options.world = {glm::dvec3(-10), glm::dvec3(30)};
    HierarchyUpdater<H, MeshTriangle> updater(mesh, options);
    mesh.vertices[40].y += 3;
    std::vector<std::uint32_t> changed;
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
        if (std::ranges::count(mesh.triangles[i], 40u) != 0) changed.push_back(i);
    }
    const H& updated = updater.update(mesh, changed);
    const H built = build<H>(mesh, options);
    check_same(updated, built);
    CHECK(std::ranges::equal(updated.stand_ins(), built.stand_ins()));
}

TEST_CASE("a mesh of nothing is drawn, and a mesh that has changed its size is refused") {
    using H = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
    Mesh mesh;
    const H empty = build<H>(mesh);
    ZBufferRenderer renderer;
    CHECK(make_viewer(empty, mesh, renderer).frame(view_of({0, 0, 9}, {0, 0, 0})).primitives == 0);
    mesh = grid(2);
    CHECK_THROWS_AS(make_viewer(empty, mesh, renderer), std::invalid_argument);
    mesh.vertices[0].x = std::numeric_limits<float>::quiet_NaN();
    CHECK_THROWS_WITH(build<H>(mesh), "farfield: primitive 0 has a bounding box that is not finite (NaN or infinity)");
}
