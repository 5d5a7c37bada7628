#include "farfield/update.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/area_splat.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/color_cube_cluster.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/approximation/sample_set.hpp"
#include "farfield/approximation/sided_tensor.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/partition/polygon_bsp.hpp"
#include "farfield/primitive/instance.hpp"
#include "farfield/primitive/triangle.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

template <class A>
using In = SpatialHierarchy<Octree, A, TriangleCount>;
using Shared = SpatialHierarchy<SharedOctree, Exact, TriangleCount>;
using Bsp = SpatialHierarchy<PolygonBsp, Exact, TriangleCount>;

static_assert(HierarchyUpdater<In<SampleSet<>>, Triangle>::updates_cells &&
              HierarchyUpdater<In<ColorCubeCluster<2>>, Triangle>::updates_cells);
static_assert(!HierarchyUpdater<Shared, Triangle>::updates_cells && !HierarchyUpdater<Bsp, Triangle>::updates_cells);

template <class T>
bool same_bytes(std::span<const T> a, std::span<const T> b) {
    return a.size() == b.size() &&
           (std::is_empty_v<T> || a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}
/// Null, or what differs first.
template <class H>
const char* difference(const H& a, const H& b) {
    if (std::memcmp(&a.report(), &b.report(), sizeof(BuildReport)) != 0) return "reports";
    if (!same_bytes(a.nodes(), b.nodes())) return "nodes";
    if (!same_bytes(a.stand_ins(), b.stand_ins())) return "stand-ins";
    if (!same_bytes(a.pool(), b.pool())) return "pools";
    if (!same_bytes(a.order(), b.order())) return "orders";
    if (!same_bytes(a.all_node_data(), b.all_node_data())) return "node data";
    if (!same_bytes(a.fragments().vertices, b.fragments().vertices)) return "fragments";
    return std::memcmp(&a.facts(), &b.facts(), sizeof(HierarchyFacts)) != 0 ? "facts" : nullptr;
}

Triangle small_triangle(Random& random, float size) {
    Triangle t = random_triangles(1, random.bits(), size)[0];
    return t;
}

/// Random changes of `primitives`, few at a time, some of many.
Change<Triangle> random_change(Random& random, const Triangles& primitives, std::size_t most) {
    Change<Triangle> change;
    std::vector<std::uint32_t> indices(primitives.size());
    for (std::uint32_t i = 0; i < indices.size(); ++i) indices[i] = i;
    const auto some = [&] { return random.bits() % (most + 1); };
    const auto take = [&] {
        const std::size_t at = random.bits() % indices.size();
        const std::uint32_t i = indices[at];
        indices[at] = indices.back();
        indices.pop_back();
        return i;
    };
    for (std::size_t n = some(); n-- > 0 && !indices.empty();) change.erased.push_back(take());
    for (std::size_t n = some(); n-- > 0 && !indices.empty();) {
        const std::uint32_t i = take();
        Triangle t = primitives[i];
        const glm::vec3 by = random.in_cube(random.bits() % 2 == 0 ? 0.01f : 0.5f);
        for (glm::vec3& v : t.vertices) v += by;
        if (random.bits() % 8 == 0) t = primitives[i];
        change.moved.push_back({i, t});
    }
    for (std::size_t n = some(); n-- > 0;) {
        change.inserted.push_back(random.bits() % 4 == 0 && !primitives.empty()
                                      ? primitives[random.bits() % primitives.size()]
                                      : small_triangle(random, random.bits() % 16 == 0 ? 1.0f : 0.02f));
    }
    return change;
}

const BoxD space{glm::dvec3(-3), glm::dvec3(3)};

template <class H>
void check_sequence(Triangles primitives, BuildOptions<H> options, std::uint64_t seed, int steps, std::size_t most) {
    HierarchyUpdater<H, Triangle> updater(primitives, options);
    const char* first = difference(updater.hierarchy(), build<H>(primitives, options));
    INFO("built at first, other " << (first != nullptr ? first : ""));
    REQUIRE(first == nullptr);
    Random random(seed);
    for (int step = 0; step < steps; ++step) {
        const H before = updater.hierarchy(), kept = build<H>(primitives, options);
        const Changed changed =
            random_change(random, primitives, step % 3 == 2 ? most : 1 + most / 20).apply_to(primitives);
        const char* what = difference(updater.update(primitives, changed.indices), build<H>(primitives, options));
        INFO("step " << step << ", " << primitives.size() << " primitives, other " << (what != nullptr ? what : ""));
        REQUIRE(what == nullptr);
        CHECK(difference(before, kept) == nullptr);
    }
}

}  // namespace

TEMPLATE_TEST_CASE("versions are what a build makes, byte for byte", "", Exact, ColorCube, ColorCubeCluster<2>,
                   OpacityTensor, SidedTensor, AreaSplat, SampleSet<>, SampleSet<OpacityTensor>) {
    using H = In<TestType>;
    check_sequence<H>(mixed_triangles(3000, 901), {.world = space}, 902, 12, 60);
    check_sequence<H>(random_triangles(2000, 903, 0.01f), {.world = space}, 904, 9, 400);
    check_sequence<H>(random_triangles(40, 905, 0.05f), {.world = space}, 906, 30, 30);
    check_sequence<H>(Triangles(900, random_triangles(1, 1, 0.01f)[0]), {.world = space}, 907, 6, 300);
    // Without a world, bounds change now and then.
    check_sequence<H>(mixed_triangles(500, 908), {}, 909, 8, 10);
}

TEST_CASE("options of policies are kept, and any number of threads gives the same") {
    check_sequence<In<ColorCube>>(mixed_triangles(1500, 911),
                                  {.approximation = {.samples = 3, .inner = ColorCube::Inner::composited},
                                   .executor = ThreadExecutor(4),
                                   .world = space},
                                  912, 9, 50);
    check_sequence<In<Exact>>(mixed_triangles(1500, 913), {.partition = {.uniform_depth = 3}, .world = space}, 914, 9,
                              50);
    check_sequence<In<Exact>>(mixed_triangles(1500, 913), {.partition = {.max_depth = 2}, .world = space}, 914, 9, 50);
    for (const float c : {0.5f, 4.0f, 200.0f}) {
        check_sequence<In<SampleSet<>>>(mixed_triangles(3000, 915), {.approximation = {.c = c}, .world = space}, 916, 9,
                                        100);
    }
}

TEST_CASE("what is built anew is the same too") {
    check_sequence<Shared>(mixed_triangles(800, 921), {.world = space}, 922, 4, 30);
    check_sequence<Bsp>(random_triangles(200, 923), {.world = space}, 924, 4, 10);
    check_sequence<In<ColorCube>>(mixed_triangles(800, 925), {.memory_budget_bytes = 4000}, 926, 4, 30);
}
