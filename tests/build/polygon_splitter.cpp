// Where polygons are cut: the part below a small cell is split by itself, and put where it would have been.
#include "farfield/build/polygon_splitter.hpp"

#include <cstring>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/polygon_bsp.hpp"
#include "farfield/primitive/triangle.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

namespace {

using Bsp = SpatialHierarchy<PolygonBsp, Exact, TriangleCount>;

struct SplitBsp {
    PolygonBsp partition;
    TriangleCount cost;
    AnyExecutor executor;
    ProgressCallback progress;
    BuildControl control{executor, progress};
    HierarchyData<PolygonBsp, Exact> data{};
    std::span<const Triangle> triangles;
    PolygonSplitter<PolygonBsp, Exact, TriangleCount, Triangle> splitter;

    explicit SplitBsp(std::span<const Triangle> t, std::uint64_t budget = 0)
        : triangles(t), splitter(triangles, partition, Exact{}, cost, budget, control, data) {
        splitter.split();
    }
    SplitBsp(const SplitBsp&) = delete;
};

template <class T>
bool same_bytes(std::span<const T> a, std::span<const T> b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

/// No two in one plane, so that what joins triangles has nothing to do.
Triangles scattered(std::size_t count, std::uint64_t seed) {
    return random_triangles(count, seed, 0.03f);
}

}  // namespace

TEST_CASE("cells are a tree, and what they keep are pieces of all that was given") {
    for (const std::size_t count : {0u, 1u, 300u, 5000u}) {
        const Triangles triangles = scattered(count, 750);
        SplitBsp split(triangles);
        const auto& drafts = split.splitter.drafts();
        std::vector<int> parents(drafts.size());
        std::vector<double> area(count);
        std::size_t wrong = 0;
        float cost = 0;
        for (std::size_t n = 0; n < drafts.size(); ++n) {
            const int children = std::popcount(drafts[n].child_mask);
            if (children != 0) wrong += drafts[n].first_child <= n;
            for (int c = 0; c < children; ++c) {
                ++parents[drafts[n].first_child + unsigned(c)];
                wrong += drafts[drafts[n].first_child + unsigned(c)].cell.depth != drafts[n].cell.depth + 1;
            }
            wrong += (children == 0) != drafts[n].is_leaf;
            cost += drafts[n].cost;
            const std::size_t before = split.data.order.size();
            split.splitter.append_items(drafts[n]);
            const Fragments fragments = split.data.fragments;
            for (std::size_t i = before; i < split.data.order.size(); ++i) {
                const auto v = fragments[std::uint32_t(i)].vertices;
                glm::dvec3 sum(0);
                for (std::size_t k = 2; k < v.size(); ++k) {
                    sum += glm::cross(glm::dvec3(v[k - 1] - v[0]), glm::dvec3(v[k] - v[0]));
                }
                area[split.data.order[i]] += 0.5 * glm::length(sum);
                for (const glm::vec3& p : v) wrong += !drafts[n].cell.bounds().contains(p);
            }
        }
        CHECK(wrong == 0);
        for (std::size_t n = 1; n < parents.size(); ++n) CHECK(parents[n] == 1);
        for (std::size_t i = 0; i < count; ++i) {
            CHECK(area[i] == Approx(double(triangles[i].area())).epsilon(1e-3).margin(1e-7));
        }
        CHECK(split.data.fragments.first_vertex.size() == split.data.order.size() + 1);
        // A triangle's cost goes to each of its pieces, by their triangles: never less than the whole.
        CHECK(cost >= float(count));
        CHECK(split.data.facts.report.levels >= (count == 0 ? 0u : 1u));
    }
}

TEST_CASE("what is split by itself is what would have been split with the rest") {
    // A budget that is never reached has everything split at once.
    const Triangles triangles = scattered(6000, 751);
    const Bsp apart = build<Bsp>(triangles),
              together = build<Bsp>(triangles, {.memory_budget_bytes = std::uint64_t(1) << 40});
    CHECK(same_bytes(apart.nodes(), together.nodes()));
    CHECK(same_bytes(apart.all_node_data(), together.all_node_data()));
    CHECK(same_bytes(apart.order(), together.order()));
    CHECK(same_bytes(apart.fragments().first_vertex, together.fragments().first_vertex));
    CHECK(same_bytes(apart.fragments().vertices, together.fragments().vertices));
    CHECK(std::memcmp(&apart.report(), &together.report(), sizeof(BuildReport)) == 0);
}

TEST_CASE("a budget ends cutting, and cells that are then out of order are counted") {
    const Triangles triangles = scattered(2000, 752);
    SplitBsp none(triangles, 1), some(triangles, 100000), all(triangles);
    CHECK(none.splitter.drafts().size() == 1);
    CHECK(none.data.facts.report.cells_over_memory_budget == 1);
    CHECK(none.data.facts.report.cells_out_of_order == 1);
    CHECK(some.splitter.drafts().size() > 1);
    CHECK(some.splitter.drafts().size() < all.splitter.drafts().size());
    CHECK(all.data.facts.report.cells_out_of_order == 0);
}
