#include "farfield/hierarchy/fingerprint.hpp"

#include <cstdint>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "catch.hpp"
#include "farfield/primitive/triangle.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {
std::uint64_t of(const Triangles& triangles) {
    return detail::fingerprint_of(std::span<const Triangle>(triangles));
}
}  // namespace

TEST_CASE("a fingerprint tells number, order and place of primitives, and nothing else of them") {
    const Triangles triangles = random_triangles(300, 760);
    const std::uint64_t hash = of(triangles);
    CHECK(of(triangles) == hash);
    std::set<std::uint64_t> others;
    const auto changed = [&](auto&& change) {
        Triangles t = triangles;
        change(t);
        others.insert(of(t));
    };
    changed([](Triangles& t) { t.pop_back(); });
    changed([](Triangles& t) { t.push_back(t.back()); });
    changed([](Triangles& t) { std::swap(t[0], t[1]); });
    changed([](Triangles& t) { std::swap(t[17], t[299]); });
    for (const int axis : {0, 1, 2}) {
        changed([&](Triangles& t) { t[150].vertices[1][axis] += 3; });
        changed([&](Triangles& t) { t[150].vertices[1][axis] -= 3; });
    }
    CHECK(others.size() == 10);
    CHECK(others.count(hash) == 0);
    Triangles painted = triangles;
    for (Triangle& t : painted) t.rgba = {1, 2, 3, 4};
    CHECK(of(painted) == hash);
    CHECK(of({}) != of({Triangle{}}));
}

TEST_CASE("paths of instances are told apart, in their order") {
    using detail::mixed;
    std::set<std::uint64_t> seen{0};
    for (std::uint64_t a = 1; a <= 60; ++a) {
        seen.insert(mixed(0, a));
        for (std::uint64_t b = 1; b <= 60; ++b) seen.insert(mixed(mixed(0, a), b));
    }
    CHECK(seen.size() == 1 + 60 + 60 * 60);
}

TEST_CASE("what was mixed into a hash is had back from it") {
    for (const std::uint64_t hash : {0ull, 1ull, 0x123456789abcdefull, ~0ull}) {
        for (const std::uint64_t value : {0ull, 1ull, 77ull, 0xfedcba9876543210ull, ~0ull}) {
            CHECK(detail::unmixed(hash, detail::mixed(hash, value)) == value);
        }
    }
}
