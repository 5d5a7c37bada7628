// The advice is the cheapest trial that keeps the error on views it was not chosen by.
#include "farfield/tuning/advise.hpp"

#include <stdexcept>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/primitive/triangle.hpp"
#include "support/pictures.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

const auto variants = variants_of(std::tuple{Named{"", Octree{}}, Named{"shared", SharedOctree{}}},
                                  std::tuple{Named{"exact", Exact{}}, Named{"color-cube", ColorCube{}}},
                                  std::tuple{Named{"", TriangleCount{}}});

/// Priced, so that the test has one answer.
AdviceOptions priced() {
    AdviceOptions options;
    options.tolerances_px = {0.5f, 1, 4};
    options.samples = {1};
    options.prices = MeasuredTime{};
    return options;
}

std::vector<View> views(double distance) {
    return {looking({0, 0, distance}, {}, 96), looking({distance, 1, 0}, {}, 96), looking({-distance, 2, 1}, {}, 96),
            looking({0, -distance, 1}, {}, 96)};
}

}  // namespace

TEST_CASE("every variant is tried with every tolerance, exact ones once") {
    const Triangles triangles = random_triangles(5000, 160);
    const Advice advice = advise<Triangle>(triangles, views(20), 0.05, variants, priced());
    CHECK(advice.trials.size() == 2 * 1 + 2 * 3);
    for (std::size_t i = 0; i + 1 < advice.trials.size(); ++i) {
        CHECK(advice.trials[i].cost <= advice.trials[i + 1].cost);
    }
    for (const Trial& t : advice.trials) {
        INFO(t.variant << " at " << t.tolerance_px << " px");
        CHECK(t.cost > 0);
        CHECK(t.hierarchy_bytes > 0);
        if (t.variant == "exact") CHECK(t.cost == 1);
    }
}

TEST_CASE("the chosen trial keeps the error on all views, and no cheaper one does") {
    const Triangles triangles = random_triangles(20000, 161, 0.03f);
    for (const double distance : {3.0, 12.0, 60.0}) {
        for (const double largest : {0.005, 0.02, 0.1}) {
            INFO("distance " << distance << ", error " << largest);
            const Advice advice = advise<Triangle>(triangles, views(distance), largest, variants, priced());
            if (!advice.chosen) {
                for (const Trial& t : advice.trials) CHECK(!t.keeps(largest));
                continue;
            }
            CHECK(advice.chosen->rmse_chosen_by <= largest);
            CHECK(advice.chosen->rmse_held_out <= largest);
            for (const Trial& t : advice.trials) {
                if (t.cost < advice.chosen->cost) CHECK(!t.keeps(largest));
            }
        }
    }
}

TEST_CASE("far away stand-ins are advised, and near with a small error none is") {
    const Triangles triangles = random_triangles(20000, 162, 0.03f);
    const Advice far = advise<Triangle>(triangles, views(60), 0.1, variants, priced());
    REQUIRE(far.chosen);
    CHECK(far.chosen->variant.substr(0, 10) == "color-cube");
    CHECK(far.chosen->cost < 0.5);
    const Advice none = advise<Triangle>(triangles, views(3), 1e-9, variants, priced());
    CHECK(!none.chosen);
}

TEST_CASE("a variant that is cheap on the views it is chosen by and wrong on the others is not advised") {
    // Nothing is seen from the first view, so that it costs nothing and is right; the second sees everything.
    const Triangles triangles = sphere({0, 0, 0}, 1, 60, {200, 120, 40});
    std::vector<View> pair{looking({0, 0, 30}, {0, 0, 60}, 64), looking({0.5, 0.7, 4}, {}, 64)};
    AdviceOptions options = priced();
    options.tolerances_px = {1000};
    const auto cubes = variants_of(std::tuple{Named{"", Octree{}}},
                                   std::tuple{Named{"color-cube", ColorCube{}}, Named{"exact", Exact{}}},
                                   std::tuple{Named{"", TriangleCount{}}});
    Advice advice = advise<Triangle>(triangles, pair, 0.1, cubes, options);
    REQUIRE(advice.chosen);
    CHECK(advice.chosen->variant == "exact");
    CHECK(advice.trials.front().rmse_chosen_by == 0);
}

TEST_CASE("prices give the same advice every time; with a clock the trials are the same but for their cost") {
    const Triangles triangles = random_triangles(3000, 164);
    const auto a = advise<Triangle>(triangles, views(10), 0.05, variants, priced());
    const auto b = advise<Triangle>(triangles, views(10), 0.05, variants, priced());
    REQUIRE(a.trials.size() == b.trials.size());
    for (std::size_t i = 0; i < a.trials.size(); ++i) {
        CHECK(a.trials[i].variant == b.trials[i].variant);
        CHECK(a.trials[i].cost == b.trials[i].cost);
        CHECK(a.trials[i].rmse_held_out == b.trials[i].rmse_held_out);
    }
    AdviceOptions timed = priced();
    timed.prices.reset();
    timed.repetitions = 1;
    const auto c = advise<Triangle>(triangles, views(10), 0.05, variants, timed);
    CHECK(c.trials.size() == a.trials.size());
    for (const Trial& t : c.trials) CHECK(t.cost > 0);
}

TEST_CASE("advice over no, one or many equal primitives, and bad questions") {
    for (const std::size_t count : {0u, 1u, 2000u}) {
        const Triangles triangles(count, Triangle{{glm::vec3(0), glm::vec3(1, 0, 0), glm::vec3(0, 1, 0)}, {200, 0, 0}});
        const Advice advice = advise<Triangle>(triangles, views(5), 0.2, variants, priced());
        REQUIRE(advice.chosen);
        for (const Trial& t : advice.trials) CHECK(t.rmse_held_out == t.rmse_held_out);
    }
    const Triangles triangles = random_triangles(10, 165);
    const auto some = views(5);
    CHECK_THROWS_AS(advise<Triangle>(triangles, std::span(some).first(1), 0.1, variants), std::invalid_argument);
    CHECK_THROWS_AS(advise<Triangle>(triangles, some, 0, variants), std::invalid_argument);
    CHECK_THROWS_AS(advise<Triangle>(triangles, some, std::nan(""), variants), std::invalid_argument);
    AdviceOptions nothing = priced();
    nothing.samples.clear();
    CHECK_THROWS_AS(advise<Triangle>(triangles, some, 0.1, variants, nothing), std::invalid_argument);
}
