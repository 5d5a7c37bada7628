#include "farfield/executor.hpp"

#include <atomic>
#include <cstring>
#include <random>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/spatial_hierarchy.hpp"

using namespace farfield;

namespace {

std::vector<Triangle> random_triangles(std::size_t count, unsigned seed) {
    std::mt19937 random(seed);
    const auto number = [&] { return float(random() >> 8) * 0x1p-24f; };
    const auto point = [&] { return glm::vec3(number(), number(), number()); };
    std::vector<Triangle> triangles(count);
    for (Triangle& t : triangles) {
        const glm::vec3 at = point();
        const float size = random() % 32 == 0 ? 0.5f : 0.02f;
        t = {{at, at + (point() - 0.5f) * size, at + (point() - 0.5f) * size}, {}};
        t.rgba = {std::uint8_t(random()), std::uint8_t(random()), std::uint8_t(random()), 255};
        if (random() % 16 == 0) t.vertices[2] = t.vertices[1];
        if (random() % 32 == 0) t.vertices[1] = t.vertices[2] = t.vertices[0];
        if (random() % 64 == 0) t.vertices[0] = t.vertices[1] = t.vertices[2] = glm::vec3(0.25f);
    }
    return triangles;
}

template <class T>
bool same_bytes(std::span<const T> a, std::span<const T> b) {
    if (a.size() != b.size()) return false;
    return std::is_empty_v<T> || a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

}  // namespace

TEMPLATE_TEST_CASE("any number of threads builds the same bytes", "", (SpatialHierarchy<Octree, Exact, TriangleCount>),
                   (SpatialHierarchy<Octree, ColorCube, TriangleCount>),
                   (SpatialHierarchy<SharedOctree, Exact, TriangleCount>),
                   (SpatialHierarchy<SharedOctree, ColorCube, TriangleCount>)) {
    for (const std::size_t count : {0u, 1u, 2u, 300u, 6000u}) {
        const auto triangles = random_triangles(count, unsigned(count) + 1);
        const std::span<const Triangle> span(triangles);
        const auto serial = build<TestType>(span);
        for (const unsigned threads : {1u, 2u, 3u, 8u}) {
            INFO(count << " triangles, " << threads << " threads");
            const auto h = build<TestType>(span, {.executor = ThreadExecutor(threads)});
            CHECK(same_bytes(h.nodes(), serial.nodes()));
            CHECK(same_bytes(h.stand_ins(), serial.stand_ins()));
            CHECK(same_bytes(h.pool(), serial.pool()));
            CHECK(same_bytes(h.order(), serial.order()));
            CHECK(std::memcmp(&h.report(), &serial.report(), sizeof(BuildReport)) == 0);
            CHECK(std::memcmp(&h.whole_work(), &serial.whole_work(), sizeof(Work)) == 0);
        }
    }
}

TEST_CASE("every index is run once") {
    for (const unsigned threads : {0u, 1u, 2u, 3u, 8u}) {
        const ThreadExecutor executor(threads);
        CHECK(executor.threads() >= 1);
        for (const std::size_t count : {0u, 1u, 2u, 7u, 8u, 1000u, 12345u}) {
            std::vector<std::atomic<int>> runs(count);
            executor(count, [&](std::size_t i) { ++runs.at(i); });
            CHECK(std::all_of(runs.begin(), runs.end(), [](const auto& n) { return n == 1; }));
        }
    }
}

TEST_CASE("the caller works too") {
    const auto caller = std::this_thread::get_id();
    const ThreadExecutor one(1), two(2);
    one(5, [&](std::size_t) { CHECK(std::this_thread::get_id() == caller); });
    // The helper waits until the caller has had its turn.
    std::atomic<bool> caller_worked = false;
    two(2, [&](std::size_t) {
        if (std::this_thread::get_id() == caller) caller_worked = true;
        while (!caller_worked) std::this_thread::yield();
    });
    CHECK(caller_worked);
}

TEST_CASE("of several exceptions the caller gets that of the smallest index") {
    for (const unsigned threads : {1u, 2u, 3u, 8u}) {
        const ThreadExecutor executor(threads);
        for (int round = 0; round < 50; ++round) {
            std::vector<std::atomic<int>> runs(1000);
            try {
                executor(runs.size(), [&](std::size_t i) {
                    ++runs[i];
                    if (i % 100 == 37) throw std::runtime_error(std::to_string(i));
                });
                FAIL("nothing was thrown");
            } catch (const std::runtime_error& e) {
                CHECK(std::string(e.what()) == "37");
            }
            for (std::size_t i = 0; i <= 37; ++i) CHECK(runs[i] == 1);
        }
    }
}

TEST_CASE("a build that refuses its input says the same on any number of threads") {
    auto triangles = random_triangles(100, 1);
    triangles[40].vertices[1].x = std::numeric_limits<float>::quiet_NaN();
    triangles[70].vertices[1].x = std::numeric_limits<float>::infinity();
    using H = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
    const auto message = [&](const auto& executor) -> std::string {
        try {
            build<H>(triangles, {.executor = executor});
            return {};
        } catch (const std::invalid_argument& e) {
            return e.what();
        }
    };
    CHECK_FALSE(message(SerialExecutor()).empty());
    CHECK(message(ThreadExecutor(3)) == message(SerialExecutor()));
}
