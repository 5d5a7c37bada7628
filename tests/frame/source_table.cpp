#include "farfield/frame/source_table.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/instance.hpp"
#include "support/recorder.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::test;
using farfield::detail::SourceState;
using farfield::detail::SourceTable;

namespace {

using Shared = SpatialHierarchy<SharedOctree, Exact, TriangleCount>;
using Loose = SpatialHierarchy<Octree, Exact, TriangleCount>;
using Placed = Instance<Shared, Triangle>;

/// Gives out names from 10 on.
struct Naming : Recorder {
    std::vector<std::uint32_t> released;
    template <class P>
    std::uint32_t upload(const Source<P>&) {
        return 10 + std::uint32_t(paged_in++);
    }
    void release(std::uint32_t id) { released.push_back(id); }
};

}  // namespace

TEST_CASE("each hierarchy over its primitives is uploaded once, however often it is placed, and released once") {
    const Triangles triangles = random_triangles(50, 810), copy = triangles;
    const Shared h = build<Shared>(triangles);
    std::vector<Placed> instances;
    for (int i = 0; i < 5; ++i) {
        instances.push_back({&h, triangles, {}});
        instances.back().to_world.translation.x = i;
    }
    instances.push_back({&h, copy, {}});  // the same hierarchy over other memory
    const Loose outer = build<Loose>(instances);
    Naming renderer;
    {
        SourceTable<Naming> table(renderer);
        table.add_all(outer, std::span<const Placed>(instances));
        CHECK(renderer.paged_in == 3);
        const SourceState& a = table.find(outer, std::span<const Placed>(instances));
        const SourceState& b = table.find(h, std::span<const Triangle>(triangles));
        const SourceState& c = table.find(h, std::span<const Triangle>(copy));
        CHECK((a.id != b.id && b.id != c.id && a.id != c.id));
        CHECK(a.stamps.empty());
        CHECK(b.stamps.size() == 50);
        CHECK(renderer.released.empty());
    }
    std::sort(renderer.released.begin(), renderer.released.end());
    CHECK(renderer.released == std::vector<std::uint32_t>{10, 11, 12});
}

TEST_CASE("what was uploaded before something is refused is released") {
    const Triangles triangles = random_triangles(50, 811);
    const Shared h = build<Shared>(triangles);
    std::vector<Placed> instances{{&h, triangles, {}}, {&h, triangles, {}}};
    const Loose outer = build<Loose>(instances);
    instances[1].primitives = std::span(triangles).first(49);
    Naming renderer;
    try {
        SourceTable<Naming> table(renderer);
        table.add_all(outer, std::span<const Placed>(instances));
        FAIL("it was taken");
    } catch (const std::invalid_argument& e) {
        CHECK(std::string(e.what()) == "farfield::Viewer: the hierarchy was built from 50 primitives and is given 49");
    }
    CHECK(renderer.paged_in == renderer.released.size());
    CHECK(renderer.paged_in == 2);
}

TEST_CASE("an instance without a hierarchy is named") {
    const Triangles triangles = random_triangles(50, 812);
    const Shared h = build<Shared>(triangles);
    std::vector<Placed> instances(3, {&h, triangles, {}});
    const Loose outer = build<Loose>(instances);
    instances[1].hierarchy = nullptr;
    instances[1].to_world = {};
    Naming renderer;
    SourceTable<Naming> table(renderer);
    CHECK_THROWS_WITH(table.add_all(outer, std::span<const Placed>(instances)),
                      "farfield::Viewer: primitive 1 is an instance without a hierarchy");
}

TEST_CASE("sources in even steps of memory are told apart by their hashes") {
    // As in arrays of hierarchies and of meshes.
    for (const std::uintptr_t hierarchy_step : {16u, 64u, 1024u, 4096u}) {
        for (const std::uintptr_t primitive_step : {16u, 64u, 1024u, 4096u}) {
            std::set<std::size_t> hashes;
            for (std::uintptr_t i = 0; i < 5000; ++i) {
                const std::uintptr_t hierarchy = 0x7f0000001000u + i * hierarchy_step,
                                     primitives = 0x7f1000001000u + i * primitive_step;
                hashes.insert(detail::HashOfSourceKey{}(
                    {reinterpret_cast<const void*>(hierarchy), reinterpret_cast<const void*>(primitives)}));
            }
            CHECK(hashes.size() == 5000);
        }
    }
}

TEST_CASE("instances that were changed since are noticed") {
    const Triangles triangles = random_triangles(50, 813), others = random_triangles(60, 814);
    const Shared h = build<Shared>(triangles), other = build<Shared>(others);
    Naming renderer;
    SourceTable<Naming> table(renderer);
    table.add_all(h, std::span<const Triangle>(triangles));
    CHECK(table.has(h, std::span<const Triangle>(triangles)));
    CHECK_FALSE(table.has(other, std::span<const Triangle>(others)));
    CHECK_THROWS_AS(table.find(other, std::span<const Triangle>(others)), std::invalid_argument);
}

#ifndef NDEBUG
TEST_CASE("programs with assertions are told of other primitives of the same number") {
    const Triangles triangles = random_triangles(500, 815), others = random_triangles(500, 816);
    const Loose h = build<Loose>(triangles);
    std::vector<Instance<Loose, Triangle>> instances(3, {&h, triangles, {}});
    const Loose outer = build<Loose>(instances);
    const auto check = [](const auto& hierarchy, const auto& primitives) {
        Naming renderer;
        SourceTable<Naming> table(renderer);
        table.add_all(hierarchy, std::span(std::as_const(primitives)));
    };
    CHECK_NOTHROW(check(h, triangles));
    CHECK_NOTHROW(check(outer, instances));
    CHECK_THROWS_AS(check(h, others), std::invalid_argument);
    Triangles in_place = triangles;
    const Loose of_in_place = build_in_place<Loose>(in_place);
    CHECK_NOTHROW(check(of_in_place, in_place));
    CHECK_THROWS_AS(check(of_in_place, triangles), std::invalid_argument);  // the old copy
    instances[2].to_world.translation.x = 3;
    CHECK_THROWS_AS(check(outer, instances), std::invalid_argument);
}
#endif

TEST_CASE("a shared item is new once an epoch, also when epochs begin anew") {
    SourceState state;
    state.stamps.assign(3, 0);
    for (int round = 0; round < 3; ++round) {
        state.begin_epoch();
        CHECK(state.is_new(1));
        CHECK_FALSE(state.is_new(1));
        CHECK(state.is_new(0));
    }
    state.epoch = 0xffffffffu;
    state.stamps = {1, 0xffffffffu, 0};
    state.begin_epoch();
    CHECK(state.epoch != 0);
    for (std::uint32_t i = 0; i < 3; ++i) {
        CHECK(state.is_new(i));
        CHECK_FALSE(state.is_new(i));
    }
}

namespace {
/// A triangle, or an instance of a hierarchy over such things.
struct Link {
    std::variant<Triangle, Instance<Loose, Link>> is;

    BoxD bounds() const {
        if (const auto* instance = std::get_if<1>(&is)) return instance->bounds();
        const Box b = std::get<0>(is).bounds();
        return {glm::dvec3(b.lower), glm::dvec3(b.upper)};
    }
    template <class Sink>
    void polygons(Sink&& sink) const {
        std::visit([&](const auto& o) { o.polygons(sink); }, is);
    }
    template <class F>
    bool visit_instance(F&& f) const {
        const auto* instance = std::get_if<1>(&is);
        return instance && instance->visit_instance(f);
    }
};
}  // namespace

TEST_CASE("a hierarchy that came to hold itself is refused, not entered for ever") {
    std::vector<Link> links(1);
    links[0].is = random_triangles(1, 811)[0];
    Loose h = build<Loose>(links);
    std::vector<Link> ring{Link{Instance<Loose, Link>{&h, links, {}}}};
    // The hierarchy that the instance names is replaced by the one that holds it.
    ring[0].is = Instance<Loose, Link>{&h, ring, {}};
    h = build<Loose>(ring);
    Naming renderer;
    SourceTable<Naming> table(renderer);
    CHECK_THROWS_WITH(table.add_all(h, std::span<const Link>(ring)),
                      "farfield::Viewer: the hierarchy holds an instance of itself");
}
