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

    explicit SplitBsp(std::span<const Triangle> t, const BuildBudget& budget = {}, AnyExecutor e = {})
        : executor(std::move(e)), triangles(t), splitter(triangles, partition, Exact{}, cost, budget, control, data) {
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
        }
        // Pieces lie in the order of a descent.
        const Fragments fragments = split.data.fragments;
        std::size_t first = 0;
        for (std::vector<std::uint32_t> open{0}; !open.empty();) {
            const auto& draft = drafts[open.back()];
            open.pop_back();
            for (int c = std::popcount(draft.child_mask); c-- > 0;)
                open.push_back(draft.first_child + std::uint32_t(c));
            for (std::size_t i = first; i < first + draft.count; ++i) {
                const auto v = fragments[std::uint32_t(i)].vertices;
                glm::dvec3 sum(0);
                for (std::size_t k = 2; k < v.size(); ++k) {
                    sum += glm::cross(glm::dvec3(v[k - 1] - v[0]), glm::dvec3(v[k] - v[0]));
                }
                area[split.data.order[i]] += 0.5 * glm::length(sum);
                for (const glm::vec3& p : v) wrong += !draft.cell.bounds().contains(p);
            }
            first += draft.count;
        }
        CHECK(first == split.data.order.size());
        CHECK(wrong == 0);
        for (std::size_t n = 1; n < parents.size(); ++n) CHECK(parents[n] == 1);
        for (std::size_t i = 0; i < count; ++i) {
            CHECK(area[i] == Approx(double(triangles[i].area())).epsilon(1e-3).margin(1e-7));
        }
        CHECK(split.data.fragments.first_vertex.size() == split.data.order.size() + 1);
        CHECK(split.data.facts.report.polygons == count);
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
    SplitBsp none(triangles, {.memory_bytes = 1}), some(triangles, {.memory_bytes = 100000}), all(triangles);
    CHECK(none.splitter.drafts().size() == 1);
    CHECK(none.data.facts.report.cells_over_memory_budget == 1);
    CHECK(none.data.facts.report.cells_out_of_order == 1);
    CHECK(some.splitter.drafts().size() > 1);
    CHECK(some.splitter.drafts().size() < all.splitter.drafts().size());
    CHECK(all.data.facts.report.cells_out_of_order == 0);
}

namespace {

std::size_t pieces_of(const SplitBsp& split) {
    return split.data.order.size();
}

}  // namespace

TEST_CASE("triangles that all cross one another are cut into no more pieces than allowed, and that is counted") {
    const Triangles crossing = random_triangles(150, 753, 2.0f);
    SplitBsp all(crossing), some(crossing, {.pieces_per_polygon = 8, .free_pieces = 100});
    const std::size_t most = 8 * 150 + 100;
    CHECK(all.data.facts.report.cells_over_piece_budget == 0);
    REQUIRE(pieces_of(all) > 2 * most);
    CHECK(some.data.facts.report.cells_over_piece_budget > 0);
    CHECK(some.data.facts.report.cells_out_of_order >= some.data.facts.report.cells_over_piece_budget);
    const std::size_t pieces = pieces_of(some);
    CHECK(pieces <= most + 150);  // the last cell that was cut
    CHECK(pieces >= most);
    // Enough is no limit.
    SplitBsp enough(crossing, {.pieces_per_polygon = 8, .free_pieces = pieces_of(all)});
    CHECK(enough.data.facts.report.cells_over_piece_budget == 0);
    CHECK(pieces_of(enough) == pieces_of(all));
    CHECK(same_bytes(std::span<const glm::vec3>(all.data.fragments.vertices),
                     std::span<const glm::vec3>(enough.data.fragments.vertices)));
}

TEST_CASE("parts that are split by themselves share what pieces there may be, the same on any number of threads") {
    // A tangle beside much that is calm: its part needs more than its share.
    Triangles scene = scattered(6000, 754);
    for (const Triangle& t : random_triangles(80, 755, 0.4f)) {
        scene.push_back({{t.vertices[0] * 0.1f, t.vertices[1] * 0.1f, t.vertices[2] * 0.1f}, t.rgba});
    }
    SplitBsp all(scene);
    const std::size_t pieces = pieces_of(all);
    SplitBsp just_enough(scene, {.pieces_per_polygon = 1, .free_pieces = pieces - scene.size() + 1});
    CHECK(just_enough.data.facts.report.cells_over_piece_budget == 0);
    CHECK(pieces_of(just_enough) == pieces);
    SplitBsp serial(scene, {.pieces_per_polygon = 1, .free_pieces = 1000}),
        parallel(scene, {.pieces_per_polygon = 1, .free_pieces = 1000}, ThreadExecutor(3));
    CHECK(serial.data.facts.report.cells_over_piece_budget > 0);
    CHECK(pieces_of(serial) == pieces_of(parallel));
    CHECK(pieces_of(serial) <= scene.size() + 2000);
    CHECK(same_bytes(std::span<const std::uint32_t>(serial.data.order),
                     std::span<const std::uint32_t>(parallel.data.order)));
    CHECK(same_bytes(std::span<const glm::vec3>(serial.data.fragments.vertices),
                     std::span<const glm::vec3>(parallel.data.fragments.vertices)));
}
