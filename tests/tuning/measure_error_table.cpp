// Tables of hierarchies: what they say is what their frames err by, whatever there is to see.
#include "farfield/tuning/measure_error_table.hpp"

#include <stdexcept>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/triangle.hpp"
#include "support/scenes.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

using Tensors = SpatialHierarchy<Octree, OpacityTensor, TriangleCount>;

/// Priced, so that tests have one answer.
HierarchyErrorOptions priced() {
    HierarchyErrorOptions options;
    options.tolerances_px = tolerance_ladder(0.5f, 8);
    options.repetitions = 1;
    options.prices = MeasuredTime{};
    return options;
}

template <class H = Tensors>
ErrorTable table_of(const Triangles& triangles, const std::vector<View>& views,
                    const HierarchyErrorOptions& options = priced()) {
    const auto hierarchy = build<H>(triangles);
    ZBufferRenderer renderer;
    return measure_error_table(hierarchy, std::span<const Triangle>(triangles), renderer, views, options);
}

std::vector<View> views(double distance) {
    return {looking({0, 0, distance}, {}, 96), looking({distance, 1, 0}, {}, 96)};
}

}  // namespace

TEST_CASE("far away a tolerance keeps exact's own error and pays") {
    const Triangles triangles = random_triangles(20000, 162, 0.03f);
    const ErrorTable table = table_of(triangles, views(30));
    REQUIRE(table.trials().size() == 10);
    CHECK(table.exact_rmse() > 0);
    const ToleranceChoice choice = table.tolerance_for();
    CHECK(choice.reason == ToleranceReason::pays);
    CHECK(choice.trial.rmse <= table.exact_rmse());
    CHECK(choice.trial.cost < 0.5);
}

TEST_CASE("near, where nothing may stand in, exact is chosen") {
    const Triangles triangles = random_triangles(300, 163, 0.5f);
    const ToleranceChoice choice = table_of(triangles, {looking({0, 0, 1.5}, {}, 128)}).tolerance_for();
    CHECK(choice.is_exact());
    CHECK(choice.reason == ToleranceReason::nothing_pays);
}

TEST_CASE("prices give the same table every time, and a clock the same errors") {
    const Triangles triangles = random_triangles(3000, 164);
    HierarchyErrorOptions timed = priced();
    timed.prices.reset();
    const ErrorTable a = table_of(triangles, views(10)), b = table_of(triangles, views(10)),
                     c = table_of(triangles, views(10), timed);
    REQUIRE(a.trials().size() == b.trials().size());
    REQUIRE(a.trials().size() == c.trials().size());
    for (std::size_t i = 0; i < a.trials().size(); ++i) {
        CHECK(a.trials()[i].cost == b.trials()[i].cost);
        CHECK(a.trials()[i].rmse == b.trials()[i].rmse);
        CHECK(a.trials()[i].rmse == c.trials()[i].rmse);
        CHECK(c.trials()[i].cost > 0);
    }
}

TEST_CASE("black things err as white ones do") {
    Triangles white = random_triangles(3000, 165), black = white;
    for (Triangle& t : white) t.rgba = {255, 255, 255, 255};
    for (Triangle& t : black) t.rgba = {0, 0, 0, 255};
    const ErrorTable a = table_of(white, views(12)), b = table_of(black, views(12));
    REQUIRE(a.trials().size() == b.trials().size());
    for (std::size_t i = 0; i < a.trials().size(); ++i) {
        CHECK(b.trials()[i].rmse > 0);
        CHECK(b.trials()[i].rmse == Approx(a.trials()[i].rmse).epsilon(0.02));
    }
}

TEST_CASE("over nothing, or nothing in view, exact is all that is known") {
    for (const auto& [count, distance] : {std::pair{0, 5.0}, {0, -5.0}, {1, -5.0}, {2000, -5.0}}) {
        const Triangles triangles = random_triangles(std::size_t(count), 166);
        // Away from it all where the distance is below 0.
        const std::vector<View> looks{looking({0, 0, 5}, {0, 0, 5 - distance}, 32)};
        const ToleranceChoice choice = table_of(triangles, looks).tolerance_for();
        CHECK(choice.is_exact());
        CHECK(choice.reason == ToleranceReason::nothing_tried);
    }
}

TEST_CASE("one primitive and many equal ones have tables") {
    for (const std::size_t count : {1u, 2000u}) {
        const Triangles triangles(count, Triangle{{glm::vec3(0), glm::vec3(1, 0, 0), glm::vec3(0, 1, 0)}, {200, 0, 0}});
        for (const double distance : {2.0, 20.0, 2000.0}) {
            const ErrorTable table = table_of(triangles, views(distance));
            CHECK(table.tolerance_for().keeps_error());
            CHECK(table.tolerance_for().trial.rmse <= table.exact_rmse());
        }
    }
}

TEST_CASE("without views it is seen from all around, from near and far") {
    const Triangles triangles = moved(random_triangles(2000, 167), 3, {100, 0, 0});
    const ErrorTable table = table_of(triangles, {});
    CHECK(table.trials().size() == 10);
    CHECK(table.exact_rmse() > 0);
    CHECK(table_of(Triangles{}, {}).tolerance_for().reason == ToleranceReason::nothing_tried);

    CHECK(views_around(BoxD::empty()).empty());
    const BoxD point{glm::dvec3(1e7), glm::dvec3(1e7)};
    const std::vector<View> around = views_around(point, 100, 50);
    REQUIRE(around.size() == 4);
    for (const View& v : around) {
        v.validate();
        CHECK(v.width == 100);
        CHECK(v.camera.eye != point.lower);
    }
}

TEST_CASE("what has no stand-ins costs the same at any tolerance, so exact is chosen") {
    const Triangles triangles = random_triangles(500, 168);
    const ErrorTable table = table_of<SpatialHierarchy<Octree, Exact, TriangleCount>>(triangles, views(8));
    CHECK(table.tolerance_for().reason == ToleranceReason::nothing_pays);
    for (const ToleranceTrial& t : table.trials()) {
        CHECK(t.cost == 1);
        CHECK(t.rmse == table.exact_rmse());
    }
}

TEST_CASE("a table of several numbers of samples has the errors of a table of each") {
    const Triangles triangles = random_triangles(6000, 169, 0.05f);
    const auto hierarchy = build<Tensors>(triangles);
    const std::vector<View> looks = views(12);
    HierarchyErrorOptions options = priced();
    options.prices.reset();
    const int counts[] = {1, 4, 16};
    const auto make = [](int samples) { return ZBufferRenderer({.samples = samples}); };
    const auto measured = [&] {
        return measure_sampled_error_table(hierarchy, std::span<const Triangle>(triangles), counts, make, looks,
                                           options);
    };
    const SampledErrorTable table = measured();
    REQUIRE(table.tables().size() == 3);
    double last_rmse = 1;
    for (const ErrorsAtSamples& at : table.tables()) {
        CHECK(at.exact_cost > 0);
        CHECK(at.table.exact_rmse() < last_rmse);
        last_rmse = at.table.exact_rmse();
        ZBufferRenderer renderer({.samples = at.samples});
        const ErrorTable alone =
            measure_error_table(hierarchy, std::span<const Triangle>(triangles), renderer, looks, options);
        REQUIRE(alone.trials().size() == at.table.trials().size());
        for (std::size_t i = 0; i < alone.trials().size(); ++i) {
            CHECK(alone.trials()[i].rmse == at.table.trials()[i].rmse);
        }
    }
    // What point sampling cannot keep, more samples do.
    const double wanted = 0.5 * (table.at(4).exact_rmse() + table.at(16).exact_rmse());
    const SampleChoice fine = table.cheapest_for({wanted});
    CHECK(fine.tolerance.keeps_error());
    CHECK(fine.tolerance.trial.rmse <= wanted);
    // The picture errs by what the table says.
    const View drawn = fine.applied_to(looks[0]);
    CHECK(drawn.tolerance_px == fine.tolerance.trial.tolerance_px);
    CHECK(drawn.wanted.samples == fine.samples);
}

TEST_CASE("tables of samples over nothing say so, and numbers that do not ascend and prices are refused") {
    const Triangles none;
    const auto hierarchy = build<Tensors>(none);
    const auto make = [](int samples) { return ZBufferRenderer({.samples = samples}); };
    const std::vector<View> looks{looking({0, 0, 5}, {}, 32)};
    const auto measured = [&](const std::vector<int>& counts, const HierarchyErrorOptions& options = {}) {
        return measure_sampled_error_table(hierarchy, std::span<const Triangle>(none), counts, make, looks, options);
    };
    const SampleChoice choice = measured({1, 4}).cheapest_for();
    CHECK(choice.samples == 1);
    CHECK(choice.tolerance.reason == ToleranceReason::nothing_tried);
    CHECK(choice.tolerance.is_exact());
    for (const auto& counts : {std::vector<int>{}, {0, 1}, {1, 1}, {4, 1}}) {
        CHECK_THROWS_AS(measured(counts), std::invalid_argument);
    }
    CHECK_THROWS_AS(measured({1, 4}, priced()), std::invalid_argument);
}
