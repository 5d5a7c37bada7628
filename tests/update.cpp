#include "farfield/update.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
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
                                      : random_triangles(1, random.bits(), random.bits() % 16 == 0 ? 1.0f : 0.02f)[0]);
    }
    return change;
}

const BoxD space{glm::dvec3(-3), glm::dvec3(3)};

template <class F>
std::string refusal(F&& f) {
    try {
        f();
        return {};
    } catch (const std::exception& e) {
        return e.what();
    }
}

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

TEMPLATE_TEST_CASE("nothing, all, and the same again are changes too", "", Exact, ColorCube, OpacityTensor,
                   SampleSet<>) {
    using H = In<TestType>;
    const BuildOptions<H> options{.world = space};
    Triangles primitives;
    HierarchyUpdater<H, Triangle> updater(primitives, options);
    const auto check = [&](const char* name, const Change<Triangle>& change) {
        const Changed changed = change.apply_to(primitives);
        const char* what = difference(updater.update(primitives, changed.indices), build<H>(primitives, options));
        INFO(name << ", other " << (what != nullptr ? what : ""));
        CHECK(what == nullptr);
    };
    const Triangles some = mixed_triangles(1500, 931);
    check("nothing", {});
    check("into nothing", {.inserted = some});
    check("nothing", {});
    Change<Triangle> change;
    for (std::uint32_t i = 0; i < 1500; i += 7) change.moved.push_back({i, primitives[i]});
    check("onto themselves", change);
    check("all of them again", {.inserted = some});
    check("one place", {.inserted = Triangles(2000, some[4])});
    change = {};
    for (std::uint32_t i = 0; i < primitives.size(); ++i) change.erased.push_back(i);
    check("all gone", change);
    check("one", {.inserted = {some[0]}});
    check("another in its place", {.erased = {0}, .inserted = {some[1]}});
    check("gone", {.erased = {0}});
    Triangles flat = random_triangles(600, 932, 0.01f);
    for (Triangle& t : flat) t.vertices[2] = t.vertices[1];
    check("without area", {.inserted = flat});
    check("and some with", {.moved = {{3, some[2]}}, .inserted = {some[3], some[4]}});
    // Outside of the world the root's cell grows, and shrinks again.
    Triangle far_off = some[5];
    for (glm::vec3& v : far_off.vertices) v += glm::vec3(40, 0, 0);
    check("outside", {.moved = {{1, far_off}}});
    check("more there", {.inserted = {far_off, some[6]}});
    check("and back", {.erased = {602}, .moved = {{1, some[5]}}});
}

TEST_CASE("a change takes the places of what goes, and tells who moved") {
    struct Numbered {
        int number;
    };
    const auto numbers = [](int count) {
        std::vector<Numbered> all;
        for (int i = 0; i < count; ++i) all.push_back({i});
        return all;
    };
    const auto result = [&](int count, const Change<Numbered>& change, std::vector<int> expected,
                            std::vector<std::uint32_t> indices, std::vector<Changed::Renumbered> renumbered) {
        std::vector<Numbered> all = numbers(count);
        const Changed changed = change.apply_to(all);
        std::vector<int> got;
        for (const Numbered& n : all) got.push_back(n.number);
        CHECK(got == expected);
        CHECK(changed.indices == indices);
        CHECK(changed.renumbered == renumbered);
    };
    result(3, {}, {0, 1, 2}, {}, {});
    result(3, {.inserted = {{7}, {8}}}, {0, 1, 2, 7, 8}, {3, 4}, {});
    result(4, {.erased = {1}, .inserted = {{7}}}, {0, 7, 2, 3}, {1}, {});
    result(4, {.erased = {1}}, {0, 3, 2}, {1, 3}, {{3, 1}});
    result(7, {.erased = {5, 2}}, {0, 1, 6, 3, 4}, {2, 5, 6}, {{6, 2}});
    result(7, {.erased = {6, 2, 5}}, {0, 1, 4, 3}, {2, 4, 5, 6}, {{4, 2}});
    result(3, {.erased = {0, 1, 2}}, {}, {0, 1, 2}, {});
    result(4, {.erased = {0}, .moved = {{3, {9}}}}, {9, 1, 2}, {0, 3}, {{3, 0}});

    std::vector<Numbered> all = numbers(3);
    const auto refused = [&](const Change<Numbered>& change) {
        const std::string why = refusal([&] { change.apply_to(all); });
        CHECK(all.size() == 3);
        CHECK(all[1].number == 1);
        return why;
    };
    CHECK(refused({.erased = {3}}) == "farfield::Change: primitive 3 is to be changed and there are 3");
    CHECK(refused({.moved = {{1, {5}}, {9, {5}}}}) == "farfield::Change: primitive 9 is to be changed and there are 3");
    CHECK(refused({.erased = {1, 0, 1}}) == "farfield::Change: primitive 1 is erased or moved twice");
    CHECK(refused({.erased = {1}, .moved = {{1, {5}}}}) == "farfield::Change: primitive 1 is erased or moved twice");
}

TEST_CASE("an update that is refused leaves the version before, and the next one is right") {
    using H = In<SampleSet<>>;
    const BuildOptions<H> options{.world = space};
    Triangles primitives = random_triangles(300, 941);
    HierarchyUpdater<H, Triangle> updater(primitives, options);
    const H before = updater.hierarchy();
    const auto refused = [&](const Triangles& to, std::vector<std::uint32_t> changed) {
        const std::string why = refusal([&] { updater.update(to, changed); });
        CHECK(difference(updater.hierarchy(), before) == nullptr);
        return why;
    };
    CHECK(refused(primitives, {2, 300}) ==
          "farfield::HierarchyUpdater: primitive 300 has changed, it is said, and there are 300");
    CHECK(refused(primitives, {2, 1, 2}) == "farfield::HierarchyUpdater: primitive 2 is named twice");
    Triangles wrong = primitives;
    wrong[17].vertices[1].y = std::numeric_limits<float>::quiet_NaN();
    CHECK(refused(wrong, {17}).find("farfield: primitive 17 has") == 0);
    wrong[17].vertices[1].y = 3e38f;
    CHECK(refused(wrong, {17}) == "farfield: primitive 17 makes the scene's extent overflow single precision");
    primitives[17] = primitives[3];
    primitives.pop_back();
    CHECK(difference(updater.update(primitives, std::vector<std::uint32_t>{17}), build<H>(primitives, options)) ==
          nullptr);
    // A listener may stop it.
    bool goes_on = true;
    BuildOptions<H> watched = options;
    watched.progress = [&](const BuildProgress&) { return goes_on; };
    HierarchyUpdater<H, Triangle> stopped(primitives, watched);
    goes_on = false;
    primitives[5] = primitives[9];
    CHECK_THROWS_AS(stopped.update(primitives, std::vector<std::uint32_t>{5}), BuildCanceled);
    goes_on = true;
    // Cells that were about to go when it was stopped are not mixed up with those of the tree that is built anew.
    for (int round = 0; round < 4; ++round) {
        Change<Triangle> change;
        for (std::uint32_t i = 0; i < 200; ++i) change.erased.push_back(i);
        Triangles others = primitives;
        const Changed changed = change.apply_to(others);
        goes_on = false;
        CHECK_THROWS_AS(stopped.update(others, changed.indices), BuildCanceled);
        goes_on = true;
        for (std::uint32_t i = 0; i < 3; ++i) {
            Triangles& now = i == 1 ? others : primitives;
            const std::size_t last = stopped.hierarchy().primitive_count();
            std::vector<std::uint32_t> all(std::min(last, now.size()));
            std::iota(all.begin(), all.end(), 0u);
            CHECK(difference(stopped.update(now, all), build<H>(now, options)) == nullptr);
        }
    }
}

TEMPLATE_TEST_CASE("instances move far from 0, in double precision", "", Exact, ColorCube, SampleSet<>) {
    using H = In<TestType>;
    using Tree = Instance<H, Triangle>;
    const Triangles leaves = random_triangles(300, 951);
    const H tree = build<H>(leaves);
    Random random(952);
    const glm::dvec3 there(5e6, -3e6, 100);
    const auto placed = [&] {
        return Tree{&tree, leaves,
                    Similarity(glm::mat3(1), 0.02f + 0.05f * random.unit(), there + glm::dvec3(random.in_cube(3)))};
    };
    for (const BoxD& world : {BoxD{there - 5.0, there + 6.0}, BoxD::empty()}) {
        std::vector<Tree> trees;
        for (int i = 0; i < 500; ++i) trees.push_back(placed());
        const BuildOptions<H> options{.world = world};
        HierarchyUpdater<H, Tree> updater(trees, options);
        for (int step = 0; step < 12; ++step) {
            Change<Tree> change;
            for (unsigned i = 0; i < 10; ++i) change.moved.push_back({10 * i + random.below(10), placed()});
            change.erased = {100 + random.below(300)};
            for (unsigned i = 0; i < random.below(4); ++i) change.inserted.push_back(placed());
            const Changed changed = change.apply_to(trees);
            const char* what = difference(updater.update(trees, changed.indices), build<H>(trees, options));
            INFO("step " << step << ", other " << (what != nullptr ? what : ""));
            CHECK(what == nullptr);
        }
    }
}
