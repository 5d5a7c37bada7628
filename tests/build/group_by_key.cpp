#include "farfield/build/group_by_key.hpp"

#include <algorithm>
#include <array>
#include <random>
#include <set>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/approximation/sample_set.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/drawables.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/partition/polygon_bsp.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/update.hpp"
#include "farfield/viewer.hpp"

using namespace farfield;

namespace {

struct Piece : Triangle {
    std::uint32_t material = 0;
    std::uint32_t key() const { return material; }
};
static_assert(PrimitiveWithKey<Piece> && !PrimitiveWithKey<Triangle>);

std::vector<Piece> pieces(std::size_t count, std::uint32_t materials) {
    std::mt19937 random(5);
    const auto number = [&] { return float(random() % 2000) / 1000 - 1; };
    std::vector<Piece> all(count);
    for (Piece& p : all) {
        const glm::vec3 a(number(), number(), number());
        p.vertices = {a, a + 0.05f * glm::vec3(number(), number(), number()),
                      a + 0.05f * glm::vec3(number(), number(), number())};
        p.rgba = {std::uint8_t(random()), 100, 100, 255};
        p.material = std::uint32_t(materials == 0 ? random() : random() % materials * 1000);
    }
    return all;
}
std::vector<Triangle> without_keys(const std::vector<Piece>& pieces) {
    return {pieces.begin(), pieces.end()};
}

/// Calls f(first, end) for the own run of each node.
template <class H, class F>
void for_each_run(const H& h, F&& f) {
    for (std::uint32_t n = 0; n < h.nodes().size(); ++n) {
        const Node& node = h.nodes()[n];
        std::uint32_t end = h.item_count();
        if (node.child_mask != 0) {
            end = h.nodes()[node.first_child].first_item;
        } else {  // what comes next
            for (const Node& other : h.nodes()) {
                if (other.first_item > node.first_item) end = std::min(end, other.first_item);
            }
        }
        f(node.first_item, std::max(end, node.first_item));
    }
}

template <class A>
using HierarchyOf = SpatialHierarchy<Octree, A, TriangleCount>;

struct Counter {
    static constexpr RendererFacts facts{.draws_faces = true};
    std::size_t ranges = 0, batches = 0, primitives = 0;
    std::set<std::uint32_t> keys;
    void begin_frame(const LocalView&) { *this = {}; }
    void set_view(const LocalView&) {}
    void draw(const Source<Piece>& source, std::span<const Range> all) {
        for (const Range& range : all) {
            ++ranges;
            for_each_key(source, range, [&](std::uint32_t key, const Range& part) {
                ++batches;
                primitives += part.count;
                keys.insert(key);
                for (std::uint32_t i = part.first; i < part.first + part.count; ++i) CHECK(source[i].key() == key);
            });
        }
    }
    void draw(std::span<const Face>) {}
    void end_frame() {}
};

template <class A>
void check_runs(std::uint32_t materials) {
    using H = HierarchyOf<A>;
    const std::vector<Piece> all = pieces(3000, materials);
    const H grouped = build<H>(all), plain = build<H>(without_keys(all));
    CHECK(std::ranges::equal(grouped.nodes(), plain.nodes()));
    CHECK(grouped.stand_ins().size() == plain.stand_ins().size());
    for_each_run(grouped, [&](std::uint32_t first, std::uint32_t end) {
        std::vector<std::uint32_t> wanted(plain.order().begin() + first, plain.order().begin() + end);
        std::ranges::stable_sort(wanted, {}, [&](std::uint32_t i) { return all[i].material; });
        CHECK(std::equal(wanted.begin(), wanted.end(), grouped.order().begin() + first));
    });
}

}  // namespace

TEST_CASE("runs hold what they held, by their keys, and otherwise in the order that they had") {
    for (const std::uint32_t materials : {1u, 4u, 0u}) {  // 0: one a primitive
        check_runs<Exact>(materials);
        check_runs<ColorCube>(materials);
        check_runs<OpacityTensor>(materials);
    }
}

TEST_CASE("an order that counts stays as it is: of samples, and of pieces in strict order") {
    const std::vector<Piece> all = pieces(2000, 4);
    using Samples = HierarchyOf<SampleSet<>>;
    CHECK(std::ranges::equal(build<Samples>(all).order(), build<Samples>(without_keys(all)).order()));
    using Bsp = SpatialHierarchy<PolygonBsp, Exact, TriangleCount>;
    CHECK(std::ranges::equal(build<Bsp>(all).order(), build<Bsp>(without_keys(all)).order()));
}

TEST_CASE("an update groups as a build does") {
    using H = HierarchyOf<ColorCube>;
    std::vector<Piece> all = pieces(4000, 4);
    BuildOptions<H> options;
    options.world = {glm::dvec3(-2), glm::dvec3(2)};
    HierarchyUpdater<H, Piece> updater(all, options);
    CHECK(std::ranges::equal(updater.hierarchy().order(), build<H>(all, options).order()));
    std::mt19937 random(9);
    for (int i = 0; i < 5; ++i) {
        std::vector<std::uint32_t> changed;
        for (std::uint32_t k = 0; k < 20; ++k) {
            changed.push_back(std::uint32_t(random() % 200 + 200 * k));
            Piece& p = all[changed.back()];
            p.material = std::uint32_t(random() % 4) * 1000;
            for (glm::vec3& v : p.vertices) v *= 0.75f;
        }
        const H& updated = updater.update(all, changed);
        const H built = build<H>(all, options);
        CHECK(std::ranges::equal(updated.order(), built.order()));
        CHECK(std::ranges::equal(updated.nodes(), built.nodes()));
        CHECK(std::ranges::equal(updated.stand_ins(), built.stand_ins()));
    }
}

TEST_CASE("a cut of four materials falls into a third of the batches that it would without keys") {
    using H = HierarchyOf<OpacityTensor>;
    const std::vector<Piece> all = pieces(60'000, 4);
    const H h = build<H>(all);
    Counter counter;
    auto viewer = make_viewer(h, all, counter);
    const View view{.camera = Camera::perspective({0, 0, 2.5}, {0, 0, 0}, {0, 1, 0}, 0.8f),
                    .width = 640,
                    .height = 480,
                    .tolerance_px = 24};
    const FrameStats stats = viewer.frame(view);
    CHECK(counter.primitives == stats.primitives);
    CHECK(counter.keys.size() == 4);
    // Three of four neighbors have another material.
    INFO(counter.batches << " batches of " << counter.ranges << " ranges, " << stats.primitives << " primitives");
    CHECK(double(counter.batches) < 0.4 * 0.75 * double(stats.primitives));
}
