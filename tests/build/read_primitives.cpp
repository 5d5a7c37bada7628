#include "farfield/build/read_primitives.hpp"

#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "catch.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

struct Thing {
    BoxD box;
    Work made_of{.triangles = 1};
    BoxD bounds() const { return box; }
    Work work() const { return made_of; }
};

template <class P>
std::vector<Item> items_of(const std::vector<P>& primitives, HierarchyFacts& facts) {
    std::vector<Item> items;
    detail::read_primitives(std::span<const P>(primitives), TriangleCount{}, BoxD::empty(), facts,
                            [&](const Item& item) { items.push_back(item); });
    return items;
}
std::string refusal(const std::vector<Thing>& things) {
    HierarchyFacts facts;
    try {
        items_of(things, facts);
        return {};
    } catch (const std::invalid_argument& e) {
        return e.what();
    }
}
Thing at(glm::dvec3 center, double half = 0.5) {
    return {{center - half, center + half}};
}

}  // namespace

TEST_CASE("facts are those of the whole scene, and items those of each primitive") {
    const Triangles triangles = random_triangles(200, 800);
    HierarchyFacts facts;
    const auto items = items_of(triangles, facts);
    REQUIRE(items.size() == 200);
    Box whole = Box::empty();
    for (std::uint32_t i = 0; i < 200; ++i) {
        CHECK(items[i].source == i);
        CHECK(items[i].cost == 1);
        CHECK(items[i].bounds.lower == triangles[i].bounds().lower);
        CHECK(items[i].bounds.upper == triangles[i].bounds().upper);
        whole.add(triangles[i].bounds());
    }
    CHECK((facts.bounds.lower == whole.lower && facts.bounds.upper == whole.upper));
    CHECK(facts.origin == glm::dvec3(0));
    CHECK(facts.primitive_count == 200);
    CHECK(facts.report.primitives == 200);
    CHECK(facts.work.triangles == 200);
    CHECK(facts.fingerprint == detail::fingerprint_of(std::span<const Triangle>(triangles)));
    HierarchyFacts of_nothing;
    CHECK(items_of(Triangles{}, of_nothing).empty());
    CHECK(of_nothing.bounds.is_empty());
}

TEST_CASE("far from 0 a scene in double precision gets an origin in its middle") {
    HierarchyFacts facts;
    const auto items = items_of(std::vector<Thing>{at({1e9, 0, 5}), at({1e9 + 8, 0, 5})}, facts);
    CHECK(facts.origin == glm::dvec3(1e9 + 4, 0, 5));
    CHECK(items[0].bounds.center() == glm::vec3(-4, 0, 0));
    CHECK(items[1].bounds.center() == glm::vec3(4, 0, 0));
    CHECK((facts.bounds.lower.x == -4.5f && facts.bounds.upper.x == 4.5f));
}

TEST_CASE("the first primitive that nothing can be made of is named, and why") {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    CHECK(refusal({at({0, 0, 0}), at({0, 0, 0}, -1)}) ==
          "farfield: primitive 1 has an empty bounding box (lower > upper)");
    CHECK(refusal({at({0, infinity, 0})}) ==
          "farfield: primitive 0 has a bounding box that is not finite (NaN or infinity)");
    CHECK_FALSE(refusal({at({0, 0, 0}), at({nan, 0, 0})}).empty());
    Thing cheap = at({0, 0, 0}), odd = cheap;
    cheap.made_of.triangles = -1;
    odd.made_of.triangles = float(nan);
    CHECK(refusal({at({0, 0, 0}), at({0, 0, 0}), cheap}) == "farfield: primitive 2 has a cost below 0 or NaN");
    CHECK(refusal({odd}) == "farfield: primitive 0 has a cost below 0 or NaN");
    // Each by itself is finite; together they are not in single precision.
    CHECK(refusal({at({3e38, 0, 0}), at({-3e38, 0, 0})}) ==
          "farfield: primitive 1 makes the scene's extent overflow single precision");
    CHECK(refusal({at({3e37, 0, 0}), at({-3e37, 0, 0})}).empty());
}

TEST_CASE("the work of a scene is counted past what a float can count by ones") {
    detail::WorkSum sum;
    for (int i = 0; i < 20'000'000; ++i) sum.add({.triangles = 1, .runs = 0.5f});
    CHECK(sum.total().triangles == 20e6f);
    CHECK(sum.total().runs == 10e6f);
    CHECK(sum.total().faces == 0);
}
