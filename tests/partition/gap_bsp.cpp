#include "farfield/partition/gap_bsp.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <set>
#include <type_traits>

#include "catch.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/executor.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/spatial_hierarchy.hpp"
#include "farfield/storage/open.hpp"
#include "farfield/storage/save.hpp"
#include "support/scenes.hpp"
#include "support/triangle_in_box.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

template <Assignment assigned>
using Gaps = SpatialHierarchy<BasicGapBsp<assigned>, Exact, TriangleCount>;
using Unique = Gaps<Assignment::unique>;
using Shared = Gaps<Assignment::shared>;
using Clipped = Gaps<Assignment::clipped>;

/// A node as a descent finds it, children nearest to `eye` first.
struct Visited {
    Cell cell;
    std::uint32_t node = 0, first = 0, own_end = 0, end = 0;
    bool is_leaf = true;
};
template <class H>
std::vector<Visited> visited(const H& h, glm::vec3 eye = glm::vec3(0)) {
    std::vector<Visited> out;
    const std::function<void(const Cell&, std::uint32_t, std::uint32_t)> visit = [&](const Cell& cell, std::uint32_t n,
                                                                                     std::uint32_t end) {
        const Node& node = h.nodes()[n];
        const std::uint32_t own_end = node.child_mask != 0 ? h.nodes()[node.first_child].first_item : end;
        out.push_back({cell, n, node.first_item, own_end, end, node.child_mask == 0});
        ChildOrder order;
        h.partition_policy().front_to_back(cell, h.data_of(n), glm::vec4(eye, 1), order);
        for (unsigned i = 0; i < 8 && node.child_mask != 0; ++i) {
            if ((node.child_mask >> order[i] & 1) == 0) continue;
            const bool is_last = node.child_mask >> order[i] == 1;
            const std::uint32_t child =
                node.first_child + std::uint32_t(std::popcount(node.child_mask & ((1u << order[i]) - 1)));
            visit(h.partition_policy().child(cell, h.data_of(n), order[i]), child,
                  is_last ? end : h.nodes()[child + 1].first_item);
        }
    };
    if (h.item_count() != 0) visit(h.root_cell(), 0, h.item_count());
    return out;
}
template <class H>
std::vector<Visited> leaves(const H& h, glm::vec3 eye = glm::vec3(0)) {
    std::vector<Visited> all = visited(h, eye);
    all.erase(std::remove_if(all.begin(), all.end(), [](const Visited& v) { return !v.is_leaf; }), all.end());
    return all;
}

/// Balls of triangles on a jittered grid of n x n, with gaps between any two rows and columns.
Triangles orchard(int n, std::uint64_t seed) {
    Random random(seed);
    Triangles out;
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            const glm::vec3 at(float(i) + 0.2f * random.unit(), 0.3f * random.unit(), float(j) + 0.2f * random.unit());
            for (const Triangle& t : sphere(at, 0.3f, 4, random.color())) out.push_back(t);
        }
    }
    return out;
}

template <class H>
bool same(const H& a, const H& b) {
    const auto equal = [](const auto& x, const auto& y) {
        return x.size() == y.size() && (x.empty() || std::memcmp(x.data(), y.data(), x.size_bytes()) == 0);
    };
    return equal(a.nodes(), b.nodes()) && equal(a.all_node_data(), b.all_node_data()) && equal(a.order(), b.order()) &&
           equal(a.fragments().vertices, b.fragments().vertices) &&
           std::memcmp(&a.report(), &b.report(), sizeof(BuildReport)) == 0;
}

float overlap(const Box& a, const Box& b) {
    const glm::vec3 side = glm::min(a.upper, b.upper) - glm::max(a.lower, b.lower);
    return std::max(0.0f, std::min(side.x, std::min(side.y, side.z)));
}

template <class H>
std::vector<std::byte> saved(const H& h) {
    std::vector<std::byte> bytes(saved_size(h));
    save(h, std::span(bytes));
    return bytes;
}

}  // namespace

static_assert(Partition<GapBsp> && PlacesItems<GapBsp> && !CutsItems<GapBsp>);
static_assert(Partition<SharedGapBsp> && PlacesItems<SharedGapBsp> && !CutsItems<SharedGapBsp>);
static_assert(Partition<ClippedGapBsp> && CutsItems<ClippedGapBsp> && !PlacesItems<ClippedGapBsp>);
static_assert(Unique::assignment == Assignment::unique && Shared::assignment == Assignment::shared &&
              Clipped::assignment == Assignment::clipped);

TEST_CASE("where there are gaps nothing is split") {
    const Triangles triangles = orchard(9, 150);
    const Unique h = build<Unique>(triangles);
    CHECK(h.item_count() == triangles.size());
    const auto all = leaves(h);
    CHECK(all.size() >= 81);
    float deepest = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
        for (std::size_t j = i + 1; j < all.size(); ++j) {
            // Those that hold one tree each; within trees triangles share corners.
            if (all[i].cell.depth <= 6 && all[j].cell.depth <= 6) {
                deepest = std::max(deepest, overlap(all[i].cell.bounds(), all[j].cell.bounds()));
            }
        }
    }
    CHECK(deepest < 0.01f);
    const Clipped clipped = build<Clipped>(triangles);
    std::set<std::uint32_t> cut;
    for (std::uint32_t i = 0; i < clipped.item_count(); ++i) cut.insert(clipped.order()[i]);
    CHECK(clipped.report().cells_that_cannot_be_told_apart == 0);
    CHECK(visited(clipped).size() > 81);
}

TEST_CASE("a hierarchy over gaps is balanced, and its planes lie across its directions") {
    const Triangles triangles = sheet({0, 0, 0}, {64, 0, 0}, {0, 0, 64}, 64, 64, {9, 9, 9, 255});
    const Unique h = build<Unique>(triangles);
    CHECK(h.report().levels <= 14);
    for (const Visited& v : visited(h)) {
        if (v.is_leaf) continue;
        const glm::vec3 n = h.data_of(v.node).plane.normal;
        CHECK((n == glm::vec3(1, 0, 0) || n == glm::vec3(0, 0, 1)));
    }
    INFO("the grid's lines are gaps: no cell reaches into another one");
    const auto all = leaves(h);
    for (std::size_t i = 0; i + 1 < all.size(); ++i) {
        const glm::vec3 side = glm::min(all[i].cell.bounds().upper, all[i + 1].cell.bounds().upper) -
                               glm::max(all[i].cell.bounds().lower, all[i + 1].cell.bounds().lower);
        CHECK(std::min(side.x, side.z) < 0.3f);
    }
}

TEST_CASE("the longest extent is cut first") {
    Triangles row;
    for (int i = 0; i < 16; ++i) {
        for (int j = 0; j < 4; ++j) append(row, sphere({float(i), 0, float(j)}, 0.3f, 4, {9, 9, 9, 255}));
    }
    const Unique h = build<Unique>(row);
    for (const Visited& v : visited(h)) {
        if (v.cell.depth < 2) CHECK(h.data_of(v.node).plane.normal == glm::vec3(1, 0, 0));
    }
}

TEST_CASE("directions may be any") {
    for (const unsigned count : {1u, 2u, 3u, 5u, 8u}) {
        GapBsp partition = GapBsp::around({0, 1, 0}, count);
        REQUIRE(detail::wrong_option(partition) == nullptr);
        for (unsigned i = 0; i < count; ++i) {
            CHECK(glm::length(partition.directions[i]) == Approx(1));
            CHECK(partition.directions[i].y == 0);
        }
    }
    CHECK(GapBsp::around({0, 1, 0}).directions[0] == glm::vec3(1, 0, 0));
    CHECK(std::abs(GapBsp::around({0, 1, 0}).directions[1].z) == 1);
    CHECK(std::abs(GapBsp::around({0, 0, 1}).directions[1].y) == 1);
    INFO("a gap across a diagonal is found along the diagonal");
    Triangles two;
    for (int i = 0; i < 12; ++i) {
        append(two, sphere({float(i), 0, float(i)}, 0.3f, 5, {9, 9, 9, 255}));
        append(two, sphere({float(i) + 1, 0, float(i) - 1}, 0.3f, 5, {9, 9, 9, 255}));
    }
    GapBsp diagonal;
    diagonal.directions = {glm::vec3(3, 0, -3)};
    const Unique h = build<Unique>(two, {.partition = diagonal});
    const auto all = visited(h);
    CHECK(all[1].end - all[1].first == two.size() / 2);
    CHECK(h.data_of(0).plane.normal.x == Approx(std::sqrt(0.5f)));
}

TEST_CASE("what the directions do not tell apart the axes do") {
    // All of them cross every plane along the pole.
    Triangles pole;
    for (int i = 0; i < 900; ++i) {
        const float y = float(i);
        pole.push_back({{glm::vec3(-1, y, -1), glm::vec3(1, y, -1), glm::vec3(0, y + 0.5f, 1)}, {9, 9, 9, 255}});
    }
    const Unique h = build<Unique>(pole);
    CHECK(h.report().levels >= 5);
    for (const Visited& v : visited(h)) {
        if (!v.is_leaf) CHECK(h.data_of(v.node).plane.normal == glm::vec3(0, 1, 0));
    }
}

TEST_CASE("cells come from front to back along every ray") {
    const Triangles triangles = orchard(7, 151);
    Random random(152);
    const auto check = [&](const auto& h) {
        std::size_t wrong = 0, met = 0;
        for (int i = 0; i < 200; ++i) {
            const glm::vec3 eye = glm::vec3(3, 0.2f, 3) + random.in_cube(6) * glm::vec3(1, 0.05f, 1);
            const glm::vec3 to = glm::vec3(3, 0.2f, 3) + random.in_cube(4) * glm::vec3(1, 0.05f, 1);
            const glm::vec3 along = glm::normalize(to - eye);
            float last = -1;
            for (const Visited& v : leaves(h, eye)) {
                const glm::vec3 a = (v.cell.bounds().lower - eye) / along, b = (v.cell.bounds().upper - eye) / along;
                const glm::vec3 in = glm::min(a, b), out = glm::max(a, b);
                const float from = std::max(0.0f, std::max(in.x, std::max(in.y, in.z))),
                            end = std::min(out.x, std::min(out.y, out.z));
                if (!(from < end)) continue;
                ++met;
                // Bounds are kept in 255 steps.
                wrong += end < last - 0.05f && from < last - 0.05f;
                last = std::max(last, from);
            }
        }
        CHECK(met > 300);
        return double(wrong) / double(met);
    };
    INFO("without overlap all of it, and nearly all where single triangles share corners");
    CHECK(check(build<Clipped>(triangles)) == 0);
    GapBsp coarse;
    coarse.max_depth = 5;
    CHECK(check(build<Unique>(triangles, {.partition = coarse})) == 0);
}

TEST_CASE("inflated regions hold all that touches them, and no more") {
    const Triangles wall = sheet({-1, -1, 0.25f}, {2, 0, 0}, {0, 2, 0}, 40, 40, {9, 9, 9, 255});
    Triangles scene = wall;
    append(scene, mixed_triangles(600, 153));
    for (const float inflation : {0.0f, 0.1f, 0.17f, 0.5f}) {
        INFO("inflation " << inflation);
        SharedGapBsp partition = SharedGapBsp::along_axes();
        partition.inflation = inflation;
        const Shared h = build<Shared>(scene, {.partition = partition});
        CHECK(h.item_count() >= scene.size());
        CHECK(h.item_count() < 8 * scene.size());
        std::size_t missing = 0, far_off = 0, uncovered = 0;
        std::set<std::uint32_t> anywhere;
        for (const Visited& v : visited(h)) {
            std::set<std::uint32_t> own;
            for (std::uint32_t i = v.first; i < v.own_end; ++i) own.insert(h.order()[i]);
            anywhere.insert(own.begin(), own.end());
            if (!v.is_leaf) {
                CHECK(own.empty());
                continue;
            }
            const float hair = 1e-5f;
            const Box region{v.cell.bounds().lower + hair, v.cell.bounds().upper - hair};
            const Box wide{v.cell.bounds().lower - hair, v.cell.bounds().upper + hair};
            for (std::uint32_t i = 0; i < scene.size(); ++i) {
                missing += !own.count(i) && region.lower.x < region.upper.x && region.lower.y < region.upper.y &&
                           region.lower.z < region.upper.z && touches_by_clipping(scene[i], region);
                far_off += inflation == 0 && own.count(i) && !touches_by_clipping(scene[i], wide);
            }
            // Wherever an image of the leaf may be looked at near its border there is wall.
            for (int k = 0; k < 9; ++k) {
                glm::vec3 p =
                    region.lower + (region.upper - region.lower) * glm::vec3(float(k % 3), float(k / 3), 0) * 0.5f;
                p.z = 0.25f;
                if (!region.contains(p) || std::abs(p.x) > 1 || std::abs(p.y) > 1) continue;
                bool is_covered = false;
                for (const std::uint32_t i : own) {
                    if (i >= wall.size()) continue;
                    Box b = Box::empty();
                    for (const glm::vec3& c : wall[i].vertices) b.add(c);
                    b.lower -= hair;
                    b.upper += hair;
                    is_covered = is_covered || b.contains(p);
                }
                uncovered += !is_covered;
            }
        }
        CHECK(missing == 0);
        CHECK(far_off == 0);
        CHECK(uncovered == 0);
        CHECK(anywhere.size() == scene.size());
    }
}

TEST_CASE("degenerate input builds, and nothing is lost") {
    const Triangle one = random_triangles(1, 154, 0.1f)[0];
    std::vector<std::pair<const char*, Triangles>> scenes{{"nothing", {}}, {"one", {one}}, {"two equal", {one, one}}};
    scenes.emplace_back("two", random_triangles(2, 155, 0.1f));
    scenes.emplace_back("all equal", Triangles(700, one));
    Triangles points, line, huge = random_triangles(900, 156, 0.01f);
    for (int i = 0; i < 500; ++i) {
        const glm::vec3 p = glm::vec3(1, 2, 3) * (0.01f * float(i % 250));
        points.push_back({{glm::vec3(1), glm::vec3(1), glm::vec3(1)}, one.rgba});
        line.push_back({{p, p + glm::vec3(0.001f, 0, 0), p}, one.rgba});
    }
    huge.push_back({{glm::vec3(-9, -9, -9), glm::vec3(9, -9, 9), glm::vec3(0, 9, 0)}, one.rgba});
    scenes.emplace_back("one point", points);
    scenes.emplace_back("a line", line);
    scenes.emplace_back("one huge among many tiny", huge);
    scenes.emplace_back("all large", random_triangles(600, 157, 1));
    Triangles scales;
    for (int i = 0; i < 400; ++i) {
        const float s = std::ldexp(1.0f, -(i % 100));
        scales.push_back({{glm::vec3(s), glm::vec3(s, 1.5f * s, s), glm::vec3(s, s, 1.5f * s)}, one.rgba});
    }
    scenes.emplace_back("of every scale", scales);
    for (const auto& [name, triangles] : scenes) {
        INFO(name);
        const Unique unique = build<Unique>(triangles);
        CHECK(unique.item_count() == triangles.size());
        CHECK(unique.nodes().size() <= 2 * triangles.size() + 1);
        const Shared shared = build<Shared>(triangles);
        std::set<std::uint32_t> anywhere;
        for (std::uint32_t i = 0; i < shared.item_count(); ++i)
            anywhere.insert(shared.order().empty() ? i : shared.order()[i]);
        CHECK(anywhere.size() == triangles.size());
        CHECK(shared.item_count() <= 64 * triangles.size());
        const Clipped clipped = build<Clipped>(triangles);
        CHECK(clipped.report().cells_out_of_order == 0);
        CHECK(clipped.item_count() <= 20 * triangles.size());
        for (const Visited& v : visited(unique)) {
            Box bounds = Box::empty();
            for (std::uint32_t i = v.first; i < v.end; ++i) {
                bounds.add(triangles[unique.order().empty() ? i : unique.order()[i]].bounds());
            }
            const Box cell = v.cell.bounds();
            for (int axis = 0; axis < 3; ++axis) {
                CHECK(cell.lower[axis] <= bounds.lower[axis]);
                CHECK(cell.upper[axis] >= bounds.upper[axis]);
            }
        }
    }
    INFO("the huge one stays at the top and fattens no cell");
    const Unique h = build<Unique>(huge);
    CHECK(visited(h)[0].own_end - visited(h)[0].first <= 1);
    const auto all = leaves(h);
    std::size_t fat = 0;
    for (const Visited& v : all) fat += v.cell.largest_side() > 2;
    CHECK(fat <= 1);
}

TEST_CASE("any number of threads builds the same") {
    const Triangles triangles = mixed_triangles(5000, 158);
    const auto check = [&]<class H>(std::type_identity<H>) {
        const H serial = build<H>(triangles);
        for (const unsigned threads : {2u, 3u, 8u}) {
            CHECK(same(serial, build<H>(triangles, {.executor = ThreadExecutor(threads)})));
        }
    };
    check(std::type_identity<Unique>());
    check(std::type_identity<Shared>());
    check(std::type_identity<Clipped>());
}

TEST_CASE("the same trees come out at any scale") {
    const Triangles triangles = mixed_triangles(3000, 159);
    const Unique h = build<Unique>(triangles);
    for (const float scale : {0x1p-60f, 0x1p50f}) {
        Triangles scaled = triangles;
        for (Triangle& t : scaled) {
            for (glm::vec3& v : t.vertices) v *= scale;
        }
        const Unique s = build<Unique>(scaled);
        CHECK(s.nodes().size() == h.nodes().size());
        CHECK(std::equal(s.order().begin(), s.order().end(), h.order().begin(), h.order().end()));
    }
}

TEST_CASE("files are opened as they were saved, and what is forged is refused") {
    const Triangles triangles = mixed_triangles(2000, 160);
    const auto check = [&]<class H>(std::type_identity<H>, const typename H::partition_type& partition) {
        const H h = build<H>(triangles, {.partition = partition});
        const std::vector<std::byte> bytes = saved(h);
        const H opened = open<H>(std::span<const std::byte>(bytes));
        CHECK(same(h, opened));
        CHECK(opened.partition_policy().directions == partition.directions);
        CHECK(opened.partition_policy().inflation == partition.inflation);
        CHECK(visited(opened).size() == visited(h).size());
    };
    check(std::type_identity<Unique>(), GapBsp::around({0, 0, 1}, 3));
    check(std::type_identity<Shared>(), SharedGapBsp{.inflation = 0.17f});
    check(std::type_identity<Clipped>(), {});
    GapBsp::node_data data{};
    CHECK(GapBsp().is_sound(data));
    data.plane.offset = std::numeric_limits<float>::quiet_NaN();
    CHECK_FALSE(GapBsp().is_sound(data));
    data.plane = {{0, std::numeric_limits<float>::infinity(), 0}, 0};
    CHECK_FALSE(GapBsp().is_sound(data));
}

TEST_CASE("wrong options are refused by name") {
    const auto refused = [](auto partition, const char* part) {
        const char* why = detail::wrong_option(partition);
        return why != nullptr && std::strstr(why, part) != nullptr;
    };
    GapBsp none, unheard_of, weighed, deep;
    none.directions = {};
    unheard_of.directions[1].x = std::numeric_limits<float>::quiet_NaN();
    weighed.price_of_split = -1;
    deep.max_depth = 2000;
    CHECK(refused(none, "at least one direction"));
    CHECK(refused(unheard_of, "not finite"));
    CHECK(refused(weighed, "price_of_split"));
    CHECK(refused(deep, "max_depth"));
    CHECK(refused(GapBsp{.inflation = 0.1f}, "only where primitives are shared"));
    CHECK(refused(ClippedGapBsp{.inflation = 0.1f}, "only where primitives are shared"));
    CHECK(refused(SharedGapBsp{.inflation = 2}, "inflation must be"));
    CHECK(refused(SharedGapBsp::around({0, 1, 0}, 3), "along the axes"));
    CHECK(detail::wrong_option(SharedGapBsp::around({0, 1, 0}, 2)) == nullptr);
    CHECK(detail::wrong_option(SharedGapBsp::along_axes()) == nullptr);
}

TEST_CASE("directions are good at any length") {
    using Hierarchy = SpatialHierarchy<GapBsp, Exact, TriangleCount>;
    const auto triangles = random_triangles(2000, 91, 0.02f);
    GapBsp partition;
    partition.directions[0] = {1, 0.25f, 0.5f};
    const auto expected = build<Hierarchy>(triangles, {.partition = partition});
    for (const int exponent : {-110, -70, 70, 110}) {
        GapBsp other = partition;
        for (glm::vec3& d : other.directions) d *= std::ldexp(1.0f, exponent);
        REQUIRE(detail::wrong_option(other) == nullptr);
        const auto h = build<Hierarchy>(triangles, {.partition = other});
        CHECK(h.nodes().size() == expected.nodes().size());
        CHECK(std::equal(h.order().begin(), h.order().end(), expected.order().begin(), expected.order().end()));
    }
}
