#include "farfield/build/cell_splitter.hpp"

#include <algorithm>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/triangle.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

namespace {

/// Prices in whole numbers.
struct Prices {
    static constexpr const char* unit = "pieces";
    static constexpr std::uint32_t file_tag = 0;
    float triangle = 1, splat = 1, cell = 1, run = 1;
    float cost(const Work& w) const {
        return triangle * w.triangles + splat * w.splats + cell * w.cells + run * w.runs;
    }
};

template <class Partition_, class A>
struct Split_ {
    Partition_ partition;
    A approximation;
    Prices prices;
    AnyExecutor executor;
    ProgressCallback progress;
    BuildControl control{executor, progress};
    HierarchyData<Partition_, A> data{};
    std::span<const Triangle> triangles;
    CellSplitter<Partition_, A, Prices, Triangle> splitter;

    explicit Split_(std::span<const Triangle> t, Prices p = {}, Partition_ q = {}, std::uint64_t budget = 0)
        : partition(q),
          prices(p),
          triangles(t),
          splitter(triangles, partition, approximation, prices, {.memory_bytes = budget}, control, data) {
        splitter.split();
    }
    Split_(const Split_&) = delete;
    const BuildReport& report() const { return data.facts.report; }
    std::size_t nodes() { return splitter.drafts().size(); }
};
using ExactSplit = Split_<Octree, Exact>;
using CubeSplit = Split_<Octree, ColorCube>;
using SharedSplit = Split_<SharedOctree, Exact>;

/// As many small triangles in each octant of [-1, 1]^3.
Triangles in_octants(std::size_t in_each) {
    Random random(740);
    Triangles out;
    for (unsigned octant = 0; octant < 8; ++octant) {
        const glm::vec3 center(octant & 1 ? 0.5f : -0.5f, octant & 2 ? 0.5f : -0.5f, octant & 4 ? 0.5f : -0.5f);
        for (std::size_t i = 0; i < in_each; ++i) {
            const glm::vec3 at = center + random.in_cube(0.4f);
            out.push_back({{at, at + glm::vec3(0.01f, 0, 0), at + glm::vec3(0, 0.01f, 0)}, {}});
        }
    }
    return out;
}

}  // namespace

TEST_CASE("without stand-ins a split has to earn its cells and runs by culling half of what is in it") {
    // Eight children of 4 pieces cost 8 (cell + run); half of what they hold is 16.
    const Triangles triangles = in_octants(4);
    CHECK(ExactSplit(triangles, {.cell = 0.75f, .run = 1.25f}).nodes() == 1);
    CHECK(ExactSplit(triangles, {.cell = 0.7f, .run = 1.25f}).nodes() == 9);
    CHECK(ExactSplit(triangles, {.cell = 0.75f, .run = 1.2f}).nodes() == 9);
    CHECK(ExactSplit(triangles, {.triangle = 1.02f, .cell = 0.75f, .run = 1.25f}).nodes() == 9);
    CHECK(ExactSplit(triangles, {.triangle = 0.98f, .cell = 0.7f, .run = 1.25f}).nodes() == 9);
    CHECK(ExactSplit(triangles, {.triangle = 0.96f, .cell = 0.7f, .run = 1.25f}).nodes() == 1);
    CHECK(ExactSplit(triangles, {.cell = 0.75f, .run = 1.25f}).report().splits_that_would_not_pay == 1);
}

TEST_CASE("with stand-ins a split has to hold more than the children's stand-ins cost") {
    // "no more than the cost of rendering the color-cube approximations of the children" (1996, section 4).
    const Triangles triangles = in_octants(4);
    CHECK(CubeSplit(triangles, {.splat = 4}).nodes() == 1);
    CHECK(CubeSplit(triangles, {.splat = 3.96f}).nodes() == 9);
    CHECK(CubeSplit(triangles, {.splat = 4}).report().splits_that_would_not_pay == 1);
    // Of cells and runs nothing depends here.
    CHECK(CubeSplit(triangles, {.splat = 3.96f, .cell = 1000, .run = 1000}).nodes() == 9);
}

TEMPLATE_TEST_CASE("every primitive is kept where it lies, once for each cell that has it", "", ExactSplit, CubeSplit,
                   SharedSplit) {
    for (const std::size_t count : {0u, 1u, 3000u}) {
        const Triangles triangles = mixed_triangles(count, 741);
        TestType split(triangles, {.splat = 0.5f, .cell = 0.01f, .run = 0.01f});
        std::vector<int> times(count);
        std::size_t wrong = 0, kept = 0;
        for (const auto& draft : split.splitter.drafts()) {
            split.data.order.clear();
            split.splitter.append_items(draft);
            CHECK(split.data.order.size() == draft.count);
            kept += draft.count;
            float cost = 0;
            for (const std::uint32_t i : split.data.order) {
                ++times[i];
                ++cost;
                // Shared items touch their cell, loose ones lie within its bounds.
                const Box bounds = draft.cell.bounds();
                wrong += !Box{bounds.lower - 1e-5f, bounds.upper + 1e-5f}.intersects(triangles[i].bounds());
            }
            if (!decltype(split.splitter)::items_are_shared) CHECK(draft.cost == cost);
            CHECK(draft.is_leaf == (draft.child_mask == 0));
        }
        CHECK(wrong == 0);
        if (split.splitter.items_are_shared) {
            CHECK(std::all_of(times.begin(), times.end(), [](int n) { return n >= 1; }));
        } else {
            CHECK(std::all_of(times.begin(), times.end(), [](int n) { return n == 1; }));
        }
        CHECK(split.report().primitives == count);
        if (count > 1000) CHECK(split.nodes() > 50);
    }
}

TEST_CASE("parents come before children, level by level, and blocks of siblings without gaps") {
    ExactSplit split(mixed_triangles(3000, 742), {.cell = 0.01f, .run = 0.01f});
    const auto& drafts = split.splitter.drafts();
    std::size_t next = 1;
    for (std::size_t n = 0; n < drafts.size(); ++n) {
        if (n > 0) CHECK(drafts[n].cell.depth >= drafts[n - 1].cell.depth);
        if (drafts[n].child_mask == 0) continue;
        CHECK(drafts[n].first_child == next);
        for (int c = std::popcount(drafts[n].child_mask); c > 0; --c) {
            CHECK(drafts[next++].cell.depth == drafts[n].cell.depth + 1);
        }
    }
    CHECK(next == drafts.size());
    CHECK(split.report().levels == drafts.back().cell.depth + 1u);
}

TEST_CASE("small cells are split at last, into the cells that level by level they are split into") {
    // With a budget of memory all is split level by level.
    constexpr std::uint64_t plenty = std::uint64_t(1) << 50;
    const Prices cheap{.splat = 0.5f, .cell = 0.01f, .run = 0.01f};
    for (const std::size_t count : {0u, 1u, 16384u, 16385u, 60'000u}) {
        Triangles triangles = mixed_triangles(count, 743);
        // Some in one place, which end at the depth limit or cannot be told apart.
        for (std::size_t i = 0; i < count / 50; ++i) triangles[i] = triangles[0];
        CubeSplit late(triangles, cheap), by_level(triangles, cheap, {}, plenty);
        const auto &a = late.splitter.drafts(), &b = by_level.splitter.drafts();
        REQUIRE(a.size() == b.size());
        std::size_t wrong = 0;
        for (std::size_t n = 0; n < a.size(); ++n) {
            late.data.order.clear();
            by_level.data.order.clear();
            late.splitter.append_items(a[n]);
            by_level.splitter.append_items(b[n]);
            wrong += late.data.order != by_level.data.order || a[n].cell.center != b[n].cell.center ||
                     a[n].cell.half != b[n].cell.half || a[n].child_mask != b[n].child_mask ||
                     (a[n].child_mask != 0 && a[n].first_child != b[n].first_child) || a[n].cost != b[n].cost ||
                     a[n].is_leaf != b[n].is_leaf || a[n].count != b[n].count;
        }
        CHECK(wrong == 0);
        const BuildReport &r = late.report(), &s = by_level.report();
        CHECK(r.levels == s.levels);
        CHECK(r.empty_cells_pruned == s.empty_cells_pruned);
        CHECK(r.splits_that_would_not_pay == s.splits_that_would_not_pay);
        CHECK(r.cells_at_depth_limit == s.cells_at_depth_limit);
        CHECK(r.cells_that_cannot_be_told_apart == s.cells_that_cannot_be_told_apart);
    }
}

TEST_CASE("what ends a split is counted") {
    const Triangles triangles = in_octants(40);
    const Prices cheap{.cell = 0.001f, .run = 0.001f};
    CHECK(ExactSplit(triangles, cheap, {.max_depth = 1}).report().cells_at_depth_limit == 8);
    CHECK(ExactSplit(triangles, cheap, {.max_depth = 0}).nodes() == 1);
    // All in one place.
    const Triangles same(50, triangles[0]);
    ExactSplit one_place(same, cheap);
    CHECK(one_place.report().cells_that_cannot_be_told_apart <= 1);
    CHECK(one_place.nodes() < 40);
    // A budget ends it at a level's end.
    ExactSplit over(triangles, cheap, {}, 1);
    CHECK(over.nodes() == 1);
    CHECK(over.report().cells_over_memory_budget == 1);
    CHECK(ExactSplit(triangles, cheap, {}, 1 << 30).report().cells_over_memory_budget == 0);
}

TEST_CASE("the cost of a shared item is divided among its cells") {
    // A triangle across all octants, and enough small ones that the root is split: (1996, section 4).
    Triangles triangles = in_octants(8);
    triangles.push_back({{{{-0.9f, -0.9f, -0.9f}, {0.9f, 0.9f, 0.9f}, {-0.9f, 0.9f, 0.1f}}}, {}});
    SharedSplit split(triangles, {.cell = 0.5f, .run = 0.5f}, {.max_depth = 1});
    REQUIRE(split.nodes() == 9);
    std::size_t cells = 0;
    float total = 0;
    for (const auto& draft : split.splitter.drafts()) {
        split.data.order.clear();
        split.splitter.append_items(draft);
        cells += std::size_t(std::count(split.data.order.begin(), split.data.order.end(), 64u));
        total += draft.cost;
    }
    CHECK(cells > 2);
    CHECK(total == Approx(65));
}
