// What a renderer gets that deposits primitives: each run with the law of its cell, and in which order.
#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <map>
#include <optional>
#include <tuple>
#include <type_traits>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/instance.hpp"
#include "farfield/viewer.hpp"
#include "support/pictures.hpp"
#include "support/recorder.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

using Cubes = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
using Tensors = SpatialHierarchy<Octree, OpacityTensor, TriangleCount>;

template <class H>
H built(const Triangles& triangles) {
    if constexpr (std::is_same_v<H, Cubes>) {
        return build<H>(triangles, {.partition = Octree{}, .approximation = ColorCube{.guesses_area_law = true}});
    } else {
        return build<H>(triangles);
    }
}
using ExactHierarchy = SpatialHierarchy<Octree, Exact, TriangleCount>;

/// Leaves strewn about a wall of many triangles, and a few large ones.
Triangles leaves_and_a_wall() {
    Triangles triangles = random_triangles(9000, 200, 0.015f);
    append(triangles, sheet({-1, -1, -0.4f}, {2, 0, 0.3f}, {0, 2, 0}, 60, 60, {200, 180, 90, 255}));
    append(triangles, random_triangles(20, 201, 0.8f));
    return triangles;
}

/// Where each primitive and each cell comes in a walk front to back by the definition, and which laws are above it.
template <class H>
struct Walk {
    std::vector<std::uint32_t> place;               ///< of each primitive: that of its cell
    std::vector<std::vector<std::uint32_t>> cells;  ///< of each primitive: places of those it is in, from the root on
    std::vector<std::array<bool, 3>> laws_above;    ///< of each primitive
    std::vector<std::optional<AreaLaw>> nearest;    ///< of each primitive
    std::map<std::tuple<float, float, float>, std::vector<std::uint32_t>> places_by_center;
    std::uint32_t next = 0;

    Walk(const H& h, glm::vec4 viewpoint, std::size_t primitives)
        : place(primitives), cells(primitives), laws_above(primitives), nearest(primitives) {
        visit(h, viewpoint, 0, h.root_cell(), h.item_count(), h.root_stand_in(), {}, {}, {});
    }

  private:
    void visit(const H& h, glm::vec4 viewpoint, std::uint32_t index, const Cell& cell, std::uint32_t end,
               const typename H::stand_in_data* data, std::optional<AreaLaw> law, std::array<bool, 3> laws,
               std::vector<std::uint32_t> above) {
        const Node& node = h.nodes()[index];
        const std::uint32_t here = next++;
        above.push_back(here);
        if (data) {
            law = h.approximation_policy().area_law(*data);
            laws[std::size_t(*law)] = true;
            places_by_center[{cell.center.x, cell.center.y, cell.center.z}].push_back(here);
        }
        const std::uint32_t own_end = node.child_mask ? h.nodes()[node.first_child].first_item : end;
        for (std::uint32_t at = node.first_item; at < own_end; ++at) {
            const std::uint32_t primitive = h.order()[at];
            place[primitive] = here;
            cells[primitive] = above;
            laws_above[primitive] = laws;
            nearest[primitive] = law;
        }
        if (node.child_mask == 0) return;
        std::array<std::uint32_t, 8> child_node{}, child_end{};
        std::array<const typename H::stand_in_data*, 8> child_data{};
        std::uint32_t rank = 0, data_rank = 0, last = 8;
        for (std::uint32_t c = 0; c < 8; ++c) {
            if ((node.child_mask >> c & 1) == 0) continue;
            child_node[c] = node.first_child + rank++;
            if (node.stand_in_mask >> c & 1) child_data[c] = &h.stand_ins()[node.first_child_data + data_rank++];
            if (last < 8) child_end[last] = h.nodes()[child_node[c]].first_item;
            child_end[c] = end;
            last = c;
        }
        ChildOrder order{0, 1, 2, 3, 4, 5, 6, 7};
        h.partition_policy().front_to_back(cell, h.data_of(index), viewpoint, order);
        for (const unsigned c : order) {
            if ((node.child_mask >> c & 1) == 0) continue;
            visit(h, viewpoint, child_node[c], h.partition_policy().child(cell, h.data_of(index), c), child_end[c],
                  child_data[c], law, laws, above);
        }
    }
};

std::vector<View> views() {
    return {looking({0.3, 0.1, 2.2}, {0, 0, 0}, 128, 1), looking({4, 3, 5}, {0, 0, 0}, 128, 1),
            looking({12, -5, 9}, {0, 0, 0}, 128, 1), looking({0.1, 0.2, 0.3}, {1, 0, 0}, 128, 1),
            looking_orthographic({3, 4, 5}, {}, 4, 128, 1)};
}

template <class H>
void check_runs() {
    const Triangles triangles = leaves_and_a_wall();
    const H h = built<H>(triangles);
    std::size_t with_law = 0, behind_stand_ins = 0;
    std::array<std::size_t, 3> by_law{};
    for (const View& view : views()) {
        INFO("eye at " << view.camera.eye.x);
        Recorder recorder;
        recorder.deposits = true;
        recorder.largest_splat = 100;
        const FrameStats stats = make_viewer(h, triangles, recorder).frame(view);
        CHECK(stats.primitives == recorder.draws.size());
        CHECK(stats.runs == recorder.ranges);
        const Walk<H> walk(h, local_view<Triangle>(triangles, view).viewpoint(), triangles.size());
        std::size_t wrong_law = 0, out_of_order = 0, wrong_side = 0;
        std::uint32_t farthest = 0;
        for (std::size_t i = 0; i < recorder.draws.size(); ++i) {
            const auto& draw = recorder.draws[i];
            const std::uint32_t p = draw.primitive;
            // A few primitives, whose cells are not gone through one by one, have the law of what holds them all.
            wrong_law += draw.law ? !walk.laws_above[p][std::size_t(*draw.law)] : walk.nearest[p].has_value();
            if (!draw.law) continue;
            ++with_law;
            ++by_law[std::size_t(*draw.law)];
            // Of cells with more than 32 primitives each comes after those in front of it.
            if (i >= 32) farthest = std::max(farthest, walk.place[recorder.draws[i - 32].primitive]);
            out_of_order += walk.place[p] < farthest;
        }
        CHECK(wrong_law == 0);
        CHECK(out_of_order == 0);
        if constexpr (std::is_same_v<H, Cubes>) {
            // A cube's splat lies at its center.
            std::vector<std::uint32_t> place_of_splat;
            for (const Splat& s : recorder.splats) {
                const auto at = walk.places_by_center.find({s.center.x, s.center.y, s.center.z});
                REQUIRE(at != walk.places_by_center.end());
                REQUIRE(at->second.size() == 1);
                place_of_splat.push_back(at->second[0]);
            }
            CHECK(std::is_sorted(place_of_splat.begin(), place_of_splat.end()));
            for (const auto& draw : recorder.draws) {
                if (!draw.law) continue;
                const std::uint32_t place = walk.place[draw.primitive];
                const std::size_t in_front = std::size_t(
                    std::lower_bound(place_of_splat.begin(), place_of_splat.end(), place) - place_of_splat.begin());
                wrong_side += in_front != draw.splats_before;
                behind_stand_ins += in_front != 0;
            }
            CHECK(wrong_side == 0);
        }
    }
    CHECK(with_law > 20000);
    CHECK(by_law[std::size_t(AreaLaw::independent)] > 1000);
    CHECK(by_law[std::size_t(AreaLaw::coherent)] > 1000);
    if (std::is_same_v<H, Cubes>) CHECK(behind_stand_ins > 1000);
}

/// What a recorder was given, laws left out.
template <class H>
auto drawn(const H& h, const Triangles& triangles, const View& view, bool deposits) {
    Recorder recorder;
    recorder.deposits = deposits;
    recorder.largest_splat = 2;
    make_viewer(h, triangles, recorder).frame(view);
    return recorder;
}

}  // namespace

TEST_CASE("runs carry the law of a cell they are in and come front to back, in order with stand-ins") {
    check_runs<Cubes>();
    check_runs<Tensors>();
}

TEST_CASE("every cell below the root has a law where the root has a stand-in, drawn or not") {
    const Triangles triangles = random_triangles(5000, 202, 0.02f);
    const Cubes h = built<Cubes>(triangles);
    REQUIRE(h.root_stand_in() != nullptr);
    const Recorder recorder = drawn(h, triangles, looking({0.2, 0.1, 1.5}, {}, 128, 0.01f), true);
    CHECK(recorder.splats.empty());
    CHECK(recorder.draws.size() > 1000);
    CHECK(std::all_of(recorder.draws.begin(), recorder.draws.end(), [](const auto& d) { return d.law.has_value(); }));
}

TEST_CASE(
    "no run has a law without tolerance, without a renderer that asks for it, or of a hierarchy that knows none") {
    const Triangles triangles = leaves_and_a_wall();
    const Cubes cubes = built<Cubes>(triangles);
    const Cubes silent_cubes = build<Cubes>(triangles);
    const ExactHierarchy exact = build<ExactHierarchy>(triangles);
    const auto without = [](const Recorder& r) {
        return std::none_of(r.draws.begin(), r.draws.end(), [](const auto& d) { return d.law.has_value(); });
    };
    const auto same = [](const Recorder& a, const Recorder& b) {
        return a.ranges == b.ranges && std::equal(a.draws.begin(), a.draws.end(), b.draws.begin(), b.draws.end(),
                                                  [](const auto& x, const auto& y) {
                                                      return x.primitive == y.primitive &&
                                                             x.splats_before == y.splats_before;
                                                  });
    };
    for (View view : views()) {
        CHECK(without(drawn(cubes, triangles, view, false)));
        CHECK(without(drawn(silent_cubes, triangles, view, true)));
        const Recorder asked = drawn(exact, triangles, view, true), silent = drawn(exact, triangles, view, false);
        CHECK(without(asked));
        CHECK(same(asked, silent));
        view.tolerance_px = 0;
        const Recorder whole = drawn(cubes, triangles, view, true);
        CHECK(without(whole));
        CHECK(same(whole, drawn(cubes, triangles, view, false)));
    }
}

TEST_CASE("the same primitives come with laws as without, but for some that are out of sight") {
    const Triangles triangles = leaves_and_a_wall();
    const Cubes h = built<Cubes>(triangles);
    for (const View& view : views()) {
        const auto sorted = [&](bool deposits) {
            std::vector<std::uint32_t> out;
            for (const auto& d : drawn(h, triangles, view, deposits).draws) out.push_back(d.primitive);
            std::sort(out.begin(), out.end());
            return out;
        };
        const std::vector<std::uint32_t> with = sorted(true), without = sorted(false);
        std::vector<std::uint32_t> missing;
        std::set_difference(without.begin(), without.end(), with.begin(), with.end(), std::back_inserter(missing));
        CHECK(with.size() + missing.size() == without.size());
        const LocalView local = local_view<Triangle>(triangles, view);
        const auto in_sight = std::count_if(missing.begin(), missing.end(), [&](std::uint32_t p) {
            const Box b = triangles[p].bounds();
            return crossed_planes(local.planes, b.center(), b.size() * 0.5f, all_planes) != outside_a_plane;
        });
        CHECK(in_sight == 0);
    }
}
