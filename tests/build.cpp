#include "farfield/build.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <list>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/color_cube_cluster.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/cost_model/measured_time.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/nested.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/partition/polygon_bsp.hpp"
#include "farfield/primitive/instance.hpp"
#include "farfield/primitive/triangle.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

using Cubes = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
using SharedExact = SpatialHierarchy<SharedOctree, Exact, TriangleCount>;
using Bsp = SpatialHierarchy<PolygonBsp, Exact, TriangleCount>;

template <class T>
bool same_bytes(std::span<const T> a, std::span<const T> b) {
    return a.size() == b.size() &&
           (std::is_empty_v<T> || a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}
template <class H>
bool same(const H& a, const H& b) {
    return same_bytes(a.nodes(), b.nodes()) && same_bytes(a.stand_ins(), b.stand_ins()) &&
           same_bytes(a.order(), b.order()) && same_bytes(a.all_node_data(), b.all_node_data()) &&
           same_bytes(a.fragments().vertices, b.fragments().vertices) && a.fingerprint() == b.fingerprint() &&
           std::memcmp(&a.report(), &b.report(), sizeof(BuildReport)) == 0;
}
bool same_primitives(const Triangles& a, const Triangles& b) {
    return same_bytes(std::span(a), std::span(b));
}

template <class H, class Range>
concept Builds = requires(Range&& range) {
    build<H>(range);
};
template <class H, class Range>
concept BuildsInPlace = requires(Range&& range) {
    build_in_place<H>(range);
};

}  // namespace

static_assert(Builds<Cubes, Triangles&> && Builds<Cubes, const Triangles&> && Builds<Cubes, std::span<Triangle>> &&
              Builds<Cubes, std::span<const Triangle>> && Builds<Cubes, std::array<Triangle, 3>&> &&
              Builds<Cubes, Triangle (&)[3]>);
static_assert(!Builds<Cubes, std::list<Triangle>&> && !Builds<Cubes, std::vector<int>&> && !Builds<Cubes, Triangle&>);
static_assert(BuildsInPlace<Cubes, Triangles&> && BuildsInPlace<Cubes, std::span<Triangle>> &&
              BuildsInPlace<Cubes, Triangle (&)[3]>);
static_assert(!BuildsInPlace<Cubes, const Triangles&> && !BuildsInPlace<Cubes, std::span<const Triangle>>);
static_assert(!BuildsInPlace<SharedExact, Triangles&> && !BuildsInPlace<Bsp, Triangles&>,
              "only where every primitive is stored once");

TEMPLATE_TEST_CASE("any contiguous range builds the same", "", Cubes, SharedExact, Bsp) {
    constexpr std::size_t count = 300;
    Triangles triangles = mixed_triangles(count, 730);
    const Triangles constant = triangles;
    std::array<Triangle, count> array;
    std::copy(triangles.begin(), triangles.end(), array.begin());
    static Triangle plain[count];
    std::copy(triangles.begin(), triangles.end(), plain);
    const TestType expected = build<TestType>(triangles);
    CHECK(same(build<TestType>(constant), expected));
    CHECK(same(build<TestType>(std::span<Triangle>(triangles)), expected));
    CHECK(same(build<TestType>(std::span<const Triangle>(triangles)), expected));
    CHECK(same(build<TestType>(std::span<const Triangle, count>(array)), expected));
    CHECK(same(build<TestType>(array), expected));
    CHECK(same(build<TestType>(std::as_const(array)), expected));
    CHECK(same(build<TestType>(plain), expected));
    CHECK(same_primitives(triangles, constant));
    CHECK(build<TestType>(std::span<const Triangle>()).item_count() == 0);
}

TEST_CASE("options are by name, and those that are left out are the policies' own") {
    const Triangles triangles = random_triangles(2000, 731, 0.02f);
    const Cubes h = build<Cubes>(triangles, {.partition = {.max_depth = 2}, .approximation = {.samples = 2}});
    CHECK(h.partition_policy().max_depth == 2);
    CHECK(h.approximation_policy().samples == 2);
    CHECK(h.report().levels <= 3);
    // A sampler that is not the default one, and a light as a sampler's.
    const DirectionalLight light{.towards = {1, 0, 0}, .ambient = 0.1f};
    const Cubes dark = build<Cubes>(triangles, {.sampler = light}), bright = build<Cubes>(triangles);
    CHECK_FALSE(same_bytes(dark.stand_ins(), bright.stand_ins()));
    CHECK(same_bytes(dark.nodes(), bright.nodes()));
}

TEST_CASE("a world is what the root's cell is made for, beside what there is") {
    const Triangles triangles = random_triangles(500, 734, 0.02f);
    const Cubes h = build<Cubes>(triangles, {.world = {glm::dvec3(-4), glm::dvec3(4, 2, 4)}});
    CHECK(h.root_cell().half == glm::vec3(4));
    CHECK(h.root_cell().center == glm::vec3(0, -1, 0));
    CHECK(h.bounds() == build<Cubes>(triangles).bounds());
    const Cubes around = build<Cubes>(triangles, {.world = {glm::dvec3(0), glm::dvec3(0.1)}});
    CHECK(same(around, build<Cubes>(triangles)));
    const auto refused = [&](const BoxD& world) {
        try {
            build<Cubes>(triangles, {.world = world});
            return std::string();
        } catch (const std::invalid_argument& e) {
            return std::string(e.what());
        }
    };
    constexpr double infinity = std::numeric_limits<double>::infinity();
    const std::string why = "farfield: BuildOptions::world must be BoxD::empty() or a finite box";
    CHECK(refused({glm::dvec3(0), glm::dvec3(infinity)}) == why);
    CHECK(refused({glm::dvec3(1), glm::dvec3(0)}) == why);
    CHECK(refused({glm::dvec3(0), glm::dvec3(1e39)}) == "farfield: BuildOptions::world overflows single precision");
}

TEST_CASE("in place, primitives come in the hierarchy's order, and it needs no list of it") {
    for (const std::size_t count : {0u, 1u, 2000u}) {
        const Triangles before = mixed_triangles(count, 732);
        const Cubes listed = build<Cubes>(before);
        Triangles ordered = before;
        const Cubes h = build_in_place<Cubes>(ordered);
        CHECK(h.order().empty());
        CHECK(same_bytes(h.nodes(), listed.nodes()));
        CHECK(same_bytes(h.stand_ins(), listed.stand_ins()));
        Triangles expected;
        for (const std::uint32_t i : listed.order()) expected.push_back(before[i]);
        CHECK(same_primitives(ordered, expected));
        CHECK(h.fingerprint() == detail::fingerprint_of(std::span<const Triangle>(ordered)));
        Triangles seen = before;
        CHECK(same(build_in_place<Cubes>(std::span<Triangle>(seen)), h));
        CHECK(same_primitives(seen, ordered));
    }
}

TEMPLATE_TEST_CASE("progress is told phase by phase, never goes back and ends where it said", "", Cubes, SharedExact,
                   Bsp) {
    for (const std::size_t count : {0u, 1u, 8000u}) {
        const Triangles triangles = random_triangles(count, 733, 0.02f);
        for (const bool many_threads : {false, true}) {
            std::vector<BuildProgress> told;
            BuildOptions<TestType> options;
            options.progress = [&](const BuildProgress& p) {
                told.push_back(p);
                return true;
            };
            if (many_threads) options.executor = ThreadExecutor(3);
            CHECK(same(build<TestType>(triangles, options), build<TestType>(triangles)));
            CHECK(told.size() < 1000);
            // Where polygons are cut, branches of 4,096 pieces or fewer are a step.
            if (count > 1) CHECK(told.size() > (TestType::assignment == Assignment::clipped ? 0 : 1));
            for (std::size_t i = 0; i < told.size(); ++i) {
                CHECK(told[i].done <= told[i].total);
                if (i == 0) continue;
                CHECK(told[i].phase >= told[i - 1].phase);
                // What is left becomes less; shared items and pieces become more while they are split.
                if (told[i].phase == told[i - 1].phase) CHECK(told[i].done >= told[i - 1].done);
            }
            if (!told.empty()) CHECK(told.back().done == told.back().total);
        }
    }
}

TEMPLATE_TEST_CASE("a build may be canceled whenever it asks, and leaves primitives as they were", "", Cubes,
                   SharedExact, Bsp) {
    const Triangles before = random_triangles(5000, 734, 0.02f);
    Triangles triangles = before;
    for (const bool many_threads : {false, true}) {
        BuildOptions<TestType> options;
        if (many_threads) options.executor = ThreadExecutor(2);
        std::size_t calls = 0;
        options.progress = [&](const BuildProgress&) { return ++calls != 0; };
        build<TestType>(triangles, options);
        REQUIRE(calls > 0);
        const std::size_t all = calls;
        for (std::size_t last = 1; last <= all; last += 1 + all / 40) {
            calls = 0;
            options.progress = [&](const BuildProgress&) { return ++calls < last; };
            CHECK_THROWS_AS(build<TestType>(triangles, options), BuildCanceled);
            CHECK(calls == last);
            if constexpr (BuildsInPlace<TestType, Triangles&>) {
                calls = 0;
                CHECK_THROWS_AS(build_in_place<TestType>(triangles, options), BuildCanceled);
                CHECK(calls == last);
            }
            CHECK(same_primitives(triangles, before));
        }
    }
}

TEST_CASE("what the callback or the executor throws reaches who called") {
    struct Mine {};
    Triangles triangles = random_triangles(3000, 735, 0.02f);
    const Triangles before = triangles;
    BuildOptions<Cubes> options;
    options.progress = [](const BuildProgress&) -> bool { throw Mine(); };
    CHECK_THROWS_AS(build<Cubes>(triangles, options), Mine);
    CHECK_THROWS_AS(build_in_place<Cubes>(triangles, options), Mine);
    options.progress = {};
    options.executor = [](std::size_t, const std::function<void(std::size_t)>&) { throw Mine(); };
    CHECK_THROWS_AS(build_in_place<Cubes>(triangles, options), Mine);
    CHECK(same_primitives(triangles, before));
}

TEMPLATE_TEST_CASE("an executor of one's own builds the same", "", Cubes, SharedExact, Bsp) {
    const Triangles triangles = mixed_triangles(6000, 736);
    BuildOptions<TestType> options;
    std::size_t steps = 0;
    options.executor = [&](std::size_t count, const std::function<void(std::size_t)>& f) {
        steps += count;
        for (std::size_t i = count; i-- > 0;) f(i);
    };
    CHECK(same(build<TestType>(triangles, options), build<TestType>(triangles)));
    CHECK(steps > 0);
    options.executor = SerialExecutor();
    CHECK(same(build<TestType>(triangles, options), build<TestType>(triangles)));
}

TEST_CASE("primitives that nothing can be built from are named") {
    Triangles triangles = random_triangles(10, 737);
    triangles[7].vertices[1].y = std::numeric_limits<float>::quiet_NaN();
    const Triangles before = triangles;
    try {
        build_in_place<Cubes>(triangles);
        FAIL("it was built");
    } catch (const std::invalid_argument& e) {
        CHECK(std::string(e.what()).find("primitive 7 ") != std::string::npos);
    }
    CHECK(same_primitives(triangles, before));
}

namespace {
template <class H, class P>
std::string build_refusal(const std::vector<P>& primitives, const BuildOptions<H>& options) {
    try {
        build<H>(primitives, options);
        return "taken";
    } catch (const std::invalid_argument& e) {
        return e.what();
    }
}
}  // namespace

TEST_CASE("an option that makes no sense is refused by its name before anything is built") {
    const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
    const Triangles triangles = random_triangles(50, 739);
    using Clusters = SpatialHierarchy<Octree, ColorCubeCluster<2>, TriangleCount>;
    using Timed = SpatialHierarchy<Octree, ColorCube, MeasuredTime>;
    using Halls = SpatialHierarchy<Nested<Octree, PolygonBsp>, Exact, TriangleCount>;
    CHECK(build_refusal<Cubes>(triangles, {.approximation = {.samples = 9}}) ==
          "farfield::ColorCube: samples must be at most 8");
    for (const std::uint32_t samples : {0u, 9u}) {
        CHECK(build_refusal<Clusters>(triangles, {.approximation = {.samples = samples}}) ==
              "farfield::ColorCubeCluster: samples must be from 1 to 8");
    }
    CHECK(build_refusal<Bsp>(triangles, {.partition = {.max_depth = 100'000}}) ==
          "farfield::PolygonBsp: max_depth must be at most 1000");
    CHECK(build_refusal<Halls>(triangles, {.partition = {.largest_leaf = 0}}) ==
          "farfield::Nested: largest_leaf must be 1 or more");
    CHECK(build_refusal<Halls>(triangles, {.partition = {.inner = {.price_of_cut = nan}}}) ==
          "farfield::PolygonBsp: price_of_cut must be 0 or more and finite");
    using Tensors = SpatialHierarchy<Octree, OpacityTensor, TriangleCount>;
    for (const float bad : {nan, infinity, -1.0f}) {
        CHECK(build_refusal<Tensors>(triangles, {.approximation = {.sheet_gain = bad}}) ==
              "farfield::OpacityTensor: gains of sheets must be above 0 and finite");
        CHECK(build_refusal<Cubes>(triangles, {.cost_model = {.triangles_per_splat = bad}}) ==
              "farfield::TriangleCount: prices must be 0 or more and finite");
        CHECK(build_refusal<Timed>(triangles, {.cost_model = {.run = bad}}) ==
              "farfield::MeasuredTime: prices must be 0 or more and finite");
        CHECK(build_refusal<Cubes>(triangles, {.approximation = {.coverage_threshold = bad}}) ==
              "farfield::ColorCube: coverage_threshold must lie between 0 and 1");
        CHECK(build_refusal<Clusters>(triangles, {.approximation = {.coverage_threshold = bad}}) ==
              "farfield::ColorCubeCluster: coverage_threshold must lie between 0 and 1");
        CHECK(build_refusal<Cubes>(triangles, {.sampler = DirectionalLight{.ambient = bad}}) ==
              "farfield::DirectionalLight: ambient must be 0 or more and finite");
        CHECK(build_refusal<Cubes>(triangles, {.sampler = DirectionalLight{.diffuse = bad}}) ==
              "farfield::DirectionalLight: diffuse must be 0 or more and finite");
    }
    for (const glm::vec3 bad : {glm::vec3(0), glm::vec3(0, nan, 0), glm::vec3(infinity, 0, 1)}) {
        CHECK(build_refusal<Cubes>(triangles, {.sampler = DirectionalLight{.towards = bad}}) ==
              "farfield::DirectionalLight: towards must be finite and not 0");
    }
}

TEST_CASE("an instance of nothing, or of other primitives, is refused by its number") {
    using Placed = Instance<Cubes, Triangle>;
    const Triangles triangles = random_triangles(50, 740);
    const Cubes inner = build<Cubes>(triangles);
    std::vector<Placed> things{{&inner, triangles, {}}, {&inner, triangles, {}}};
    CHECK(build_refusal<Cubes>(things, {}) == "taken");
    things[1].hierarchy = nullptr;
    CHECK(build_refusal<Cubes>(things, {}) == "farfield: primitive 1 is an instance without a hierarchy");
    things[1] = {&inner, std::span(triangles).first(49), {}};
    CHECK(build_refusal<Cubes>(things, {}) ==
          "farfield: primitive 1 is an instance with fewer or more primitives than its hierarchy was built from");
    things[1] = {&inner, triangles, {}};
    things[1].to_world.translation.y = std::numeric_limits<double>::quiet_NaN();
    CHECK(build_refusal<Cubes>(things, {}) ==
          "farfield: primitive 1 has a bounding box that is not finite (NaN or infinity)");
}
