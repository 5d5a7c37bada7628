#include "farfield/wanted_error.hpp"

#include <vector>

#include "catch.hpp"
#include "farfield/approximation/area_splat.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/color_cube_cluster.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "support/scenes.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

using ExactOctree = SpatialHierarchy<Octree, Exact, TriangleCount>;
using Cubes = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
using Clusters = SpatialHierarchy<Octree, ColorCubeCluster<4>, TriangleCount>;
using Splats = SpatialHierarchy<Octree, AreaSplat, TriangleCount>;
using Tensors = SpatialHierarchy<Octree, OpacityTensor, TriangleCount>;

template <class H>
struct Drawn {
    FrameStats stats;
    std::vector<Rgba8> pixels;

    Drawn(const H& h, const Triangles& triangles, View view, WantedError wanted) {
        ZBufferRenderer renderer;
        view.wanted = wanted;
        stats = make_viewer(h, triangles, renderer).frame(view);
        pixels.assign(renderer.image().pixels().begin(), renderer.image().pixels().end());
    }
};

}  // namespace

TEST_CASE("point sampling errs less where things are large, and with more samples") {
    for (const float covered : {0.05f, 0.3f, 1.0f}) {
        for (float side = 0.25f; side < 100; side *= 2) {
            CHECK(point_sampling_rmse(2 * side, covered, 1) < point_sampling_rmse(side, covered, 1));
            CHECK(point_sampling_rmse(side, covered, 4) < 0.6f * point_sampling_rmse(side, covered, 1));
        }
    }
    CHECK(point_sampling_rmse(1, 0, 1) == 0);
    CHECK(largest_rmse({}, 2, 0.5f) == point_sampling_rmse(2, 0.5f, 1));
    CHECK(largest_rmse({.samples = 16}, 2, 0.5f) == point_sampling_rmse(2, 0.5f, 16));
    CHECK(largest_rmse({.rmse = 0.25}, 2, 0.5f) == 0.25f);
}

TEST_CASE("stand-ins are expected to err more the larger they are and the more they cover, cubes more than tensors") {
    const ColorCube cube;
    const OpacityTensor tensor;
    for (const float covered : {0.05f, 0.3f, 0.8f}) {
        for (float side = 0.5f; side < 100; side *= 2) {
            CHECK(cube.expected_rmse(2 * side, covered) > cube.expected_rmse(side, covered));
            CHECK(tensor.expected_rmse(2 * side, covered) > tensor.expected_rmse(side, covered));
            CHECK(tensor.expected_rmse(side, 1.2f * covered) > tensor.expected_rmse(side, covered));
            if (side >= 1) CHECK(cube.expected_rmse(side, covered) > tensor.expected_rmse(side, covered));
        }
    }
}

TEST_CASE("area splats are expected to err as cubes do, clusters less") {
    for (const float covered : {0.05f, 0.3f, 0.8f}) {
        for (const float side : {0.5f, 1.0f, 4.0f}) {
            CHECK(ColorCubeCluster<4>().expected_rmse(side, covered) < ColorCube().expected_rmse(side, covered));
            CHECK(AreaSplat().expected_rmse(side, covered) == ColorCube().expected_rmse(side, covered));
        }
    }
}

TEST_CASE("the part of a cell that is covered is known from any direction") {
    // A plate across a cell, seen squarely and on edge; both approximations are asked in the same words.
    Triangles plate = sheet({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 24, 24, {200, 80, 40, 255});
    const auto covered = [&](auto approximation, glm::dvec3 eye) {
        using H = SpatialHierarchy<Octree, decltype(approximation), TriangleCount>;
        const H h = build<H>(plate);
        REQUIRE(h.root_stand_in() != nullptr);
        const LocalView view(looking(eye), h.origin(), h.bounds());
        return detail::covered_part(approximation, *h.root_stand_in(), h.pool(), h.root_cell(), view);
    };
    const float square = covered(OpacityTensor{}, {0.01, 0, 40}), cube_square = covered(ColorCube{}, {0.01, 0, 40});
    CHECK((square > 0.2f && square <= 1));
    CHECK(cube_square == Approx(square).epsilon(0.3));
    CHECK(covered(AreaSplat{}, {0.01, 0, 40}) == Approx(square).epsilon(0.3));
    CHECK(covered(AreaSplat{}, {40, 0, 0.01}) < 0.1f * square);
    CHECK(covered(AreaSplat{.size = AreaSplat::Size::of_cell}, {0.01, 0, 40}) == 1);
    const float cluster_square = covered(ColorCubeCluster<4>{}, {0.01, 0, 40});
    CHECK(cluster_square == Approx(square).epsilon(0.5));
    CHECK(covered(ColorCubeCluster<4>{}, {40, 0, 0.01}) < 0.5f * cluster_square);
    CHECK(covered(OpacityTensor{}, {40, 0, 0.01}) < 0.1f * square);
    CHECK(covered(ColorCube{}, {40, 0, 0.01}) < 0.2f * square);
}

TEMPLATE_TEST_CASE("the less error is wanted, the less stands in", "", Cubes, Clusters, Splats, Tensors) {
    const Triangles triangles = random_triangles(20000, 720, 0.01f);
    const auto h = build<TestType>(triangles);
    const View view = looking({6, 2, 4}, {}, 128, 16);
    const Drawn<TestType> freely(h, triangles, view, WantedError::any());
    REQUIRE(freely.stats.approximations > 0);
    CHECK(freely.stats.cells_too_coarse == 0);
    std::uint64_t primitives = freely.stats.primitives;
    for (const double rmse : {1e9, 0.5, 0.3, 0.2, 0.1, 0.05, 0.02}) {
        const Drawn<TestType> drawn(h, triangles, view, WantedError{.rmse = rmse});
        CHECK(drawn.stats.primitives >= primitives);
        primitives = drawn.stats.primitives;
    }
    const Drawn<TestType> none(h, triangles, view, WantedError{.rmse = 0});
    CHECK(none.stats.approximations == 0);
    CHECK(none.stats.is_exact());
    CHECK(none.stats.cells_too_coarse > 0);
    CHECK(none.stats.primitives == triangles.size());
}

TEMPLATE_TEST_CASE("an error that cannot be had with so few samples is said to be one", "", Cubes, Clusters, Splats,
                   Tensors) {
    const Triangles triangles = random_triangles(20000, 720, 0.01f);
    const auto h = build<TestType>(triangles);
    const View view = looking({6, 2, 4}, {}, 128, 16);
    const auto needing_samples = [&](WantedError wanted) {
        return Drawn<TestType>(h, triangles, view, wanted).stats.cells_needing_samples;
    };
    CHECK(needing_samples(WantedError::any()) == 0);
    CHECK(needing_samples(WantedError{}) == 0);  // what primitives err by is what is wanted
    CHECK(needing_samples({.rmse = 0.5}) == 0);
    CHECK(needing_samples({.rmse = 0.01}) > 0);
    CHECK(needing_samples({.rmse = 0.01, .samples = 1024}) == 0);
    CHECK(needing_samples({.rmse = 0, .samples = 1024}) > 0);
}

TEMPLATE_TEST_CASE("where it costs less and no more is wanted than point sampling gives, exact is drawn, byte for byte",
                   "", Cubes, Tensors) {
    const Triangles triangles = random_triangles(20000, 721, 0.01f);
    const auto h = build<TestType>(triangles);
    const ExactOctree exact = build<ExactOctree>(triangles);
    const auto drawn_from = [&](double distance) {
        const View view = looking(glm::dvec3(0.6, 0.2, 0.4) * distance, {}, 128, 4);
        const Drawn<TestType> chosen(h, triangles, view, WantedError{});
        View exactly = view;
        exactly.tolerance_px = 0;
        if (chosen.stats.is_exact()) {
            CHECK(chosen.pixels == Drawn<ExactOctree>(exact, triangles, exactly, WantedError::any()).pixels);
            CHECK(chosen.stats.cells_cheaper > 0);
        }
        return chosen.stats;
    };
    // Some ten triangles a pixel, of which most meet no sample; and far more than that.
    CHECK(drawn_from(8).is_exact());
    const FrameStats far = drawn_from(400);
    CHECK(!far.is_exact());
    CHECK(far.primitives < triangles.size());
}

TEST_CASE("small triangles are point sampled where that is good enough") {
    const Triangles triangles = random_triangles(20000, 722, 0.002f);
    const Tensors h = build<Tensors>(triangles);
    const View view = looking({6, 2, 4}, {}, 128, 0.01f);
    const Drawn<Tensors> deposited(h, triangles, view, WantedError::any()), sampled(h, triangles, view, WantedError{});
    const Drawn<Tensors> deposited_too(h, triangles, view, WantedError{.rmse = 0.01});
    CHECK(deposited.pixels == deposited_too.pixels);
    CHECK(deposited.pixels != sampled.pixels);
    CHECK(sampled.pixels == Drawn<Tensors>(h, triangles, looking({6, 2, 4}, {}, 128, 0), WantedError::any()).pixels);
}
